// Options from a file: what it says is used, or is an error.
#include <gmock/gmock.h>

#include "cli/program_run.h"
#include "lake/core/json.h"
#include "places.h"

namespace lake {
namespace {

class ConfigFile : public testing::Test {
 protected:
  static std::string Export() {
    return fmt::format("lake-export '{}/data/sts-study/worn.yaml' dxf --quiet -o out", SourceDir().string());
  }

  void ExpectRefused(const std::string& program, const std::string& text, const std::string& message) {
    WriteTextFile(folder_ / "options.toml", text);
    lake::ExpectRefused(folder_, program + " --config options.toml", 2, "options.toml: " + message);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  }

  TemporaryFolder folder_;
};

TEST_F(ConfigFile, StandsBelowTheCommandLine) {
  WriteTextFile(folder_ / "options.toml", "pin-diameter = 12\nbar-width = 40\n");
  const Json options = DoneJson(folder_, Export() + " --config options.toml --bar-width 42 --json")["options"];
  EXPECT_EQ(options["pin-diameter"], "12");
  EXPECT_EQ(options["bar-width"], "42");
}

TEST_F(ConfigFile, WithWhatIsNoOptionIsRefused) {
  ExpectRefused(Export(), "pin-diamter = 12\n", "there is no option 'pin-diamter'");
  ExpectRefused(Export(), "pin-diameter = 12\nbar-width = 40\npin-diameter = 8\n", "'pin-diameter' stands twice");
  ExpectRefused(Export(), "[calibrate]\nmarkers = 3\n", "there is no command 'calibrate'");
  ExpectRefused("lake-stroke -o out", "[calibrate]\nthresh = 3\n", "there is no option 'calibrate.thresh'");
  lake::ExpectRefused(folder_, Export() + " --config absent.toml", 2, "absent.toml");
}

}  // namespace
}  // namespace lake
