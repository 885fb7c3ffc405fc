// What an exoskeleton does to pace and posture, on curves whose answer is known.
#include "lake/compare/pace_and_posture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lake {
namespace {

compare::StsCurve Rise(double duration_s, double shank_deg, double trunk_deg) {
  compare::StsCurve curve;
  curve.duration_s = duration_s;
  curve.seat_off_s = 0.4 * duration_s;
  curve.shank_deg.assign(compare::kPercentSamples, shank_deg);
  curve.trunk_deg.assign(compare::kPercentSamples, trunk_deg);
  return curve;
}

TEST(PaceAndPosture, DifferencesAreTheExoskeletonsLessTheHumans) {
  const compare::RegisteredTrial human{{Rise(2, 10, 30), Rise(2.2, 12, 32)}, {}}, exo{{Rise(3, 15, 30)}, {}};
  const compare::Pace pace = compare::ComparePace(human, exo);
  EXPECT_NEAR(pace.repetition.Value(), 0.9, 1e-12);
  EXPECT_NEAR(pace.onset_to_seat_off->Value(), 0.36, 1e-12);
  EXPECT_NEAR(pace.seat_off_to_standing->Value(), 0.54, 1e-12);
  EXPECT_FALSE(pace.repetition.interval);
  const compare::Posture posture = compare::ComparePosture(human, exo);
  EXPECT_NEAR(posture.shank->mean_deg.Value(), 4, 1e-12);
  EXPECT_NEAR(posture.shank->rms_deg, 4, 1e-12);
  EXPECT_NEAR(posture.trunk->mean_deg.Value(), -1, 1e-12);
  EXPECT_NEAR(posture.trunk->max_deg, 1, 1e-12);
}

// Student's t of 2 degrees of freedom is 4.3027 at 97.5 %; the mean of 2, 2.2, 2.1 is 2.1, their deviation 0.1.
TEST(PaceAndPosture, AMeanOfSeveralRisesHasAnInterval) {
  const compare::RegisteredTrial three{{Rise(2, 10, 30), Rise(2.2, 10, 30), Rise(2.1, 10, 30)}, {}},
      one{{Rise(3, 10, 30)}, {}};
  const compare::Difference rise = compare::ComparePace(one, three).repetition;
  EXPECT_FALSE(rise.human_interval);
  ASSERT_TRUE(rise.exo_interval);
  EXPECT_NEAR(rise.exo_interval->low, 2.1 - 4.3027 * 0.1 / std::sqrt(3), 1e-5);
  EXPECT_NEAR(rise.exo_interval->high, 2.1 + 4.3027 * 0.1 / std::sqrt(3), 1e-5);
}

TEST(PaceAndPosture, WhatATrialDoesNotShowIsAbsent) {
  compare::StsCurve no_waist = Rise(2, 10, NAN), no_seat_off = Rise(2, 10, 30);
  no_seat_off.seat_off_s.reset();
  const compare::RegisteredTrial whole{{Rise(2, 10, 30)}, {}};
  EXPECT_FALSE(compare::ComparePosture(whole, {{no_waist}, {}}).trunk);
  EXPECT_TRUE(compare::ComparePosture(whole, {{no_waist}, {}}).shank);
  EXPECT_FALSE(compare::ComparePace({{no_seat_off}, {}}, whole).onset_to_seat_off);
}

// Of 600 pairs of trials whose rises scatter by 0.1 and 0.3 s: 95 % within three binomial deviations.
TEST(PaceAndPosture, IntervalsHoldTheTruth) {
  for (const int repetitions : {3, 5}) {
    constexpr int kPairs = 600;
    int held = 0;
    for (unsigned seed = 0; seed < kPairs; ++seed) {
      std::mt19937 random(seed);
      std::normal_distribution<double> normal;
      compare::RegisteredTrial human, exo;
      for (int i = 0; i < repetitions; ++i) {
        human.repetitions.push_back(Rise(2 + 0.1 * normal(random), 10, 30));
        exo.repetitions.push_back(Rise(3 + 0.3 * normal(random), 10, 30));
      }
      const compare::Difference rise = compare::ComparePace(human, exo).repetition;
      held += rise.interval->low <= 1 && 1 <= rise.interval->high;
    }
    EXPECT_NEAR(held / static_cast<double>(kPairs), 0.95, 3 * std::sqrt(0.95 * 0.05 / kPairs)) << repetitions;
  }
}

}  // namespace
}  // namespace lake
