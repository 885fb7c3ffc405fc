// The built programs, run as a user runs them.
#pragma once

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "lake/core/atomic_file.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {

struct Outcome {
  int exit_code = 0;
  std::string out, err;

  std::ptrdiff_t ErrorLines() const { return std::count(err.begin(), err.end(), '\n'); }
};

// What the shell makes of a command line in this folder.
inline Outcome Shell(const TemporaryFolder& folder, const std::string& command) {
  const std::string line = fmt::format("cd {} && export PATH={}:$PATH && ({}) >out.txt 2>err.txt",
                                       Quoted(folder.Path()), Quoted(BinDir()), command);
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), ReadTextFile(folder / "out.txt"),
          ReadTextFile(folder / "err.txt")};
}

// A recording of 3 s in folder/good: that which ctest had rendered for all tests of this kind, else one of its own.
inline Outcome RenderShort(const TemporaryFolder& folder) {
  namespace fs = std::filesystem;
  const fs::path shared = BinDir().parent_path() / "recordings/short_recording";
  if (!fs::exists(shared / "summary.json"))
    return Shell(folder, "lake-synth -o good --duration 3 --rate 30 --width 720 --crf 23 --quiet");
  fs::copy(shared, folder / "good", fs::copy_options::recursive);
  return {};
}

inline std::size_t FilesIn(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) return 0;
  return static_cast<std::size_t>(std::distance(std::filesystem::recursive_directory_iterator(folder), {}));
}

}  // namespace lake
