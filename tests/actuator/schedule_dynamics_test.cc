// Steps in place of crawling, ramps in place of corners.
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
