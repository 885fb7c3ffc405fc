#include "lake/actuator/stroke_schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lake/core/error.h"
#include "model_program.h"

namespace lake {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

actuator::ScheduleOptions AtSpeed(double speed_mm_s) {
  actuator::ScheduleOptions options;
  options.speed_mm_s = speed_mm_s;
  return options;
}

// Table 1's design: standing at 374.5205 mm, assembled from 241.99776 mm on (facts of the paper's equations).
TEST(StrokeSchedule, SoftLimitsKeepTheMarginFromStandingAndFromAssembly) {
  const actuator::SoftLimits limits = actuator::SoftLimitsOf(PublishedDesign(), 0.5);
  EXPECT_NEAR(limits.upper_mm, 374.5205 - 0.5, 1e-4);
  EXPECT_NEAR(limits.lower_mm, 242 - 0.00224 + 0.5, 1e-4);
  EXPECT_GT(actuator::KneeDegAt(kPublishedLinks, limits.upper_mm), 0);
  const actuator::SoftLimits none = actuator::SoftLimitsOf(PublishedDesign(), 0);
  EXPECT_EQ(none.lower_mm, 242);
  EXPECT_NEAR(actuator::KneeDegAt(kPublishedLinks, none.upper_mm), 0, 1e-6);
  // An actuator that ends before standing needs no margin from the linkage.
  linkage::Design shorter = PublishedDesign();
  shorter.d_max_mm = 350;
  EXPECT_EQ(actuator::SoftLimitsOf(shorter, 0.5).upper_mm, 350);
  shorter.d_max_mm = 374.4;
  EXPECT_NEAR(actuator::SoftLimitsOf(shorter, 0.5).upper_mm, 374.0205, 1e-4);
  EXPECT_THAT([] { actuator::SoftLimitsOf(PublishedDesign(), 200); },
              ThrowsMessage<Error>(HasSubstr("leaves nothing")));
}

// The paper: 5 mm/s. Travel from 242 to 374.5205 mm less the margins, in closed form.
TEST(StrokeSchedule, ConstantProgramOfThePaper) {
  const actuator::StrokeSchedule schedule = actuator::MakeSchedule(PublishedDesign(), AtSpeed(5));
  EXPECT_NEAR(schedule.Duration(), (374.0205 - 242.49776) / 5, 1e-4);
  EXPECT_EQ(schedule.reversals, 0);
  const std::vector<actuator::ScheduleRow> rows = actuator::SampleSchedule(schedule, 50, nullptr);
  EXPECT_EQ(rows.size(), static_cast<std::size_t>(std::floor(schedule.Duration() * 50)) + 2);
  double stroke = rows.front().stroke_mm;
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    ASSERT_NEAR(rows[i].speed_mm_s, 5, 1e-6);
    ASSERT_EQ(rows[i].direction, 1);
    ASSERT_TRUE(std::isnan(rows[i].duty)) << "without a table no duty is made up";
    ASSERT_NEAR(rows[i].knee_deg, actuator::KneeDegAt(kPublishedLinks, rows[i].stroke_mm), 1e-12);
    stroke += rows[i].speed_mm_s * (rows[i + 1].time_s - rows[i].time_s);
  }
  EXPECT_NEAR(stroke, rows.back().stroke_mm, 1e-9) << "speeds add up to the stroke";
  EXPECT_EQ(rows.back().direction, 0);
  EXPECT_EQ(rows.back().speed_mm_s, 0);
}

TEST(StrokeSchedule, AnglesSetTheEndsOfAConstantProgram) {
  actuator::ScheduleOptions options = AtSpeed(5);
  options.from_deg = 90;
  options.to_deg = 2;
  const actuator::StrokeSchedule schedule = actuator::MakeSchedule(PublishedDesign(), options);
  EXPECT_NEAR(actuator::KneeDegAt(kPublishedLinks, schedule.knots.front().stroke_mm), 90, 1e-9);
  EXPECT_NEAR(schedule.knots.back().stroke_mm, 373.962, 5e-4);  // d for 2 degrees
  std::swap(options.from_deg, options.to_deg);
  EXPECT_LT(actuator::MakeSchedule(PublishedDesign(), options).knots.back().stroke_mm, 373);  // sitting down retracts
  options.to_deg = 170;
  EXPECT_THAT([&] { actuator::MakeSchedule(PublishedDesign(), options); },
              ThrowsMessage<UsageError>(AllOf(HasSubstr("--to-angle 170"), HasSubstr("143.98"))));
}

