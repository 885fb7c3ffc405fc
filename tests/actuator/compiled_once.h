// What several tests compile alike is compiled once, in the build folder under a name made of all that goes into it.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "lake/actuator/firmware.h"
#include "lake/core/atomic_file.h"
#include "lake/core/provenance.h"
#include "places.h"

namespace lake {

// The firmware with this table and `others` (to the name, what else is compiled) compiled by a shell command
// that makes `product` in its folder. Throws if it fails.
inline std::filesystem::path CompiledOnce(actuator::Feedback feedback, const std::string& stroke_table,
                                          const std::string& command, const std::string& product,
                                          const std::string& others = "") {
  const std::vector<actuator::FirmwareFile> sources = actuator::SketchSources(feedback);
  std::string all = stroke_table + command + others;
  for (const actuator::FirmwareFile& file : sources) all += file.name + file.text;
  const std::filesystem::path cache = BinDir().parent_path() / "firmware",
                              folder = cache / Sha256OfText(all).substr(0, 20);
  if (std::filesystem::exists(folder / product)) return folder / product;
  // Made aside, then named at once: tests run side by side.
  const std::filesystem::path aside = folder.string() + "-" + std::to_string(getpid());
  std::filesystem::create_directories(aside);
  WriteTextFile(aside / "stroke_table.h", stroke_table);
  for (const actuator::FirmwareFile& file : sources) WriteTextFile(aside / file.name, file.text);
  if (std::system(("cd " + Quoted(aside) + " && " + command).c_str()) != 0)
    throw std::runtime_error("it does not compile in " + aside.string() + ": " + command);
  std::error_code made_by_another;
  std::filesystem::rename(aside, folder, made_by_another);
  if (made_by_another) std::filesystem::remove_all(aside);
  return folder / product;
}

}  // namespace lake
