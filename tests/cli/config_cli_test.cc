// Options from a file: what it says is used, or is an error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/program_run.h"
#include "lake/core/json.h"
#include "places.h"

namespace lake {
namespace {

using testing::HasSubstr;

class ConfigFile : public testing::Test {
 protected:
  static std::string Export() {
    return fmt::format("lake-export '{}/data/sts-study/worn.yaml' dxf --quiet -o out", SourceDir().string());
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
  const Outcome outcome = Shell(folder_, Export() + " --config options.toml --bar-width 42 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json options = Json::parse(outcome.out)["options"];
  EXPECT_EQ(options["pin-diameter"], "12");
  EXPECT_EQ(options["bar-width"], "42");
}

TEST_F(ConfigFile, WithWhatIsNoOptionIsRefused) {
  ExpectRefused(Export(), "pin-diamter = 12\n", "there is no option 'pin-diamter'");
  ExpectRefused(Export(), "pin-diameter = 12\nbar-width = 40\npin-diameter = 8\n", "'pin-diameter' stands twice");
  ExpectRefused(Export(), "[calibrate]\nmarkers = 3\n", "there is no command 'calibrate'");
  ExpectRefused("lake-stroke -o out", "[calibrate]\nthresh = 3\n", "there is no option 'calibrate.thresh'");
  EXPECT_EQ(Shell(folder_, Export() + " --config absent.toml").exit_code, 2);
}

}  // namespace
}  // namespace lake
