#include "lake/actuator/duty_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lake/actuator/duty_table.h"
#include "lake/actuator/stroke_session.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

// An actuator whose speed bends down a little: dead bands 0.27 and 0.22.
double TrueSpeed(double duty) {
  const double over = std::abs(duty) - (duty > 0 ? 0.27 : 0.22);
  return over <= 0 ? 0 : std::copysign((duty > 0 ? 13 : 15) * over * (1 - 0.15 * over), duty);
}

struct LogMaker {
  explicit LogMaker(unsigned seed) : random(seed) {}

  // Rest, then the duty for a while; the motor follows with 30 ms; noise of the measured stroke, a tenth of it wild.
  void Plateau(double duty, double seconds, double true_speed) {
    for (const auto& [d, speed, duration] : {std::tuple{0.0, 0.0, 0.3}, std::tuple{duty, true_speed, seconds}})
      for (double t = 0; t < duration; t += 0.02) {
        now += 0.02;
        speed_now += (speed - speed_now) * (1 - std::exp(-0.02 / 0.03));
        stroke += speed_now * 0.02;
        const double wild = random() % 10 == 0 ? 20 : 1;
        log.time_s.push_back(now), log.duty.push_back(d);
        log.stroke_mm.push_back(std::clamp(stroke, low, high) + wild * noise_mm * normal(random));
      }
  }

  std::mt19937 random;
  std::normal_distribution<double> normal;
  actuator::DutyLog log{"log.csv", {}, {}, {}};
  double now = 0, stroke = 300, speed_now = 0, noise_mm = 0.03, low = -1e9, high = 1e9;
};

actuator::DutyLog AllDuties(unsigned seed) {
  LogMaker maker(seed);
  for (int i = 1; i <= 10; ++i)
    for (const int sign : {1, -1}) maker.Plateau(sign * 0.1 * i, 2, TrueSpeed(sign * 0.1 * i));
  return maker.log;
}

TEST(RobustSlope, SurvivesAQuarterOfWildPoints) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<double> x, y;
    for (int i = 0; i < 200; ++i)
      x.push_back(0.02 * i), y.push_back(7 - 3 * x.back() + (i % 4 ? 0.05 : 5.0) * normal(random));
    const actuator::RobustSlope fit = actuator::FitRobustSlope(x, y);
    // Least squares on the good points would have 0.05 / sqrt(sum (x - mean)^2) = 0.0031.
    EXPECT_NEAR(fit.slope, -3, 5 * 0.0031 * 1.5) << "seed " << seed;
    EXPECT_GT(fit.standard_error, 0.002);
    EXPECT_LT(fit.standard_error, 0.008);
  }
  EXPECT_TRUE(std::isnan(actuator::FitRobustSlope(std::vector{1.0, 2.0}, std::vector{1.0, 2.0}).slope));
  EXPECT_TRUE(std::isnan(actuator::FitRobustSlope(std::vector{1.0, 1.0, 1.0}, std::vector{1.0, 2.0, 3.0}).slope));
}

// Readings in steps, a dozen of them, as a potentiometer gives: uniform errors, and the slope is no multiple of the
// step.
TEST(RobustSlope, ReadingsInStepsHaveHonestErrors) {
  std::vector<double> scaled;
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> phase(0, 1), speed(2, 10);
    const double truth = speed(random), start = phase(random), step = 0.137;
    std::vector<double> x, y;
    for (int i = 0; i < 12; ++i)
      x.push_back(0.1 * i), y.push_back(step * std::floor((start + truth * x.back()) / step));
    const actuator::RobustSlope fit = actuator::FitRobustSlope(x, y);
    scaled.push_back((fit.slope - truth) / fit.standard_error);
    EXPECT_NEAR(fit.slope, truth, 0.137);  // 0.040 / sqrt(sum (x - mean)^2) = 0.033; a step per second is 4 of it
  }
  // 300 values: 0.041, times 4. The floor errs to the safe side, by less than a third.
  EXPECT_LT(StandardDeviation(scaled), 1.16);
  EXPECT_GT(StandardDeviation(scaled), 0.7);
}

