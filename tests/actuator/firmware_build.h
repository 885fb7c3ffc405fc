// Compiles the firmware as a user does.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "lake/actuator/firmware.h"
#include "lake/core/atomic_file.h"

namespace lake {

// The published links (Gautam, Singla & Singla, table 1).
inline constexpr Links kPublishedLinks = {59.081, 68.840, 55.964, 71.849, 118.630, 287.310};

inline std::filesystem::path BuildFirmware(const std::filesystem::path& folder, const std::string& stroke_table,
                                           const std::string& flags) {
#ifdef LAKE_AVR_GCC
  std::filesystem::create_directories(folder);
  WriteTextFile(folder / "stroke_table.h", stroke_table);
  for (const FirmwareFile& file : FirmwareSources()) WriteTextFile(folder / file.name, file.text);
  const std::string line = "cd '" + folder.string() + "' && timeout 60 " + LAKE_AVR_GCC +
                           " -mmcu=atmega328p -std=gnu99 -Os -Wall -Wextra -Werror " + flags + " *.c -o firmware.elf";
  if (std::system(line.c_str()) != 0) throw std::runtime_error("avr-gcc failed in " + folder.string());
  return folder / "firmware.elf";
#else
  (void)stroke_table, (void)flags;
  return folder;
#endif
}

}  // namespace lake
