// The numbers that go into the flash, without a simulator.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lake/actuator/firmware.h"
#include "lake/core/error.h"
#include "model_program.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

// Plays the table back as the firmware does: um/s during one ms are nm.
double PlayedWorstError(const actuator::StrokeTable& stroke, const actuator::StrokeSchedule& schedule) {
  std::int64_t nm = std::llround(stroke.start_mm * 1e6), now = 0;
  double worst = 0;
  for (const actuator::StrokeSegment& segment : stroke.segments)
    for (; now < segment.end_ms; ++now) {
      worst = std::max(worst, std::abs(nm * 1e-6 - schedule.StrokeAt(now * 1e-3)));
      nm += segment.velocity_um_s;
    }
  return std::max(worst, std::abs(nm * 1e-6 - schedule.knots.back().stroke_mm));
}

// Random programs with odd times: the plan stays within half an ms of travel (10 mm/s: 5 um), half a um of start, and
// half a um/s over a segment, and the stated error is what playing finds (which looks once per ms).
TEST(StrokeTable, PlansWithinTheRoundingOfMillisecondsForAnyProgram) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> pause(0.01, 1.5), speed(0.5, 9);
    std::vector<linkage::StrokeProgram::Knot> knots = {{0, 300.123456}};
    for (int i = 0; i < 40; ++i) {
      const double duration = pause(random);
      const int kind = static_cast<int>(random() % 4);
      const double towards = knots.back().stroke_mm > 310 ? -1 : 1;
      knots.push_back({knots.back().time_s + duration,
                       knots.back().stroke_mm + (kind == 0 ? 0 : towards * speed(random) * duration)});
    }
    const actuator::StrokeSchedule schedule = FreeSchedule(knots);
    const actuator::StrokeTable stroke = actuator::MakeStrokeTable(schedule, ModelTable(), {});
    const double played = PlayedWorstError(stroke, schedule);
    EXPECT_LT(played, 0.0005 + 0.0005 * 10 + 0.0005 * 1.5 + 1e-6) << "seed " << seed;
    EXPECT_LE(played, stroke.rounding_error_mm + 1e-6) << "seed " << seed;
    EXPECT_GE(played, stroke.rounding_error_mm - 0.010) << "seed " << seed;
  }
}

TEST(StrokeTable, LongProgramsAreThinnedWithinTheTolerance) {
  std::vector<linkage::StrokeProgram::Knot> knots;
  for (int i = 0; i <= 20000; ++i) knots.push_back({i * 0.002, 320 - 15 * std::cos(i * 0.002 * 0.5)});
  const actuator::StrokeSchedule schedule = FreeSchedule(knots);
  ASSERT_GT(schedule.knots.size(), static_cast<std::size_t>(actuator::kMostSegments));
  actuator::FirmwareOptions options;
  options.table_tolerance_mm = 0.02;
  const actuator::StrokeTable stroke = actuator::MakeStrokeTable(schedule, ModelTable(), options);
  EXPECT_LT(stroke.segments.size(), 400u);
  EXPECT_LE(PlayedWorstError(stroke, schedule), 0.02 + 0.006);
  EXPECT_GT(PlayedWorstError(stroke, schedule), 0.01) << "thinned as far as allowed";
}

TEST(StrokeTable, WhatDoesNotFitIsAnError) {
  std::vector<linkage::StrokeProgram::Knot> knots;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> speed(1, 9);
  double stroke_mm = 300;
  for (int i = 0; i <= 6000; ++i) {  // a zigzag of up to 0.1 mm
    knots.push_back({i * 0.02, stroke_mm});
    stroke_mm += (stroke_mm > 330 ? -1 : stroke_mm < 290 ? 1 : i % 2 ? 1 : -1) * 0.02 * speed(random);
  }
  actuator::FirmwareOptions options;
  options.table_tolerance_mm = 0.001;
  EXPECT_THAT([&] { actuator::MakeStrokeTable(FreeSchedule(knots), ModelTable(), options); },
              ThrowsMessage<Error>(HasSubstr("the UNO's flash holds 1280: raise --table-tolerance")));
  EXPECT_THAT(
      [] {
        actuator::MakeStrokeTable(FreeSchedule({{0, 300}, {1e7, 340}}), ModelTable(), {});
      },
      ThrowsMessage<Error>(HasSubstr("too long")));
}

