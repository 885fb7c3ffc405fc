// A knee that the exoskeleton's hub hides: learnt by lake-gait in the trial without, rebuilt in the trial with it, and
// the joint compared against it; in a study by itself.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "cli/program_run.h"
#include "compare/closed_form.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "places.h"

namespace lake {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;

const Vector2d kJointBesideKnee(3, -2);  // of the knee's marker, shank's frame

class HiddenKnee : public testing::Test {
 protected:
  void SetUp() override {
    Write("human.csv", false);
    Write("exo.csv", true);
  }

  // Three rises of two seconds at 50 Hz. The knee's marker slides on the skin by 15 mm with the flexion; worn, it is
  // hidden, and the exoskeleton's joint is beside where it would be.
  void Write(const std::string& file, bool worn) const {
    std::ofstream csv(folder_ / file);
    csv << "frame,time_s";
    for (const char* name : {"ankle", "knee", "hip", "waist", "shank1", "shank2", "exo_knee"})
      if (worn || name != std::string("exo_knee")) csv << "," << name << "_x_mm," << name << "_y_mm";
    csv << "\n";
    for (int i = 0; i < 900; ++i) {
      const double phase = i % 300, up = phase < 150 ? (phase - 50) / 100 : 1 - (phase - 200) / 100;
      compare::StsCurve at;
      AppendPose({}, std::clamp(up, 0.0, 1.0), at);
      const Vector2d ankle = at.ankle[0], knee = at.knee[0], hip = at.hip[0];
      const Eigen::Matrix2d shank = compare::AxesAlong(knee - ankle);
      const Vector2d marker = knee + shank * Vector2d(15 * at.knee_deg[0] / 90, 5 * std::pow(at.knee_deg[0] / 90, 2));
      std::vector<Vector2d> places{ankle, marker, hip, hip + Vector2d(10 - 30 * up, 200)};
      for (const Vector2d& place : {Vector2d(35, -110), Vector2d(30, -280)}) places.push_back(knee + shank * place);
      if (worn) places.push_back(marker + compare::AxesAlong(marker - ankle) * kJointBesideKnee);
      csv << i << "," << 0.02 * i;
      for (std::size_t m = 0; m < places.size(); ++m)
        if (worn && m == 1)
          csv << ",,";
        else
          csv << "," << places[m].x() + 0.02 * std::sin(7.3 * i + 2.0 * static_cast<double>(m)) << ","
              << places[m].y() + 0.02 * std::sin(5.1 * i + 3.0 * static_cast<double>(m));
      csv << "\n";
    }
  }

  Json Done(const std::string& command) const { return DoneJson(folder_, command + " --quiet --json"); }

  void ExpectJoint(const Json& comparison) const {
    ASSERT_FALSE(comparison["joint"].is_null());
    EXPECT_NEAR(comparison["joint"]["offset_mm"][0].get<double>(), kJointBesideKnee.x(), 0.5);
    EXPECT_NEAR(comparison["joint"]["offset_mm"][1].get<double>(), kJointBesideKnee.y(), 0.5);
    EXPECT_THAT(ReadTextFile(folder_ / "C/uncertainty_budget.csv"),
                HasSubstr("joint_rms_mm,hidden knee rebuilt from technical markers,normal,"));
  }

  TemporaryFolder folder_;
};

TEST_F(HiddenKnee, IsLearntInTheOneTrialAndRebuiltInTheOther) {
  const Json human = Done("lake-gait human.csv --technical shank=shank1,shank2 -o human");
  EXPECT_EQ(human["learnt_knee"]["markers"].size(), 3u);
  const Json exo = Done("lake-gait exo.csv --technical shank=shank1,shank2 --knee-from human -o exo");
  EXPECT_EQ(exo["rebuilt_knee"]["frames"], 900);
  EXPECT_EQ(exo["rebuilt_knee"]["seen_frames"], 0);
  EXPECT_LT(exo["rebuilt_knee"]["sd_mm"].get<double>(), 1);
  EXPECT_FALSE(exo.contains("learnt_knee"));
  for (const auto& [folder, rebuilt] : {std::pair{"human", 0.0}, std::pair{"exo", 1.0}}) {
    const CsvTable table = CsvTable::Read(folder_ / folder / "kinematics.csv");
    for (std::size_t row = 0; row < table.Rows(); ++row)
      EXPECT_EQ(table.RequiredNumber(row, table.Column("knee_rebuilt")), rebuilt);
  }
  Done("lake-compare human exo -o C");
  ExpectJoint(ReadJsonFile(folder_ / "C/comparison.json"));
}

TEST_F(HiddenKnee, OfAFileIsRebuiltWhereItIsCompared) {
  Done("lake-gait human.csv --technical shank=shank1,shank2 -o human");
  Done("lake-compare human exo.csv --knee-from human -o C");
  ExpectJoint(ReadJsonFile(folder_ / "C/comparison.json"));
}

TEST_F(HiddenKnee, WithoutTechnicalMarkersSaysWhatIsMissing) {
  Done("lake-gait human.csv -o human");
  ExpectRefused(folder_, "lake-gait exo.csv --knee-from human -o exo", 1,
                "human/summary.json: no knee was learnt there");
  ExpectRefused(folder_, "lake-gait human.csv --technical shank=shank1 -o human", 2, "give two markers or more");
}

TEST_F(HiddenKnee, OfAStudyIsRebuiltByItself) {
  std::ofstream(folder_ / "study.yaml")
      << "name: hub\nhuman: {trial: human.csv, technical: [\"shank=shank1,shank2\"]}\n"
         "exo: {trial: exo.csv}\ncompare: {exo_knee: exo_knee}\n";
  Done("lake-run study.yaml -o S");
  const Json exo = ReadJsonFile(folder_ / "S/exo/summary.json");
  EXPECT_THAT(ReadTextFile(folder_ / "S/report.html"), HasSubstr("rebuilt from the technical markers"));
  EXPECT_EQ(exo["rebuilt_knee"]["frames"], 900);
  ASSERT_FALSE(ReadJsonFile(folder_ / "S/comparison/comparison.json")["joint"].is_null());
}

}  // namespace
}  // namespace lake
