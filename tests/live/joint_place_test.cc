// What is said of a joint's place: its intervals, the way to move it, the tolerance.
#include "lake/live/joint_place.h"

#include <gtest/gtest.h>

#include <random>

namespace lake::test {
namespace {

using live::JointPlace;
using live::RiseOffset;
using live::ToleranceVerdict;

JointPlace At(double x_mm, double y_mm, double half_width_mm = 2) {
  JointPlace place;
  place.rises = 1;
  place.offset_mm = {x_mm, y_mm};
  place.half_width_mm = {half_width_mm, half_width_mm};
  return place;
}

TEST(JointPlace, SaysTheWayToTheKnee) {
  EXPECT_EQ(live::MoveText(At(12, 30, 2.6), 5), "Move the joint 12 mm back and 30 mm down (± 3 mm)");
  EXPECT_EQ(live::MoveText(At(-7.4, -20), 5), "Move the joint 7 mm forward and 20 mm up (± 2 mm)");
}

TEST(JointPlace, DoesNotSayWhatIsWithinItsInterval) {
  EXPECT_EQ(live::MoveText(At(12, 1.5), 5), "Move the joint 12 mm back (± 2 mm)");
  EXPECT_EQ(live::MoveText(At(0, -5), 5), "Move the joint 5 mm up (± 2 mm)");
  EXPECT_EQ(live::MoveText(At(1, 1.5), 5), "Leave the joint where it is (± 2 mm)");
}

// It is known where the joint would be nearer, and that it need not be.
TEST(JointPlace, AJointWithinTheToleranceIsLeftWhereItIs) {
  EXPECT_EQ(live::MoveText(At(3, 0), 6), "Leave the joint where it is (± 2 mm)");
  EXPECT_EQ(live::MoveText(At(3, 0), 4), "Move the joint 3 mm back (± 2 mm)");
}

// Neither a move nor to leave it: the interval holds more than the tolerance.
TEST(JointPlace, DoesNotTakeNotKnowingForAPlace) {
  JointPlace wide = At(4, 0, 17.2);
  EXPECT_EQ(live::MoveText(wide, 5), "The joint's place is not known well enough yet (± 18 mm): one more rise");
  wide.fixed_half_width_mm = {17, 17};
  EXPECT_FALSE(wide.DoRisesNarrow());
  EXPECT_EQ(live::MoveText(wide, 5), "The joint's distance cannot be distinguished from 5 mm (± 18 mm)");
  EXPECT_EQ(live::ChangeText(At(10, 0), wide), "No measurable difference from before the last move (± 18 mm)");
  EXPECT_EQ(live::ChangeText(At(10, 0), At(9, 0)),
            "No measurable difference from before the last move (± 3 mm): one more rise");
}

// 10 mm of depth times a slope of 0.1, 1.96 standard deviations.
TEST(JointPlace, NoRiseNarrowsWhatParallaxLeavesOpen) {
  EXPECT_NEAR(live::LeastUncertaintyMm(), 1.96, 0.001);
  std::vector<RiseOffset> rises(1);
  rises[0].noise_sd_mm = {2, 2};
  EXPECT_TRUE(live::PlaceOf(rises).DoRisesNarrow());
  rises.resize(20, rises[0]);
  EXPECT_FALSE(live::PlaceOf(rises).DoRisesNarrow());
  EXPECT_GT(live::PlaceOf(rises).UncertaintyMm(), live::LeastUncertaintyMm());
  RiseOffset rebuilt;
  rebuilt.rebuilt_sd_mm = 2;
  EXPECT_NEAR(live::LeastUncertaintyMm(rebuilt), 1.96 * std::hypot(1, 2), 0.01);
}

TEST(JointPlace, ATestOfTheToleranceTakesTheInterval) {
  EXPECT_EQ(live::JudgeTolerance(At(3, 0), 5), ToleranceVerdict::kWithin);
  EXPECT_EQ(live::JudgeTolerance(At(4, 0), 5), ToleranceVerdict::kUndecided);
  EXPECT_EQ(live::JudgeTolerance(At(0, -8), 5), ToleranceVerdict::kBeyond);
}

TEST(JointPlace, SaysWhatAMoveDid) {
  EXPECT_EQ(live::ChangeText(At(30, 0), At(10, 0)), "20 mm nearer to the knee than before the last move (± 3 mm)");
  EXPECT_EQ(live::ChangeText(At(10, 0), At(0, 15)), "5 mm farther from the knee than before the last move (± 3 mm)");
}

// Rises that scatter by 1.5 mm about a place which is itself off by what plane and parallax make (1 mm by default).
TEST(JointPlace, ItsIntervalsHoldTheTruth) {
  constexpr double kScatter_mm = 1.5, kParallax_mm = 1;
  constexpr int kPlaces = 2000;
  std::mt19937_64 random(38);
  std::normal_distribution<double> normal;
  for (const std::size_t rises : {1u, 2u, 4u}) {
    int held = 0;
    for (int i = 0; i < kPlaces; ++i) {
      const double off = kParallax_mm * normal(random);
      std::vector<RiseOffset> seen(rises);
      for (RiseOffset& rise : seen) {
        rise.mean_mm = {18 + off + kScatter_mm * normal(random), 0};
        rise.noise_sd_mm = {kScatter_mm, kScatter_mm};
      }
      const JointPlace place = live::PlaceOf(seen);
      held += std::abs(place.offset_mm.x() - 18) <= place.half_width_mm.x();
    }
    // Of 2000 at 95 % the standard deviation is 0.5 %; the larger of noise and spread makes intervals too wide.
    EXPECT_GE(held, kPlaces * 0.935) << rises;
    // One rise has no spread, so its interval is of the noise alone, and just as wide as it should be.
    if (rises == 1) {
      EXPECT_LE(held, kPlaces * 0.965);
    }
  }
}

TEST(JointPlace, OfTheJointBeneathTheSkinLessIsKnown) {
  const std::vector<RiseOffset> one(1);
  const JointPlace place = live::PlaceOf(one);
  // 3 mm of the marker's place and 7 mm of soft tissue, 1.96 standard deviations.
  EXPECT_NEAR(place.anatomical_half_width_mm.x(), 1.96 * std::sqrt(3 * 3 + 7 * 7 + 1), 0.05);
}

}  // namespace
}  // namespace lake::test