TEST(DutyCalibration, SpeedsWithHonestErrorsOverManySeeds) {
  std::vector<double> scaled;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const actuator::DutyCalibration c = actuator::CalibrateDuty({AllDuties(seed)}, {});
    EXPECT_TRUE(c.warnings.empty()) << c.warnings.front();
    EXPECT_EQ(c.plateaus.size(), 20u);
    for (const actuator::DutyRow& row : c.rows) {
      if (row.extend_mm_s > 0) scaled.push_back((row.extend_mm_s - TrueSpeed(row.duty)) / row.extend_se_mm_s);
      if (row.retract_mm_s > 0) scaled.push_back((row.retract_mm_s + TrueSpeed(-row.duty)) / row.retract_se_mm_s);
    }
    // Between the two slowest moving duties the curve bends by 15 % of 0.1: half a percent of duty.
    EXPECT_NEAR(c.extend.duty, 0.27, 0.005) << "seed " << seed;
    EXPECT_NEAR(c.retract.duty, 0.22, 0.005) << "seed " << seed;
    EXPECT_NEAR(c.extend.low, 0.2, 1e-9);
    EXPECT_NEAR(c.extend.high, 0.3, 1e-9);
  }
  EXPECT_GE(scaled.size(), 40u * 15);
  const double deviation = StandardDeviation(scaled);
  // Some 650 values: the deviation of a deviation of 1 is 0.028, that of the mean 0.039; times 5.
  EXPECT_NEAR(deviation, 1, 0.14);
  EXPECT_NEAR(Mean(scaled), 0, 0.2);
}

TEST(DutyCalibration, TableDrivesTheActuatorAtTheSpeedAskedFor) {
  const actuator::DutyTable table =
      actuator::MakeDutyTable(actuator::CalibrateDuty({AllDuties(3), AllDuties(4)}, {}).rows, "test");
  // From the slowest measured speed on: 0.5 % by noise, 1 % by interpolating a bend.
  for (double speed = 0.5; speed < 8; speed += 0.25) {
    EXPECT_NEAR(TrueSpeed(table.extend.DutyFor(speed)), speed, 0.02 + 0.01 * speed);
    EXPECT_NEAR(-TrueSpeed(-table.retract.DutyFor(speed)), speed, 0.02 + 0.01 * speed);
  }
}

// Two logs, one 3 % faster and one 3 % slower than their mean: the tolerance covers both, and little more than that and
// the noise. What was tried once has none.
TEST(DutyCalibration, ToleranceIsWhatTheRoundsDifferBy) {
  std::vector<actuator::DutyLog> logs;
  for (const double factor : {1.03, 0.97}) {
    LogMaker maker(11);
    for (const double duty : {0.4, -0.4, 0.7, -0.7, 1.0, -1.0}) maker.Plateau(duty, 4, factor * TrueSpeed(duty));
    logs.push_back(maker.log);
  }
  const actuator::DutyCalibration both = actuator::CalibrateDuty(logs, {});
  ASSERT_TRUE(both.tolerance_percent);
  EXPECT_GE(*both.tolerance_percent, 3);
  // Four seconds of 50 Hz with 0.03 mm: 0.0018 mm/s a plateau, of at least 1.7 mm/s; two errors, and as much in the
  // mean.
  EXPECT_LT(*both.tolerance_percent, 3 + 0.8);
  EXPECT_EQ(actuator::MakeDutyTable(both.rows, "t").TolerancePercent(), both.tolerance_percent);
  const actuator::DutyCalibration once = actuator::CalibrateDuty({logs[0]}, {});
  EXPECT_FALSE(once.tolerance_percent);
  EXPECT_EQ(actuator::MakeDutyTable(once.rows, "t").TolerancePercent(), std::nullopt);
}

TEST(DutyCalibration, PlateauThatMeetsTheEndOfTravelIsLeftOut) {
  LogMaker maker(1);
  maker.high = 308;
  for (const double duty : {0.5, -0.5, 0.8, -0.8, 0.4, -0.4}) maker.Plateau(duty, 1, TrueSpeed(duty));
  maker.stroke = 304;
  maker.Plateau(0.9, 1.5, TrueSpeed(0.9));  // 7.4 mm/s: at 308 mm after half the time
  const actuator::DutyCalibration c = actuator::CalibrateDuty({maker.log}, {});
  ASSERT_EQ(c.warnings.size(), 1u);
  EXPECT_THAT(c.warnings[0], AllOf(HasSubstr("log.csv"), HasSubstr("duty 0.9"), HasSubstr("not steady")));
  EXPECT_FALSE(c.plateaus.back().used);
  EXPECT_NEAR(actuator::MakeDutyTable(c.rows, "t").extend.MostDuty(), 0.8, 1e-9);
}

TEST(DutyCalibration, NoiseThatTurnsTheOrderIsMadeMonotone) {
  LogMaker maker(2);
  for (const double duty : {0.4, -0.4, 0.5, -0.5, 0.6, -0.6})
    maker.Plateau(duty, 2, duty == 0.6 ? TrueSpeed(0.5) - 0.5 : TrueSpeed(duty));  // another load
  const actuator::DutyCalibration c = actuator::CalibrateDuty({maker.log}, {});
  EXPECT_NEAR(c.largest_adjustment_mm_s, 0.25, 0.05);  // half the fall
  ASSERT_FALSE(c.warnings.empty());
  EXPECT_THAT(c.warnings.back(), HasSubstr("a speed falls as the duty rises"));
  EXPECT_NO_THROW(actuator::MakeDutyTable(c.rows, "t"));
}

