// lake-export as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/program_run.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"

namespace lake {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
constexpr const char* kDesign =
    "links: {l1: 59.081, l2: 68.840, l3: 55.964, l4: 71.849, l5: 118.630, l6: 287.310}\nd_min_mm: 245\n";

class Export : public ::testing::Test {
 protected:
  Export() { WriteTextFile(folder_ / "design.yaml", kDesign); }

  void Refused(const std::string& arguments, int exit_code, const std::string& message) {
    const Outcome outcome = Shell(folder_, "lake-export " + arguments + " -o out");
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(message));
    EXPECT_EQ(outcome.ErrorLines(), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  }

  TemporaryFolder folder_;
};

TEST_F(Export, WritesEachFormatWithItsPartsAndNothingElseToStdout) {
  const std::pair<const char*, std::pair<const char*, const char*>> kFormats[] = {
      {"mjcf", {"design.xml", "<?xml version=\"1.0\"?>\n<mujoco"}},
      {"osim", {"design.osim", "<?xml version=\"1.0\"?>\n<OpenSimDocument Version=\"40000\">"}},
      {"urdf", {"design.urdf", "<?xml version=\"1.0\"?>\n<robot"}},
      {"step", {"design.step", "ISO-10303-21;"}},
      {"dxf", {"design.dxf", "999\ndxflib"}}};
  for (const auto& [format, file] : kFormats) {
    const Outcome outcome =
        Shell(folder_, fmt::format("lake-export design.yaml {0} -o {0} --plate 5mm,PLA --json --quiet", format));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(Json::parse(outcome.out)["file"], file.first);
    EXPECT_THAT(ReadTextFile(folder_ / format / file.first), StartsWith(file.second)) << format;
    const CsvTable parts = CsvTable::Read(folder_ / format / "parts.csv");
    EXPECT_EQ(parts.Text(1, parts.Column("part")), "shank link KS");
    EXPECT_EQ(parts.Text(1, parts.Column("material")), "PLA");
    EXPECT_EQ(parts.RequiredNumber(1, parts.Column("thickness_mm")), 5);
  }
}

// Parts are those that the design was made with; an option changes one of them.
TEST_F(Export, TakesThePartsOfTheDesign) {
  WriteTextFile(folder_ / "thick.yaml",
                ReadTextFile(folder_ / "design.yaml") + "parts: {plate: '6mm,S235', bar_width_mm: 28}\n");
  const auto parts_of = [&](const std::string& arguments) {
    const Outcome outcome = Shell(folder_, fmt::format("lake-export {} -o out --json --quiet", arguments));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return Json::parse(outcome.out)["parts"];
  };
  const Json thick = parts_of("thick.yaml dxf");
  EXPECT_EQ(thick, parts_of("design.yaml dxf --plate 6mm,S235 --bar-width 28"));
  EXPECT_NE(thick, parts_of("design.yaml dxf"));
  EXPECT_EQ(parts_of("thick.yaml dxf --plate 5mm,PLA"), parts_of("design.yaml dxf --plate 5mm,PLA --bar-width 28"));
}

TEST_F(Export, RefusesWhatItCannotWrite) {
  Refused("design.yaml stl", 2, "no format 'stl': there are mjcf, osim, urdf, step, dxf");
  Refused("design.yaml sdf", 2, "sdf is removed: write urdf");
  Refused("none.yaml step", 1, "none.yaml");
  Refused("design.yaml step --plate 4mm,cheese", 2, "no material 'cheese'");
  Refused("design.yaml step --plate PLA", 2, "a thickness and a material, such as 4mm,PLA");
  Refused("design.yaml dxf --pin-diameter 30", 1, "a pin of 30 mm does not fit");
  Refused("design.yaml urdf --body loads.json", 2, "--body is for mjcf and osim, not for urdf");
  Refused("design.yaml mjcf --motion predicted", 2, "give --body loads.json too");
  Refused("design.yaml mjcf --thigh-cuff 210:80", 2,
          "--thigh-cuff only applies to a worn mechanism: give --body loads.json too");
  Refused("design.yaml mjcf --cuff-softest 2", 2, "--cuff-softest only applies to a worn mechanism");
  Refused("design.yaml mjcf --body loads.json", 2, "predicted is not there: give --motion");
}

}  // namespace
}  // namespace lake