TEST(StrokeTable, HeaderCannotBeBrokenByAFileName) {
  const std::string header =
      actuator::StrokeTableHeader({FreeSchedule({{0, 300}, {1, 305}}), ModelTable(), {}}, "from a\n#error b\\\nfile");
  EXPECT_EQ(header.find("\n#error"), std::string::npos);
  EXPECT_EQ(header.find('\\'), std::string::npos);
}

// Up at 5 mm/s from 300 to 340 mm, home at 290 mm, a tolerance of 10 %: start error, a tenth of 50 mm, and the lag of
// the three times that the speed rises (homing's stop, to the start, the program) or the two that it falls.
TEST(Drift, ForecastIsTheClosedFormOfAConstantProgram) {
  actuator::FirmwareOptions options;
  options.home_stroke_mm = 290, options.speed_tolerance_percent = 10;
  const actuator::Sketch sketch(FreeSchedule({{0, 300}, {8, 340}}), ModelTable(), options);
  const actuator::StrokeTable& stroke = sketch.stroke;
  const actuator::DriftForecast forecast = actuator::ForecastDrift(sketch);
  // 10 % are rounded up to 103/1024; 1 um of the start, 10 um of rounding up per ms.
  EXPECT_NEAR(forecast.last_drift_mm, 0.1 + stroke.pwm_error_mm + 50 * 103 / 1024.0 + 3 * 5 * 0.05, 0.012);
  EXPECT_NEAR(forecast.planned_mm, 340, 1e-9);
  EXPECT_EQ(forecast.drift_mm, forecast.last_drift_mm);
  EXPECT_NEAR(forecast.end_mm, 374.5205, 1e-4);
  EXPECT_TRUE(forecast.Fits());
  EXPECT_FALSE(forecast.is_measured);
  // (34.52 - 0.85) / 50 is 67 %.
  EXPECT_NEAR(forecast.tolerable_percent, 100 * (34.5205 - 0.85 - stroke.pwm_error_mm) / 50, 0.2);
}

// What a refusal proposes works: the tolerance it names leaves room, a little more does not; so does an end that much
// earlier. Programs that go to and fro, ending 1 to 30 mm before standing.
TEST(Drift, WhatARefusalProposesWorks) {
  int refused = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> room(1, 30), speed(1, 9);
    std::vector<linkage::StrokeProgram::Knot> knots = {{0, 260}};
    for (const double stroke : {310.0, 280.0, 374.5205 - room(random)})
      knots.push_back({knots.back().time_s + std::abs(stroke - knots.back().stroke_mm) / speed(random), stroke});
    const actuator::StrokeSchedule schedule = FreeSchedule(knots);
    actuator::DutyTable table = ModelTable();
    for (actuator::DutyRow& row : table.rows) row.tolerance_percent = 10;
    const actuator::DriftForecast forecast = actuator::ForecastDrift({schedule, table, {}});
    EXPECT_TRUE(forecast.is_measured);
    const auto fits = [&](double percent) {
      actuator::FirmwareOptions options;
      options.speed_tolerance_percent = percent;
      return actuator::ForecastDrift({schedule, table, options}).Fits();
    };
    if (forecast.Fits()) {
      EXPECT_GE(forecast.tolerable_percent, 9.8) << "seed " << seed;  // it rounds down, twice by a tenth
      continue;
    }
    ++refused;
    ASSERT_LT(forecast.tolerable_percent, 10) << "seed " << seed;
    if (forecast.tolerable_percent > 0) {
      EXPECT_TRUE(fits(forecast.tolerable_percent)) << "seed " << seed;
    }
    EXPECT_FALSE(fits(std::max(forecast.tolerable_percent, 0.0) + 0.3)) << "seed " << seed;
    knots.back().stroke_mm -= std::ceil(10 * (forecast.drift_mm - forecast.Room()) + 0.01) / 10;
    EXPECT_TRUE(actuator::ForecastDrift({FreeSchedule(knots), table, {}}).Fits()) << "seed " << seed;
  }
  EXPECT_GT(refused, 10);
  EXPECT_LT(refused, 40);
}

