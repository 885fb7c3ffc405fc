// What a program prints arrives, or the program has failed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/program_run.h"

namespace lake {
namespace {

using testing::HasSubstr;

// Short texts, which wait in a buffer until the end, and those that do not.
TEST(StandardOutput, ThatIsFullIsAnError) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "trial.csv", "frame,time_s,knee_x_mm,knee_y_mm\n0,0,1,2\n1,0.1,1,2\n");
  for (const char* command :
       {"lake-info trial.csv", "lake-info trial.csv --json", "lake-gait --version", "lake-track --help",
        "lake --version", "lake --help", "lake-track --help-man", "lake --completion bash",
        "lake-simulate --links 85,85,85,80,80,235 --no-animation --quiet --json"}) {
    const Outcome full = Shell(folder, std::string(command) + " > /dev/full");
    EXPECT_EQ(full.exit_code, 1) << command;
    EXPECT_THAT(full.err, HasSubstr("No space left on device")) << command;
    EXPECT_EQ(full.ErrorLines(), 1) << full.err;
    EXPECT_EQ(Shell(folder, command).exit_code, 0) << command;
  }
  EXPECT_EQ(Shell(folder, "lake-info trial.csv >&-").exit_code, 1) << "closed";
}

}  // namespace
}  // namespace lake
