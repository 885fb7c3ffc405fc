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
double PlayedWorstError(const StrokeTable& stroke, const StrokeSchedule& schedule) {
  std::int64_t nm = std::llround(stroke.start_mm * 1e6), now = 0;
  double worst = 0;
  for (const StrokeSegment& segment : stroke.segments)
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
    std::vector<StrokeProgram::Knot> knots = {{0, 300.123456}};
    for (int i = 0; i < 40; ++i) {
      const double duration = pause(random);
      const int kind = static_cast<int>(random() % 4);
      const double towards = knots.back().stroke_mm > 310 ? -1 : 1;
      knots.push_back({knots.back().time_s + duration,
                       knots.back().stroke_mm + (kind == 0 ? 0 : towards * speed(random) * duration)});
    }
    const StrokeSchedule schedule = FreeSchedule(knots);
    const StrokeTable stroke = MakeStrokeTable(schedule, ModelTable(), {});
    const double played = PlayedWorstError(stroke, schedule);
    EXPECT_LT(played, 0.0005 + 0.0005 * 10 + 0.0005 * 1.5 + 1e-6) << "seed " << seed;
    EXPECT_LE(played, stroke.rounding_error_mm + 1e-6) << "seed " << seed;
    EXPECT_GE(played, stroke.rounding_error_mm - 0.010) << "seed " << seed;
  }
}

TEST(StrokeTable, LongProgramsAreThinnedWithinTheTolerance) {
  std::vector<StrokeProgram::Knot> knots;
  for (int i = 0; i <= 20000; ++i) knots.push_back({i * 0.002, 320 - 15 * std::cos(i * 0.002 * 0.5)});
  const StrokeSchedule schedule = FreeSchedule(knots);
  ASSERT_GT(schedule.knots.size(), static_cast<std::size_t>(kMostSegments));
  FirmwareOptions options;
  options.table_tolerance_mm = 0.02;
  const StrokeTable stroke = MakeStrokeTable(schedule, ModelTable(), options);
  EXPECT_LT(stroke.segments.size(), 400u);
  EXPECT_LE(PlayedWorstError(stroke, schedule), 0.02 + 0.006);
  EXPECT_GT(PlayedWorstError(stroke, schedule), 0.01) << "thinned as far as allowed";
}

TEST(StrokeTable, WhatDoesNotFitIsAnError) {
  std::vector<StrokeProgram::Knot> knots;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> speed(1, 9);
  double stroke_mm = 300;
  for (int i = 0; i <= 6000; ++i) {  // a zigzag of up to 0.1 mm
    knots.push_back({i * 0.02, stroke_mm});
    stroke_mm += (stroke_mm > 330 ? -1 : stroke_mm < 290 ? 1 : i % 2 ? 1 : -1) * 0.02 * speed(random);
  }
  FirmwareOptions options;
  options.table_tolerance_mm = 0.001;
  EXPECT_THAT([&] { MakeStrokeTable(FreeSchedule(knots), ModelTable(), options); },
              ThrowsMessage<Error>(HasSubstr("the UNO's flash holds 2406: raise --table-tolerance")));
  EXPECT_THAT(
      [] {
        MakeStrokeTable(FreeSchedule({{0, 300}, {1e7, 340}}), ModelTable(), {});
      },
      ThrowsMessage<Error>(HasSubstr("too long")));
}

TEST(StrokeTable, HeaderCannotBeBrokenByAFileName) {
  const StrokeSchedule schedule = FreeSchedule({{0, 300}, {1, 305}});
  const DutyTable table = ModelTable();
  const StrokeTable stroke = MakeStrokeTable(schedule, table, {});
  const std::string header = StrokeTableHeader(stroke, schedule, table, 242, {}, "from a\n#error b\\\nfile");
  EXPECT_EQ(header.find("\n#error"), std::string::npos);
  EXPECT_EQ(header.find('\\'), std::string::npos);
}

// The largest table there can be still leaves the code its room.
TEST(StrokeTable, SegmentsAndCodeShareTheFlash) {
  EXPECT_LE(kMostSegments * kSegmentBytes + kFirmwareBytes, kFlashBytes);
}

}  // namespace
}  // namespace lake
