// The built programs, run as a user runs them.
#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>

#include "lake/core/atomic_file.h"
#include "lake/core/json.h"
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

// The same where it must end well: a test ends with what it says otherwise.
inline Outcome Done(const TemporaryFolder& folder, const std::string& command) {
  Outcome outcome = Shell(folder, command);
  if (outcome.exit_code != 0)
    throw std::runtime_error(fmt::format("{}: exit code {}: {}", command, outcome.exit_code, outcome.err));
  return outcome;
}

// The value that it prints then.
inline Json DoneJson(const TemporaryFolder& folder, const std::string& command) {
  return Json::parse(Done(folder, command).out);
}

// A command that is refused, in one line beside warnings.
inline Outcome ExpectRefused(const TemporaryFolder& folder, const std::string& command, int exit_code,
                             const std::string& text) {
  Outcome outcome = Shell(folder, command);
  EXPECT_EQ(outcome.exit_code, exit_code) << command << ": " << outcome.err;
  EXPECT_THAT(outcome.err, ::testing::HasSubstr(text)) << command;
  std::istringstream lines(outcome.err);
  int said = 0;
  for (std::string line; std::getline(lines, line);) said += line.find(": warning: ") == line.npos;
  EXPECT_EQ(said, 1) << command << ": " << outcome.err;
  return outcome;
}

// A recording of 3 s in folder/good: that which ctest had rendered for all tests of this kind, else one of its own.
inline void RenderShort(const TemporaryFolder& folder) {
  namespace fs = std::filesystem;
  const fs::path shared = BinDir().parent_path() / "recordings/short_recording";
  if (!fs::exists(shared / "summary.json"))
    Done(folder, "lake-synth -o good --duration 3 --rate 30 --width 720 --crf 23 --quiet");
  else
    fs::copy(shared, folder / "good", fs::copy_options::recursive);
}

inline std::size_t FilesIn(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) return 0;
  return static_cast<std::size_t>(std::distance(std::filesystem::recursive_directory_iterator(folder), {}));
}

}  // namespace lake