// An end stop before the linkage's end holds what the drift would carry past it, from where its run-on leaves room.
TEST(Drift, AnExtendEndStopBeforeTheLinkagesEndIsAWayOut) {
  // 1.02 mm before the end
  actuator::Sketch sketch(FreeSchedule({{0, 260}, {24, 373.5}}), ModelTable(), {});
  actuator::FirmwareOptions& options = sketch.options;
  const auto header = [&] { return actuator::StrokeTableHeader(sketch, "t"); };
  EXPECT_THAT(header, ThrowsMessage<Error>(HasSubstr("(--extend-stop 0.6)")));
  EXPECT_EQ(sketch.ExtendStop(), std::nullopt);
  options.extend_stop_mm = 0.6;  // 0.1 mm and 50 ms of 9.68 mm/s, 3 % faster, are 0.599 mm
  EXPECT_THAT(header(), HasSubstr("#define LAKE_DRIFT_LIMITED 0"));
  EXPECT_NEAR(*sketch.ExtendStop(), 374.5205 - 0.6, 1e-4);
  options.extend_stop_mm = 0.5;
  EXPECT_THAT(header, ThrowsMessage<Error>(HasSubstr("run on by 0.599 mm, to the linkage's end at 374.52")));
  options.extend_stop_mm = 1.1;
  EXPECT_THAT(header, ThrowsMessage<Error>(
                          HasSubstr("the program goes to 373.500 mm, and the extend end stop acts at 373.42")));
}

TEST(Drift, HomeKeepsTheLowerSoftLimit) {
  actuator::Sketch sketch(FreeSchedule({{0, 250}, {8, 290}}), ModelTable(), {});
  const auto header = [&] { return actuator::StrokeTableHeader(sketch, "t"); };
  EXPECT_NEAR(sketch.HomeStroke(), 241.9978 + 0.5, 1e-3);
  EXPECT_THAT(header(), HasSubstr("#define LAKE_HOME_UM 242498L"));
  sketch.options.home_stroke_mm = 242;
  EXPECT_THAT(header,
              ThrowsMessage<UsageError>(HasSubstr("--home-stroke 242.000 mm is below the soft limit 242.498 mm")));
  sketch.options.accept_drift = true;
  EXPECT_THAT(header(), HasSubstr("#define LAKE_HOME_UM 242000L"));
  // A soft limit nearer to the dead point than the run-on past the switch.
  sketch.options = {};
  actuator::ScheduleOptions near;
  near.margin_mm = 0.2;
  sketch.schedule = actuator::MakeSchedule(FreeDesign({{0, 250}, {8, 290}}), near);
  EXPECT_THAT(header, ThrowsMessage<Error>(HasSubstr("may run on by 0.358 mm, past the linkage's end at 241.998 mm")));
}

// 242.5 mm (home) to 330 mm in the program. The converter has 0 to 1023 counts and 10 at either end are not believed.
TEST(Potentiometer, IsOneThatSeesTheProgramFinelyEnough) {
  const actuator::StrokeSchedule schedule = FreeSchedule({{0, 250}, {16, 330}});
  const auto header = [&](const char* scale, double error_mm = 0.5) {
    actuator::FirmwareOptions options;
    options.feedback = actuator::Feedback::kPotentiometer, options.feedback_error_mm = error_mm;
    options.potentiometer = actuator::ParsePotentiometerScale(scale);
    options.Check();
    return actuator::StrokeTableHeader({schedule, ModelTable(), options}, "t");
  };
  const auto refused = [&](const char* scale, const char* text, double error_mm = 0.5) {
    EXPECT_THAT([&] { header(scale, error_mm); }, ThrowsMessage<UsageError>(HasSubstr(text))) << scale;
  };
  for (const char* scale : {"102=242,921=372", "921=242,102=372", "11=242,1011=331"})
    EXPECT_THAT(header(scale), HasSubstr("#define LAKE_FEEDBACK 1")) << scale;
  refused("5000=242,9000=362", "--pot must be of 0..1023 counts, as the converter has, not 5000");
  refused("100=242,-1=372", "not -1");
  refused("100=24.2,900=36.1", "a stroke of 242.498 mm, where home and program go, would read 14775");
  refused("9=242.4,921=372", "would read 9.7 counts, and only 10 to 1013 are believed");
  refused("102=242,1012=329", "a stroke of 330.000 mm, where home and program go, would read 1022");
  refused("100=242,101=362", "one count is 120 mm");
  // Points a twentieth of the way apart, of a scale that is right: half a count of either is 2.5 mm at the far end.
  refused("500=290,530=295", "one count is 0.167 mm, so a stroke of 242.498 mm may be off by 1.75 mm");
  EXPECT_THAT(header("500=290,530=295", 1.9), HasSubstr("#define LAKE_POT_ERROR_UM 1900"));
  refused("500=242,512=331", "would be -3466 to 4121 mm, and the firmware counts to 2000 mm", 10);
}

}  // namespace
}  // namespace lake
