// lake-optimize run as a user runs it.
#pragma once

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "places.h"

namespace lake {

struct Ended {
  int exit_code;
  std::string text;  // stdout and stderr
};

inline Ended RunProgram(const std::string& arguments) {
  const std::string command = Quoted(BinDir() / "lake-optimize") + " " + arguments + " 2>&1";
  Ended ended{-1, ""};
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> buffer{};
  while (pipe && std::fgets(buffer.data(), buffer.size(), pipe)) ended.text += buffer.data();
  if (pipe) ended.exit_code = WEXITSTATUS(pclose(pipe));
  return ended;
}

struct Refusal {
  std::string arguments;
  int exit_code;
  std::string text;
};

// Each is refused in one line with this text, and nothing is written to the folder.
inline void ExpectRefused(const std::vector<Refusal>& refusals, const std::filesystem::path& out) {
  for (const auto& [arguments, exit_code, text] : refusals) {
    const Ended ended = RunProgram(arguments + " --quiet -o " + out.string());
    EXPECT_EQ(ended.exit_code, exit_code) << arguments << ": " << ended.text;
    EXPECT_THAT(ended.text, testing::HasSubstr(text)) << arguments;
    EXPECT_EQ(std::ranges::count(ended.text, '\n'), 1) << ended.text;
    EXPECT_FALSE(std::filesystem::exists(out)) << arguments;
  }
}

}  // namespace lake
