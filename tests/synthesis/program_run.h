// lake-optimize run as a user runs it.
#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

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

}  // namespace lake
