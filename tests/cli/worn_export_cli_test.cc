// lake-export mjcf or osim --body: the actuator and the person in one rise.
#include <gmock/gmock.h>

#include "cli/program_run.h"
#include "compare/closed_form.h"
#include "lake/compare/comparison_file.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/exchange/mot.h"
#include "lake/linkage/design_file.h"
#include "lake/loads/body_path.h"
#include "lake/redesign/human_motion.h"
#include "published_links.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

class WornExport : public testing::Test {
 protected:
  // A comparison in C whose exoskeleton trial is late, a person, and the design worn, which has no program.
  WornExport() {
    std::filesystem::create_directory(folder_ / "C");
    const auto late = [](double u) { return u - 0.1 * std::sin(std::numbers::pi * u); };
    compare::StsCurve exo = MakeCurve({}, late, {8, 0});
    exo.leg_knee = MakeCurve({}, late).knee;
    compare::MisalignmentOptions options;
    options.intervals = false;
    WriteJsonFile(folder_ / "C/comparison.json",
                  compare::ComparisonJson(compare::CompareTrials({{MakeCurve({})}, {}}, {{exo}, {}}, options)));
    loads::BodyPath person;
    loads::LegBody& body = person.body;
    body.foot = {1.0, 0.06, 0.12};
    body.shank = {3.3, 0.18, 0.13};
    body.thigh = {7.0, 0.17, 0.13};
    body.trunk = {23.7, 0.32, 0.25};
    body.sole = {0.066, 0.2};
    body.ankle_height_m = 0.07;
    person.trunk.assign(compare::kPercentSamples, {0.3, {0.09, 0.3}});
    WriteJsonFile(folder_ / "loads.json", {{"body_path", loads::BodyPathJson(person)}});
    design_.links = kPublishedLinks;
    design_.d_min_mm = 245;
    linkage::WriteDesign(folder_ / "design.yaml", design_);
  }

  Outcome Export() const {
    return Done(folder_, "lake-export design.yaml mjcf --body loads.json --motion C -o out --quiet");
  }

  linkage::Design design_;
  TemporaryFolder folder_;
};

TEST_F(WornExport, ADesignWithoutProgramFollowsItsTrialsKnee) {
  EXPECT_THAT(Export().err, Not(HasSubstr("balance")));
  const CsvTable course = CsvTable::Read(folder_ / "out/course.csv");
  std::vector<double> knee_rad;
  for (const double knee_deg : compare::ReadComparison(folder_ / "C").exo.knee_deg)
    knee_rad.push_back(RadiansFromDegrees(knee_deg));
  const auto strokes = redesign::StrokesForAngles(redesign::DrivenLinksOf(design_, 0), knee_rad);
  ASSERT_TRUE(strokes);
  ASSERT_EQ(course.Rows(), strokes->size());
  double off_line_mm = 0;  // of a constant speed between the ends
  for (std::size_t i = 0; i < strokes->size(); ++i) {
    const double stroke_mm = course.RequiredNumber(i, course.Column("stroke_mm"));
    EXPECT_NEAR(stroke_mm, (*strokes)[i], 1e-9) << i;
    const double line_mm = std::lerp(strokes->front(), strokes->back(), static_cast<double>(i) / 100);
    off_line_mm = std::max(off_line_mm, std::abs(stroke_mm - line_mm));
  }
  EXPECT_GT(off_line_mm, 2);
}

TEST_F(WornExport, OsimIsOfTheSameRise) {
  EXPECT_EQ(DoneJson(folder_, "lake-export design.yaml osim --body loads.json --motion C -o out --json")["file"],
            "design.osim");
  EXPECT_THAT(ReadTextFile(folder_ / "out/design.osim"), HasSubstr("worn_knee_exoskeleton"));
  const CsvTable course = CsvTable::Read(folder_ / "out/course.csv");
  const exchange::MotTable motion = exchange::ReadMot(folder_ / "out/course.mot");
  ASSERT_EQ(motion.rows.size(), course.Rows());
  for (std::size_t i = 0; i < course.Rows(); ++i) {
    const auto at = [&](const char* column) { return course.RequiredNumber(i, course.Column(column)); };
    EXPECT_NEAR(motion.rows[i][motion.Column("human_knee")], at("human_knee_deg"), 1e-9) << i;
    EXPECT_NEAR(motion.rows[i][motion.Column("stroke")], 1e-3 * at("stroke_mm"), 1e-12) << i;
  }
}

TEST_F(WornExport, SaysThatTheTrunksLeanForBalanceIsNotTaken) {
  WriteTextFile(folder_ / "balance.csv", "percent,trunk_lean_deg\n0,0\n50,-12\n100,3\n");
  EXPECT_THAT(Export().err, HasSubstr("up to 12 degrees otherwise for balance, as balance.csv says"));
}

}  // namespace
}  // namespace lake