TEST(StrokeSchedule, RestsAreAddedOnlyWhereAReversalLacksThem) {
  const linkage::Design design = FreeDesign(
      {{10, 300}, {12, 310}, {14, 306}, {14.04, 306}, {16, 312}, {17, 312}, {19, 308}, {21, 308.0000001}, {22, 305}});
  const actuator::StrokeSchedule schedule = actuator::MakeSchedule(design, {});
  EXPECT_EQ(schedule.knots.front().time_s, 0) << "a program's time begins at 0";
  EXPECT_EQ(schedule.reversals, 3);
  // 0.1 s at 310 mm, 0.06 s at 306 mm (0.04 s are there), none at 312 mm; 5e-8 mm/s are rest, no reversal.
  EXPECT_NEAR(schedule.added_rest_s, 0.16, 1e-12);
  EXPECT_NEAR(schedule.Duration(), 12.16, 1e-12);
  EXPECT_NEAR(schedule.StrokeAt(2.05), 310, 1e-12);
  EXPECT_NEAR(schedule.StrokeAt(2.1 + 1), 308, 1e-12);
  for (const actuator::ScheduleRow& row : actuator::SampleSchedule(schedule, 37, nullptr))
    ASSERT_EQ(row.direction, row.speed_mm_s > 0.001 ? 1 : row.speed_mm_s < -0.001 ? -1 : 0) << row.time_s;
}

TEST(StrokeSchedule, ReturnTripMirrorsTheWayThere) {
  actuator::ScheduleOptions options;
  options.return_trip = true;
  options.hold_s = 1.5;
  const actuator::StrokeSchedule schedule = actuator::MakeSchedule(FreeDesign({{0, 300}, {2, 309}, {5, 315}}), options);
  EXPECT_NEAR(schedule.Duration(), 11.5, 1e-12);
  for (double t = 0; t <= 5; t += 0.25) EXPECT_NEAR(schedule.StrokeAt(t), schedule.StrokeAt(11.5 - t), 1e-9) << t;
  options.hold_s = 0;  // then the brake's rest is put in
  EXPECT_NEAR(actuator::MakeSchedule(FreeDesign({{0, 300}, {2, 309}, {5, 315}}), options).Duration(), 10.1, 1e-12);
}

TEST(StrokeSchedule, DutyIsTheTablesAtEachRow) {
  const actuator::DutyTable table = ModelTable();
  const actuator::StrokeSchedule schedule = FreeSchedule({{0, 300}, {2, 308.8}, {4, 308.8}, {6, 300}});
  for (const actuator::ScheduleRow& row : actuator::SampleSchedule(schedule, 10, &table)) {
    // The model: extending 1.10 (12 duty - 3.2), retracting 1.20 (12 duty - 2.6) mm/s, rounded to 0.001 mm/s in the
    // file.
    const double expected = row.direction > 0   ? (4.4 / 1.10 + 3.2) / 12
                            : row.direction < 0 ? (4.4 / 1.20 + 2.6) / 12
                                                : 0;
    ASSERT_NEAR(row.duty, expected, 1e-4) << row.time_s;
  }
}

