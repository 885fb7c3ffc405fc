// The page of a recording's sit-to-stands, as lake-gait writes it.
#include <gmock/gmock.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "cli/program_run.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/exchange/formats.h"
#include "page_text.h"
#include "places.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

class SitToStandPage : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(trial_)) GTEST_SKIP() << trial_.string() << " is not here";
  }

  // The trial's right leg, as a program reads it, with these markers beside those of the leg.
  std::string Leg(const std::string& program, const std::string& others) const {
    return fmt::format("{} {} --forward x --quiet --map ankle=r_ankle,knee=r_knee,hip=R_HJC{}", program, Quoted(trial_),
                       others);
  }

  const std::filesystem::path trial_ = SharedData() / "sts_force_plates/STS1.trc";
  const TemporaryFolder folder_;
};

TEST_F(SitToStandPage, ShowsWhatTheTableHolds) {
  Done(folder_, Leg("lake-gait", ",waist=r.ASIS+r.PSIS --age 72 -o G"));
  const std::string page = ReadPageText(folder_ / "G/sit_to_stand.html");
  const CsvTable table = CsvTable::Read(folder_ / "G/sit_to_stand.csv");
  const std::size_t test = table.Rows() - 1, five = table.Column("five_times_s");
  ASSERT_EQ(table.Text(test, 0), "five_times");
  EXPECT_THAT(page, HasSubstr(fmt::format("{:.2f}", table.RequiredNumber(test, five))));
  EXPECT_THAT(page, HasSubstr(fmt::format("{} than average at this age (12.6 s, Bohannon 2006)",
                                          table.RequiredNumber(test, five) > 12.6 ? "worse" : "no worse")));
  for (const char* text : {"rise 5", "five times", "time to sit down (s)", "mean power over body mass (W/kg)"})
    EXPECT_THAT(page, HasSubstr(text));
  EXPECT_THAT(page, Not(HasSubstr(">nan")));
}

// What the file's own coordinates give, x forward and y up; they are smooth, and the fit changes them by hundredths of
// a degree.
TEST_F(SitToStandPage, LeanToThePelvisIsThatOfTheMarkers) {
  const std::string pelvis = ",asis=r.ASIS+L.ASIS,psis=r.PSIS+L.PSIS";
  Done(folder_, Leg("lake-gait", ",waist=R_Shoulder" + pelvis + " --sex female --age 70 -o G"));
  const exchange::PointRecording points = exchange::ReadPoints(trial_);
  const auto at = [&](const char* name, std::size_t i) { return points.Find(name)->positions[i]; };
  const auto lean_deg = [&](std::size_t i) {
    const Eigen::Vector3d trunk = at("R_Shoulder", i) - at("R_HJC", i),
                          front = (at("r.ASIS", i) + at("L.ASIS", i) - at("r.PSIS", i) - at("L.PSIS", i)) / 2;
    return DegreesFromRadians(std::atan2(trunk.x(), trunk.y()) + std::atan2(front.y(), front.x()));
  };
  const CsvTable table = CsvTable::Read(folder_ / "G/sit_to_stand.csv");
  ASSERT_EQ(table.Rows(), 6U);
  for (std::size_t row = 0; row < 5; ++row) {
    const auto number = [&](const char* column) { return table.RequiredNumber(row, table.Column(column)); };
    double most_deg = -INFINITY, at_seat_off_deg = 0;
    for (std::size_t i = 0; i + 1 < points.time_s.size(); ++i) {
      const double time_s = points.time_s[i], part = (number("seat_off_s") - time_s) / (points.time_s[i + 1] - time_s);
      if (part >= 0 && part < 1) at_seat_off_deg = std::lerp(lean_deg(i), lean_deg(i + 1), part);
      if (time_s >= number("onset_s") && time_s <= number("standing_s")) most_deg = std::max(most_deg, lean_deg(i));
    }
    EXPECT_NEAR(number("trunk_pelvis_seat_off_deg"), at_seat_off_deg, 0.05);
    EXPECT_NEAR(number("trunk_pelvis_max_deg"), most_deg, 0.05);
    EXPECT_GT(number("trunk_pelvis_max_deg_sd"), 0);
    EXPECT_LT(number("trunk_pelvis_max_deg_sd"), 1);
  }
  const Json five = ReadJsonFile(folder_ / "G/summary.json")["five_times"];
  EXPECT_EQ(five["low_power"], five["power_w_kg"].get<double>() < 1.9);
  EXPECT_THAT(ReadPageText(folder_ / "G/sit_to_stand.html"), HasSubstr("for older women (below 1.9 W/kg is low"));
  // With the middle of the pelvis for a waist, as a leg alone would have it, there is no trunk to lean on it.
  EXPECT_THAT(Done(folder_, Leg("lake-gait", ",waist=r.ASIS+r.PSIS" + pelvis + " -o L")).err,
              HasSubstr("the waist marker is on the pelvis itself"));
  EXPECT_THAT(ReadTextFile(folder_ / "L/sit_to_stand.csv"), Not(HasSubstr("nan")));
}

// Places and velocities are those of lake-loads, whatever the body's mass; momentum.csv is held against both plates'
// impulses (loads_test.cc). Deviations are of fewer draws, 100 and 400: within 7 % and 4 % of the same.
TEST_F(SitToStandPage, CentreOfMassIsThatOfTheLoads) {
  for (const std::string trunk : {",waist=r.ASIS+r.PSIS", ",waist=r.ASIS+r.PSIS,shoulder=R_Shoulder"}) {
    SCOPED_TRACE(trunk);
    Done(folder_, Leg("lake-gait", trunk + " -o G"));
    Done(folder_, Leg("lake-loads", trunk + " --mass 62.6 -o L"));
    const CsvTable measured = CsvTable::Read(folder_ / "G/sit_to_stand.csv"),
                   momenta = CsvTable::Read(folder_ / "L/momentum.csv");
    ASSERT_EQ(measured.Rows(), 6u);
    ASSERT_EQ(momenta.Rows(), 5u);
    for (std::size_t row = 0; row < 5; ++row)
      for (const std::string column : {"com_seat_off_mm", "com_forward_max_mm_s", "com_upward_max_mm_s"}) {
        const auto in = [&](const CsvTable& table, const std::string& name) {
          return table.RequiredNumber(row, table.Column(name));
        };
        EXPECT_NEAR(in(measured, column), in(momenta, column), 1e-6 * std::abs(in(momenta, column))) << column;
        EXPECT_NEAR(in(measured, column + "_sd") / in(momenta, column + "_sd"), 1, 0.3) << column;
      }
    EXPECT_LT(measured.RequiredNumber(5, measured.Column("com_seat_off_mm")), -50);  // behind the heel
  }
  EXPECT_THAT(ReadPageText(folder_ / "G/sit_to_stand.html"),
              HasSubstr("centre of mass before the ankle at seat-off (mm)"));
  // Without a trunk there is none of the body either, and nothing is made of it.
  const Outcome alone = Done(folder_, Leg("lake-gait", " -o N"));
  const CsvTable measured = CsvTable::Read(folder_ / "N/sit_to_stand.csv");
  EXPECT_TRUE(measured.Number(0, measured.Column("hip_rise_mm")));
  EXPECT_FALSE(measured.Number(0, measured.Column("com_seat_off_mm")));
  EXPECT_THAT(alone.err, Not(HasSubstr("centre of mass")));
}

}  // namespace
}  // namespace lake