TEST(DutyCalibration, WhatIsWrongIsNamed) {
  LogMaker swapped(5);
  for (const double duty : {0.5, -0.5}) swapped.Plateau(duty, 1, -TrueSpeed(duty));
  EXPECT_THAT([&] { actuator::CalibrateDuty({swapped.log}, {}); },
              ThrowsMessage<Error>(HasSubstr("swap the motor's two wires")));
  LogMaker few(6);
  few.Plateau(0.5, 1, TrueSpeed(0.5));
  EXPECT_THAT([&] { actuator::CalibrateDuty({few.log}, {}); }, ThrowsMessage<Error>(HasSubstr("1 extending duties")));
  LogMaker still(7);
  still.Plateau(0, 2, 0);
  EXPECT_THAT([&] { actuator::CalibrateDuty({still.log}, {}); }, ThrowsMessage<Error>(HasSubstr("no plateau")));
  actuator::CalibrateOptions options;
  options.min_plateau_s = 0.1;
  EXPECT_THROW(actuator::CalibrateDuty({few.log}, options), UsageError);
}

actuator::DutyLog ReadLogText(const std::string& text, const std::optional<actuator::PotentiometerScale>& scale = {}) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "log.csv", text);
  return actuator::ReadDutyLog(folder / "log.csv", scale);
}

TEST(DutyLog, ReadsCsvAndSerialOutput) {
  EXPECT_EQ(ReadLogText("time_s,stroke_mm,duty\n0,300,0\n0.1,,0.5\n0.2,301,0.5\n").stroke_mm,
            (std::vector{300.0, 301.0}));
  const std::string serial =
      "# lake-stroke\r\ntime_s,planned_mm,duty,direction,state,adc,end_stops\r\n0.100,,0.0000,0,idle,102,0\r\n# ok\r\n"
      "0.200,,-0.5000,-1,jogging,512,0\r\n\r\n";
  const actuator::DutyLog log = ReadLogText(serial, actuator::ParsePotentiometerScale("102=242,921=372"));
  ASSERT_EQ(log.time_s.size(), 2u);
  EXPECT_NEAR(log.stroke_mm[0], 242, 1e-12);
  EXPECT_NEAR(log.stroke_mm[1], 242 + 410 * 130.0 / 819, 1e-9);
  EXPECT_EQ(log.duty[1], -0.5);
  EXPECT_THAT([&] { ReadLogText(serial); }, ThrowsMessage<Error>(HasSubstr("measured strokes")))
      << "planned is not measured";
}

// As a terminal that knows nothing of check sums logs it.
TEST(DutyLog, TakesOffTheFirmwaresCheckSums) {
  std::string text;
  for (const char* line : {"ok", "time_s,stroke_mm,duty", "0,300,0", "[MSG:done]", "1,301,0.5"})
    text += actuator::Framed(line) + "\r\n";
  text += "# a * of my own\n2,302,0.5\n";
  EXPECT_EQ(ReadLogText(text).stroke_mm, (std::vector{300.0, 301.0, 302.0}));
  text.replace(text.find("1,301"), 5, "1,801");
  EXPECT_THAT([&] { ReadLogText(text); }, ThrowsMessage<Error>(HasSubstr("log.csv:5: the line's check sum is wrong")));
}

TEST(DutyLog, LinesOfBlanksAreNoRows) {
  const actuator::DutyLog log = ReadLogText("  \ntime_s,stroke_mm,duty\n0,300,0\n \t\n ok \n1,301,0.5\n \r\n");
  EXPECT_EQ(log.time_s, (std::vector<double>{0, 1}));
}

TEST(DutyLog, BadLogsSayWhere) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "empty"},
      {"# only remarks\n", "empty"},
      {"a,b\n1,2\n", "log.csv:1: no header with the columns time_s and duty"},
      {"time_s,stroke_mm,duty\n0,300,0\n0,301,0\n", "log.csv:3: the times must ascend"},
      {"time_s,stroke_mm,duty\n1,300,0\n0.5,301,0\n", "log.csv:3: the times must ascend"},
      {"time_s,stroke_mm,duty\nnan,300,0\n", "log.csv:2"},
      {"time_s,stroke_mm,duty\n0,inf,0\n", "log.csv:2"},
      {"time_s,stroke_mm,duty\n0,300,128\n", "log.csv:2: duty 128 is not within -1..1"},
      {"time_s,stroke_mm,duty\n0,300\n", "log.csv:2"},
  };
  for (const auto& [text, message] : cases)
    EXPECT_THAT([text = text] { ReadLogText(text); }, ThrowsMessage<Error>(HasSubstr(message))) << text;
  for (const char* scale : {"", "1=2", "1=2,1=3", "1=2,3=2", "a=2,3=4", "1=2,3=4,5=6"})
    EXPECT_THROW(actuator::ParsePotentiometerScale(scale), UsageError) << scale;
}

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