TEST(StrokeSchedule, WhatCannotBeDoneIsNamed) {
  EXPECT_THAT(
      [] {
        FreeSchedule({{0, 300}, {2, 380.5}});
      },
      ThrowsMessage<Error>(AllOf(HasSubstr("380.5"), HasSubstr("2 s"), HasSubstr("above the soft limit 374.02"))));
  EXPECT_THAT(
      [] {
        FreeSchedule({{0, 240}, {2, 300}});
      },
      ThrowsMessage<Error>(HasSubstr("below the soft limit 242.49")));
  EXPECT_THAT([] { actuator::MakeSchedule(PublishedDesign(), {}); }, ThrowsMessage<UsageError>(HasSubstr("--speed")));
  actuator::ScheduleOptions options;
  options.max_speed_mm_s = 4;
  EXPECT_THAT(
      [&] {
        actuator::MakeSchedule(FreeDesign({{0, 300}, {2, 304}, {3, 309}}), options);
      },
      ThrowsMessage<Error>(AllOf(HasSubstr("5 mm/s from 2 s to 3 s"), HasSubstr("--max-speed is 4"))));
  const actuator::DutyTable table = ModelTable();
  EXPECT_THAT(
      [&] {
        actuator::CheckSpeeds(FreeSchedule({{0, 300}, {2, 304}, {3, 316}}), table);
      },
      ThrowsMessage<Error>(AllOf(HasSubstr("12 mm/s from 2 s to 3 s"), HasSubstr("9.68 mm/s extending"))));
  EXPECT_THAT(
      [] {
        actuator::SampleSchedule(FreeSchedule({{0, 300}, {1e9, 316}}), 50, nullptr);
      },
      ThrowsMessage<Error>(HasSubstr("more than 1000000 rows")));
  EXPECT_THROW(actuator::SampleSchedule(FreeSchedule({{0, 300}, {1, 302}}), NAN, nullptr), UsageError);
}

// A program as an optimiser leaves it: wiggles that the actuator's play swallows. What is left keeps the ends and the
// large turns.
TEST(Smoothing, SmallReversalsBecomeRests) {
  actuator::ScheduleOptions how;
  how.smooth_mm = 0.15;
  const linkage::Design small = FreeDesign({{0, 300}, {4, 310}, {5, 309.88}, {9, 318}, {10, 318}, {14, 312}});
  const actuator::StrokeSchedule as_it_is = actuator::MakeSchedule(small, {});
  const actuator::StrokeSchedule smooth = actuator::MakeSchedule(small, how);
  EXPECT_EQ(as_it_is.reversals, 3);
  EXPECT_EQ(smooth.reversals, 1);
  EXPECT_NEAR(smooth.smoothed_mm, 0.06, 1e-9);
  EXPECT_EQ(as_it_is.smoothed_mm, 0);
}

TEST(Smoothing, KeepsItsWordForAnyProgram) {
  int taken_away = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> pause(0.3, 2), step(-0.6, 1);
    std::vector<linkage::StrokeProgram::Knot> knots = {{0, 300}};
    for (int i = 0; i < 40; ++i)
      knots.push_back({knots.back().time_s + pause(random),
                       knots.back().stroke_mm + (random() % 4 == 0 ? 0.05 : 1) * step(random)});
    actuator::ScheduleOptions how;
    how.smooth_mm = 0.05 + 0.3 * (seed % 7) / 7;
    const actuator::StrokeSchedule smooth = actuator::MakeSchedule(FreeDesign(knots), how);
    const actuator::StrokeSchedule plan = actuator::MakeSchedule(FreeDesign(knots), {});
    EXPECT_LE(smooth.reversals, plan.reversals) << seed;
    EXPECT_LE(smooth.smoothed_mm, how.smooth_mm) << seed;
    EXPECT_NEAR(smooth.knots.back().stroke_mm, knots.back().stroke_mm, 1e-9) << seed;
    EXPECT_NEAR(smooth.knots.front().stroke_mm, 300, 1e-9) << seed;
    taken_away += plan.reversals - smooth.reversals;
    // Without the brakes' rests the clocks agree.
    for (std::size_t i = 1; i < smooth.knots.size(); ++i)
      ASSERT_GT(smooth.knots[i].time_s, smooth.knots[i - 1].time_s) << seed;
    int small = 0;
    std::vector<double> turns;
    int last = 0;
    for (std::size_t i = 1; i < smooth.knots.size(); ++i) {
      const auto &a = smooth.knots[i - 1], &b = smooth.knots[i];
      const int direction = actuator::DirectionOf((b.stroke_mm - a.stroke_mm) / (b.time_s - a.time_s));
      if (direction == 0) continue;
      if (direction == -last) turns.push_back(a.stroke_mm);
      last = direction;
    }
    for (std::size_t i = 1; i < turns.size(); ++i)
      small += std::abs(turns[i] - turns[i - 1]) < 2 * how.smooth_mm - 1e-9;
    // Ever larger ones from the program's first stroke on, or to its last, have nothing to rest between.
    EXPECT_LE(small, 6) << seed;
  }
  EXPECT_GT(taken_away, 300);
}

