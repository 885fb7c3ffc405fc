#include "lake/actuator/duty_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

actuator::DutyTable ReadText(const std::string& text) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "duty.csv", text);
  return actuator::ReadDutyTable(folder / "duty.csv");
}

TEST(DutyTable, DeadBandAndLinearPartAreReproduced) {
  const actuator::DutyTable table =
      ReadText("duty,extend_mm_s,retract_mm_s\n0.1,0,0\n0.2,0,0\n0.25,0,1\n0.5,5,3\n1,15,7\n");
  EXPECT_DOUBLE_EQ(table.extend.DeadBandDuty(), 0.25);
  EXPECT_DOUBLE_EQ(table.retract.DeadBandDuty(), 0.2);
  EXPECT_DOUBLE_EQ(table.extend.LeastMovingSpeed(), 5);
  // Extending, speed = 20 (duty - 0.25): a straight line through all points, which the interpolation must give back.
  for (double speed = 0.1; speed <= 15; speed += 0.1)
    ASSERT_NEAR(table.extend.DutyFor(speed), 0.25 + speed / 20, 1e-12) << speed;
  EXPECT_EQ(table.extend.SpeedFor(0.2), 0);
  EXPECT_EQ(table.extend.SpeedFor(1.0), 15);
}

// Random rising tables: between the points duty rises with speed, never leaves its neighbours, and SpeedFor is its
// inverse.
TEST(DutyTable, InterpolationIsMonotoneAndInvertible) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    std::exponential_distribution<double> step(1);
    const int points = 2 + static_cast<int>(random() % 8);
    std::vector<double> speeds, duties;
    double speed = 0, duty = 0;
    for (int i = 0; i < points; ++i) {
      speeds.push_back(speed += step(random) + 1e-3), duties.push_back(duty += step(random) + 1e-3);
    }
    for (double& d : duties) d /= duty;
    const actuator::DutyCurve curve(speeds, duties, "test");
    double before = 0;
    for (int i = 0; i <= 400; ++i) {
      const double at = std::lerp(speeds.front(), speeds.back(), i / 400.0), value = curve.DutyFor(at);
      ASSERT_GE(value, before - 1e-12) << "seed " << seed;
      before = value;
      const auto above = std::lower_bound(speeds.begin(), speeds.end(), at) - speeds.begin();
      ASSERT_LE(value, duties[above] + 1e-12) << "seed " << seed;
      ASSERT_NEAR(curve.DutyFor(curve.SpeedFor(value)), value, 1e-9) << "seed " << seed;
    }
    for (int i = 0; i < points; ++i) ASSERT_NEAR(curve.DutyFor(speeds[i]), duties[i], 1e-12);
  }
}

// A curved actuator from nine points: the shape-preserving cubic is nearer than straight lines would be.
TEST(DutyTable, CurvedActuatorWithinAFractionOfALine) {
  const auto truth = [](double speed) { return 0.2 + 0.8 * std::pow(speed / 10, 1.4); };
  std::vector<double> speeds, duties;
  for (int i = 0; i <= 8; ++i) speeds.push_back(10.0 * i / 8), duties.push_back(truth(speeds.back()));
  const actuator::DutyCurve curve(speeds, duties, "test");
  double worst = 0, worst_line = 0;
  for (double s = 1.25; s <= 10; s += 0.01) {
    const int i = std::min(7, static_cast<int>(s / 1.25));
    const double line = std::lerp(duties[i], duties[i + 1], s / 1.25 - i);
    worst = std::max(worst, std::abs(curve.DutyFor(s) - truth(s)));
    worst_line = std::max(worst_line, std::abs(line - truth(s)));
  }
  EXPECT_LT(worst, 0.5 * worst_line);
}

TEST(DutyTable, WritesWhatItReads) {
  const TemporaryFolder folder;
  const std::vector<actuator::DutyRow> rows = {
      {0.2, 0, NAN, NAN, NAN}, {0.3, NAN, 0, NAN, NAN}, {0.5, 4.1, 3.2, 0.02, 0.03, 2.5}, {1, 9, 8, 0.1, 0.1, 1}};
  actuator::WriteDutyTable(folder / "t.csv", rows);
  const actuator::DutyTable table = actuator::ReadDutyTable(folder / "t.csv");
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_TRUE(std::isnan(table.rows[0].retract_mm_s));
  EXPECT_EQ(table.rows[2].retract_se_mm_s, 0.03);
  EXPECT_EQ(table.retract.DeadBandDuty(), 0.3);
  EXPECT_EQ(table.TolerancePercent(), 2.5);
  EXPECT_EQ(ReadText("duty,extend_mm_s,retract_mm_s\n0.2,0,0\n0.5,5,5\n").TolerancePercent(), std::nullopt);
}

TEST(DutyTable, BadTablesSayWhatIsWrong) {
  const std::string header = "duty,extend_mm_s,retract_mm_s\n";
  const std::pair<const char*, const char*> cases[] = {
      {"0.2,0,0\n128,5,5\n", "divide values of analogWrite by 255"},
      {"0.5,5,5\n0.4,6,6\n", "duties must ascend"},
      {"0.2,0,0\n0.5,5,5\n0.6,4,6\n", "extend_mm_s: the speed falls from 5 to 4 mm/s at duty 0.6"},
      {"0.2,0,0\n0.5,5,-5\n", "speeds are positive in both directions"},
      {"0.2,0,0\n0.5,nan,5\n", "extend_mm_s"},
      {"0.2,0,0\n", "1 different speeds; a curve needs at least two"},
      {"0.2,0,\n0.5,5,\n", "retract_mm_s: 0 different speeds"},
      {"", "different speeds"},
  };
  for (const auto& [rows, message] : cases) {
    const std::string table = header + rows;
    EXPECT_THAT([&] { ReadText(table); }, ThrowsMessage<Error>(HasSubstr(message))) << rows;
  }
  EXPECT_THAT([] { ReadText("duty,extend_mm_s,retract_mm_s,tolerance_percent\n0.2,0,0,\n0.5,5,5,-1\n"); },
              ThrowsMessage<Error>(HasSubstr("the tolerance -1 % at duty 0.5 is not within 0..100")));
  EXPECT_THAT([] { ReadText("duty,speed\n0.1,1\n"); }, ThrowsMessage<Error>(HasSubstr("extend_mm_s")));
  EXPECT_THROW(ReadText(""), Error);
}

}  // namespace
}  // namespace lake
