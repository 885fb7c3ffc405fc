// Options from a file: what it says is used, or is an error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/program_run.h"
#include "lake/core/json.h"

namespace lake {
namespace {

using testing::HasSubstr;

class ConfigFile : public testing::Test {
 protected:
  // A program that draws nothing.
  Outcome Simulate(const std::string& options) {
    return Shell(folder_, "lake-simulate --links 85,85,85,80,80,235 --no-animation --quiet -o out " + options);
  }

  void ExpectRefused(const std::string& program, const std::string& text, const std::string& message) {
    WriteTextFile(folder_ / "options.toml", text);
    const Outcome outcome = Shell(folder_, program + " --config options.toml");
    EXPECT_EQ(outcome.exit_code, 2) << text;
    EXPECT_THAT(outcome.err, HasSubstr("options.toml: " + message)) << text;
    EXPECT_EQ(outcome.ErrorLines(), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  }

  TemporaryFolder folder_;
};

TEST_F(ConfigFile, StandsBelowTheCommandLine) {
  WriteTextFile(folder_ / "options.toml", "pin-diameter = 12\nbar-width = 40\n");
  const Outcome outcome = Simulate("--config options.toml --bar-width 42 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json options = Json::parse(outcome.out)["options"];
  EXPECT_EQ(options["pin-diameter"], "12");
  EXPECT_EQ(options["bar-width"], "42");
}

TEST_F(ConfigFile, WithWhatIsNoOptionIsRefused) {
  const std::string simulate = "lake-simulate --links 85,85,85,80,80,235 -o out";
  ExpectRefused(simulate, "pin-diamter = 12\n", "there is no option 'pin-diamter'");
  ExpectRefused(simulate, "pin-diameter = 12\nbar-width = 40\npin-diameter = 8\n", "'pin-diameter' stands twice");
  ExpectRefused(simulate, "[calibrate]\nmarkers = 3\n", "there is no command 'calibrate'");
  ExpectRefused("lake-stroke -o out", "[calibrate]\nthresh = 3\n", "there is no option 'calibrate.thresh'");
  EXPECT_EQ(Shell(folder_, simulate + " --config absent.toml").exit_code, 2);
}

}  // namespace
}  // namespace lake