// Steps in place of crawling, ramps in place of corners.

// The slowest that the model table has is 0.44 mm/s extending and 0.72 mm/s retracting.
TEST(Crawling, BecomesRestsAndStepsAtTheSlowestMeasuredSpeed) {
  const actuator::DutyTable table = ModelTable();
  actuator::StrokeSchedule schedule = FreeSchedule({{0, 300}, {1, 303}, {11, 304}, {12, 307}, {13, 307}, {14, 306.9}});
  const actuator::StrokeSchedule plan = schedule;
  const actuator::CrawlSummary crawl = actuator::StepInsteadOfCrawling(schedule, table, 0.1);
  EXPECT_EQ(crawl.stretches, 2);
  EXPECT_NEAR(crawl.duration_s, 11, 1e-9);
  EXPECT_EQ(crawl.added_rest_s, 0);
  // 0.1 mm/s: five steps of 0.2 mm, each after a rest of 2 - 0.2 / 0.44 s.
  EXPECT_NEAR(crawl.stroke_error_mm, 0.1 * (2 - 0.2 / 0.44), 1e-9);
  double worst = 0;
  for (double t = 0; t <= 12; t += 1e-3) worst = std::max(worst, std::abs(schedule.StrokeAt(t) - plan.StrokeAt(t)));
  EXPECT_NEAR(worst, 0.1 * (2 - 0.2 / 0.44), 1e-3);
  for (double t : {1.0, 3.0, 7.0, 11.0, 12.0, 14.0}) EXPECT_NEAR(schedule.StrokeAt(t), plan.StrokeAt(t), 1e-9) << t;
  for (const actuator::ScheduleRow& row : actuator::SampleSchedule(schedule, 50, &table))
    if (row.direction != 0) {
      ASSERT_GE(std::abs(row.speed_mm_s), table.Curve(row.direction).LeastMovingSpeed() * (1 - 1e-6)) << row.time_s;
    }
}

// Random programs around the slowest speed: never slower, every rest long enough for the brake, ends where it should,
// and the stated error is the largest there is.
TEST(Crawling, KeepsItsWordForAnyProgram) {
  const actuator::DutyTable table = ModelTable();
  int compared = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> pause(0.05, 2), speed(0, 1.2);
    std::vector<linkage::StrokeProgram::Knot> knots = {{0, 310}};
    for (int i = 0; i < 30; ++i) {
      const double duration = pause(random), sign = random() % 4 ? 1 : -1;
      knots.push_back({knots.back().time_s + duration, knots.back().stroke_mm + sign * speed(random) * duration});
    }
    const actuator::StrokeSchedule plan = FreeSchedule(knots);
    actuator::StrokeSchedule schedule = plan;
    const actuator::CrawlSummary crawl = actuator::StepInsteadOfCrawling(schedule, table, 0.1);
    EXPECT_GT(crawl.stretches, 0);
    EXPECT_NEAR(schedule.knots.back().stroke_mm, plan.knots.back().stroke_mm, 1e-9);
    EXPECT_NEAR(schedule.Duration(), plan.Duration() + crawl.added_rest_s, 1e-9);
    EXPECT_LE(crawl.added_rest_s, 0.1 * crawl.stretches + 1e-9);
    double rest_s = 1;
    for (std::size_t i = 0; i + 1 < schedule.knots.size(); ++i) {
      const auto &a = schedule.knots[i], &b = schedule.knots[i + 1];
      ASSERT_GT(b.time_s, a.time_s);
      const double v = (b.stroke_mm - a.stroke_mm) / (b.time_s - a.time_s);
      const int direction = actuator::DirectionOf(v);
      if (direction == 0) {
        rest_s += b.time_s - a.time_s;
        continue;
      }
      ASSERT_GE(std::abs(v), 0.998 * table.Curve(direction).LeastMovingSpeed()) << "seed " << seed;
      if (rest_s > 0) {
        ASSERT_GE(rest_s, 0.1 - 1e-9) << "seed " << seed << " at " << a.time_s;
      }
      rest_s = 0;
    }
    if (crawl.added_rest_s > 0) continue;  // then the times are not comparable
    ++compared;
    double worst = 0;
    for (double t = 0; t <= plan.Duration(); t += 1e-3)
      worst = std::max(worst, std::abs(schedule.StrokeAt(t) - plan.StrokeAt(t)));
    EXPECT_LE(worst, crawl.stroke_error_mm + 1e-6) << "seed " << seed;
  }
  EXPECT_GT(compared, 0) << "no program was compared";
}

