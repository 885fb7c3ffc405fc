// What a program prints arrives, or the program has failed.
#include <gmock/gmock.h>

#include "cli/program_run.h"
#include "places.h"

namespace lake {
namespace {

// Short texts, which wait in a buffer until the end, and those that do not.
TEST(StandardOutput, ThatIsFullIsAnError) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "trial.csv", "frame,time_s,knee_x_mm,knee_y_mm\n0,0,1,2\n1,0.1,1,2\n");
  for (const std::string& command :
       {std::string("lake-info trial.csv"), std::string("lake-info trial.csv --json"),
        std::string("lake-gait --version"), std::string("lake-gait --help"), std::string("lake --version"),
        std::string("lake --help"),
        fmt::format("lake-export '{}/data/sts-study/worn.yaml' dxf --quiet -o out --json", SourceDir().string())}) {
    ExpectRefused(folder, command + " > /dev/full", 1, ": stdout: cannot ");
  }
  Done(folder, "lake-info trial.csv");
  EXPECT_EQ(Shell(folder, "lake-info trial.csv >&-").exit_code, 1) << "closed";
}

}  // namespace
}  // namespace lake
