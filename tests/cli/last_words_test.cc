// A library that calls abort(), as some do for want of memory: the program says what happened, and ends with 1.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <stdexcept>

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

// An exception of a library is no message: its words name files of its own sources.
TEST(LastWords, ALibrarysExceptionIsOneLineInOurWords) {
  CLI::App cli("does something", "lake-x");
  std::string name = "lake-x";
  char* arguments[] = {name.data(), nullptr};
  testing::internal::CaptureStderr();
  const int code = ParseAndRun(cli, {}, 1, arguments, []() -> int {
    throw std::runtime_error(
        "OpenCV(4.6.0) ./modules/imgproc/src/resize.cpp:4058: error: (-215:Assertion failed) !dsize.empty() in "
        "function "
        "'resize'\n");
  });
  EXPECT_EQ(code, 1);
  EXPECT_EQ(
      testing::internal::GetCapturedStderr(),
      "lake-x: a library failed at this input (OpenCV, 'resize'): is the input damaged, or of an unusual size? If "
      "it is neither, please report this together with the input\n");
}

}  // namespace
}  // namespace lake