TEST(Crawling, LeavesOtherProgramsAlone) {
  actuator::StrokeSchedule schedule = FreeSchedule({{0, 300}, {1, 305}, {2, 305}, {3, 302}});
  const actuator::StrokeSchedule plan = schedule;
  EXPECT_EQ(actuator::StepInsteadOfCrawling(schedule, ModelTable(), 0.1).stretches, 0);
  ASSERT_EQ(schedule.knots.size(), plan.knots.size());
  for (std::size_t i = 0; i < plan.knots.size(); ++i) EXPECT_EQ(schedule.knots[i].stroke_mm, plan.knots[i].stroke_mm);
}

// Constant speed v over a way s with acceleration a takes s/v + v/a.
TEST(Acceleration, ConstantProgramGetsItsRamps) {
  actuator::StrokeSchedule schedule = FreeSchedule({{0, 300}, {4, 320}});
  actuator::LimitAcceleration(schedule, 20, 0.1);
  EXPECT_NEAR(schedule.Duration(), 4 + 5.0 / 20, 1e-9);
  EXPECT_NEAR(schedule.added_rest_s, 0.25, 1e-9);
  EXPECT_NEAR(schedule.StrokeAt(0), 300, 1e-9);
  EXPECT_NEAR(schedule.StrokeAt(0.25), 300 + 5 * 0.25 / 2, 1e-9);
  EXPECT_NEAR(schedule.StrokeAt(2.125), 310, 1e-9);
  EXPECT_NEAR(schedule.StrokeAt(schedule.Duration()), 320, 1e-9);
}

TEST(Acceleration, IsKeptAndStrokesStayWithinTheCorners) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> pause(1.0, 2), speed(-5, 5);
    std::vector<linkage::StrokeProgram::Knot> knots = {{0, 310}};
    for (int i = 0; i < 15; ++i) {
      const double duration = pause(random), v = random() % 4 == 0 ? 0 : speed(random);
      knots.push_back({knots.back().time_s + duration, knots.back().stroke_mm + v * duration});
    }
    actuator::StrokeSchedule schedule = FreeSchedule(knots);
    const actuator::StrokeSchedule plan = schedule;
    actuator::LimitAcceleration(schedule, 20, 0.1);
    double low = 1e9, high = -1e9, last_speed = 0, last_length = 0.02;
    for (const auto& knot : plan.knots) low = std::min(low, knot.stroke_mm), high = std::max(high, knot.stroke_mm);
    for (std::size_t i = 0; i + 1 < schedule.knots.size(); ++i) {
      const auto &a = schedule.knots[i], &b = schedule.knots[i + 1];
      ASSERT_GT(b.time_s, a.time_s);
      ASSERT_TRUE(b.stroke_mm > low - 1e-9 && b.stroke_mm < high + 1e-9);
      const double v = (b.stroke_mm - a.stroke_mm) / (b.time_s - a.time_s), length = b.time_s - a.time_s;
      // Between the middles of two stretches; 1 % for ramps that are left out below 1 ms.
      ASSERT_LE(std::abs(v - last_speed), 20 * 1.01 * (0.5 * (length + last_length)) + 0.02) << "seed " << seed;
      last_speed = v, last_length = length;
    }
    EXPECT_NEAR(schedule.knots.back().stroke_mm, plan.knots.back().stroke_mm, 1e-9);
  }
}

TEST(Acceleration, AStretchWithoutRoomIsNamed) {
  actuator::StrokeSchedule schedule = FreeSchedule({{0, 300}, {1, 305}, {1.1, 305.1}, {2, 309.6}});
  EXPECT_THAT([&] { actuator::LimitAcceleration(schedule, 20, 0.1); },
              ThrowsMessage<Error>(AllOf(HasSubstr("1 mm/s from 1 s to 1.1 s"), HasSubstr("--max-acceleration"))));
}

}  // namespace
}  // namespace lake
