// The inverse d(theta), turning points and the used range, against scans of the closed form.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/linkage/linkage.h"
#include "linkage/random_links.h"
#include "published_links.h"

namespace lake {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(StrokesForAngle, FindTheStrokeThatMadeTheAngle) {
  testing::RandomLinks random;
  for (int i = 0; i < 5000; ++i) {
    const linkage::Links links = random.Next();
    const double stroke = random.StrokeFor(links);
    const linkage::Pose pose = linkage::RequirePose(links, stroke);
    const auto strokes = linkage::StrokesForAngle(links, pose.theta_rad);
    double nearest = HUGE_VAL;
    for (const double found : strokes) {
      nearest = std::min(nearest, std::abs(found - stroke));
      EXPECT_NEAR((linkage::RequirePose(links, found).tip - pose.shank_pin).norm(), links.l1, 1e-6);
    }
    // Where theta turns two strokes merge and each is known to the root of rounding only: sqrt(1e-16) x 100 mm.
    EXPECT_LT(nearest, 1e-5) << testing::TextOf(links) << " at " << stroke;
    EXPECT_LE(strokes.size(), 2u);
  }
}

// In a rhombus the circles of l1 and l2 always meet in the knee pivot too, where the shank would be free: no solution.
TEST(StrokesForAngle, LeavesOutTheFreeShankOfARhombus) {
  for (const double angle_deg : {10.0, 89.0, 110.0, 130.0}) {
    const auto strokes = linkage::StrokesForAngle({70, 70, 70, 70, 70, 70}, RadiansFromDegrees(angle_deg));
    ASSERT_EQ(strokes.size(), 1u) << angle_deg;
    EXPECT_NEAR(linkage::RequirePose({70, 70, 70, 70, 70, 70}, strokes[0]).theta_rad, RadiansFromDegrees(angle_deg),
                1e-9);
  }
}

TEST(StrokesForAngle, NoneBeyondTheReach) {
  EXPECT_TRUE(linkage::StrokesForAngle(kPublishedLinks, RadiansFromDegrees(175)).empty());
  EXPECT_TRUE(linkage::StrokesForAngle(kPublishedLinks, RadiansFromDegrees(-400)).empty());
}

// Sign changes of the slope on a fine grid; the closed form must find the same.
std::vector<double> ScannedTurns(const linkage::Links& links) {
  std::vector<double> turns;
  for (const linkage::StrokeRange& range : linkage::AssemblyRanges(links)) {
    constexpr int kSteps = 20000;
    double last = 0;
    for (int step = 1; step < kSteps; ++step) {
      const double stroke = range.lower_mm + range.Travel() * step / kSteps;
      const double slope = linkage::TransmissionOf(links, linkage::RequirePose(links, stroke)).radians_per_mm;
      if (last * slope < 0) turns.push_back(stroke);
      last = slope;
    }
  }
  return turns;
}

TEST(TurningStrokes, AreWhereTheSlopeChangesSign) {
  testing::RandomLinks random;
  int with_turns = 0;
  for (int i = 0; i < 60; ++i) {
    const linkage::Links links = random.Next();
    SCOPED_TRACE(testing::TextOf(links));
    const auto turns = linkage::TurningStrokes(links), scanned = ScannedTurns(links);
    ASSERT_EQ(turns.size(), scanned.size());
    for (std::size_t j = 0; j < turns.size(); ++j) EXPECT_NEAR(turns[j], scanned[j], 0.05);  // the grid's step
    with_turns += !turns.empty();
  }
  EXPECT_GT(with_turns, 10);
}

TEST(UsedRange, ThetaIsOneToOneAndEndsForTheRightReason) {
  testing::RandomLinks random;
  std::array<int, 4> ends{};
  for (int i = 0; i < 1500; ++i) {
    const linkage::Links links = random.Next();
    SCOPED_TRACE(testing::TextOf(links));
    const double d_min = random.StrokeFor(links);
    const auto d_max = i % 3 ? std::nullopt : std::optional(d_min + random.Uniform(1, 200));
    const linkage::UsedRange range = linkage::FindUsedRange(links, d_min, d_max);
    ++ends[static_cast<int>(range.end)];
    EXPECT_GE(range.stroke.upper_mm, d_min);
    if (range.end == linkage::UsedRange::End::kStanding) {
      EXPECT_NEAR(range.theta_at_upper_rad, 0, 1e-5);
    }
    if (range.end == linkage::UsedRange::End::kDMax) {
      EXPECT_EQ(range.stroke.upper_mm, *d_max);
    }
    constexpr int kSteps = 200;
    const double direction = range.theta_at_upper_rad - range.theta_at_lower_rad;
    double last = range.theta_at_lower_rad;
    for (int step = 1; step < kSteps; ++step) {
      const double stroke = range.stroke.lower_mm + range.stroke.Travel() * step / kSteps;
      const double theta = linkage::RequirePose(links, stroke).theta_rad;
      ASSERT_GE((theta - last) * direction, 0) << stroke;
      const auto found = linkage::StrokeForAngle(links, range, theta);
      ASSERT_TRUE(found) << stroke;
      ASSERT_NEAR(*found, stroke, 1e-5);
      last = theta;
    }
  }
  for (const int count : ends) EXPECT_GT(count, 20);
}

TEST(UsedRange, EndsWhereTheShankOfARhombusIsFree) {
  const linkage::Links rhombus{70, 70, 70, 70, 70, 70};
  const linkage::UsedRange range = linkage::FindUsedRange(rhombus, 70, {});
  EXPECT_NEAR(range.stroke.upper_mm, 70 * std::sqrt(5), 1e-6);
  EXPECT_NEAR(range.theta_at_upper_rad, 0, 1e-8);
  EXPECT_EQ(linkage::AssemblyRanges(rhombus).size(), 2u);
}

TEST(UsedRange, RefusesWhatCannotBe) {
  EXPECT_THAT([] { linkage::FindUsedRange(kPublishedLinks, 241, {}); },
              ThrowsMessage<Error>(HasSubstr("cannot be assembled at a stroke of 241 mm")));
  EXPECT_THAT([] { linkage::FindUsedRange(kPublishedLinks, 250, 249); },
              ThrowsMessage<Error>(HasSubstr("d_max = 249 mm must exceed d_min = 250 mm")));
}

TEST(UsedRange, HyperextensionOnRequest) {
  const linkage::UsedRange range = linkage::FindUsedRange(kPublishedLinks, 242, {}, RadiansFromDegrees(-5));
  EXPECT_NEAR(range.theta_at_upper_rad, RadiansFromDegrees(-5), 1e-12);
  EXPECT_GT(range.stroke.upper_mm, 374.5205);
}

}  // namespace
}  // namespace lake
