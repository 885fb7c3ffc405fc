// A library that calls abort(), as some do for want of memory: the program says what happened, and ends with 1.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "program.h"

namespace lake {
namespace {

TEST(LastWords, AreSaidWhenALibraryAborts) {
  CLI::App cli("does something", "lake-x");
  std::string name = "lake-x";
  char* arguments[] = {name.data(), nullptr};
  EXPECT_EXIT(ParseAndRun(cli, {}, 1, arguments, []() -> int { std::abort(); }), testing::ExitedWithCode(1),
              "^lake-x: a library gave up; too little memory is the usual reason .*--threads 1 less is needed\n$");
}

}  // namespace
}  // namespace lake
