// Where a joint is against the knee of the leg that wears it, on curves whose answer is known.
#include "lake/compare/joint_misalignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "closed_form.h"
#include "lake/compare/misalignment.h"
#include "lake/compare/pointwise_error.h"

namespace lake {
namespace {

// A leg that leans from −10° to 25° at the shank while the knee extends by 90°, with a joint at a place of its shank.
compare::StsCurve Worn(const Eigen::Vector2d& joint_mm, double sigma_mm = 0.05) {
  compare::StsCurve curve;
  for (int i = 0; i < compare::kPercentSamples; ++i) {
    const double shank = (25 - 0.35 * i) * M_PI / 180, thigh = shank - (95 - 0.9 * i) * M_PI / 180;
    const Eigen::Vector2d up(std::sin(shank), std::cos(shank)), forward(std::cos(shank), -std::sin(shank));
    curve.ankle.emplace_back(0.02 * i, 0);
    curve.leg_knee.push_back(curve.ankle.back() + 400 * up);
    curve.hip.push_back(curve.leg_knee.back() + 410 * Eigen::Vector2d(std::sin(thigh), std::cos(thigh)));
    curve.knee.push_back(curve.leg_knee.back() + joint_mm.x() * forward + joint_mm.y() * up);
    curve.knee_deg.push_back(95 - 0.9 * i);
    curve.knee_sigma_mm.push_back(sigma_mm);
  }
  curve.duration_s = 2;
  return curve;
}

const std::vector<bool> kNoSpike(compare::kPercentSamples, false);

TEST(JointMisalignment, IsThePlaceInTheShanksFrame) {
  const auto joint = compare::FindJointMisalignment({{Worn({18, -24})}, {}}, kNoSpike);
  ASSERT_TRUE(joint);
  EXPECT_NEAR(joint->rms_mm, 30, 1e-9);
  EXPECT_NEAR(joint->max_mm, 30, 1e-9);
  EXPECT_NEAR(joint->relative_rms, 30 / 400.0, 1e-12);
  EXPECT_NEAR((joint->mean_mm - Eigen::Vector2d(18, -24)).norm(), 0, 1e-9);
  EXPECT_NEAR(joint->remainder_mm, 0, 1e-5);  // the root of a difference of squares
  // At 95° of flexion the thigh's axes are turned against the shank's by that angle.
  const double turn = 95 * M_PI / 180;
  const Eigen::Vector2d in_thigh(18 * std::cos(turn) - 24 * std::sin(turn), -24 * std::cos(turn) - 18 * std::sin(turn));
  EXPECT_NEAR((joint->thigh_mm[0] - in_thigh).norm(), 0, 1e-9);
}

// A joint on the shank's line, 40 mm above the knee of a leg bent by θ: seen from there the leg is bent by θ more than
// atan(40 sin θ / (410 − 40 cos θ)) says the thigh turns.
TEST(JointMisalignment, AngleIsTheOneThatItsMarkersMake) {
  const auto joint = compare::FindJointMisalignment({{Worn({0, 40})}, {}}, kNoSpike);
  ASSERT_TRUE(joint);
  double square = 0;
  for (int i = 0; i < compare::kPercentSamples; ++i) {
    const double theta = (95 - 0.9 * i) * M_PI / 180;
    square += std::pow(std::atan2(40 * std::sin(theta), 410 - 40 * std::cos(theta)) * 180 / M_PI, 2);
  }
  EXPECT_NEAR(joint->angle_rms_deg, std::sqrt(square / compare::kPercentSamples), 1e-9);
}

// The trial's own leg is 10 mm longer at the shank and its joint is beside the knee: moved there, its path is the
// knee's, and differs by those 10 mm from the human's.
TEST(JointMisalignment, MovedItsPathIsTheOwnKnees) {
  compare::StsCurve human = Worn({0, 0}), exo = Worn({18, 32});
  human.leg_knee.clear();
  for (std::size_t i = 0; i < exo.knee.size(); ++i) {
    const Eigen::Vector2d up = (exo.leg_knee[i] - exo.ankle[i]).normalized();
    exo.leg_knee[i] += 10 * up;
    exo.knee[i] += 10 * up;
  }
  compare::MisalignmentOptions options;
  options.intervals = false;
  const compare::Misalignment m = compare::CompareTrials({{human}, {}}, {{exo}, {}}, options);
  ASSERT_TRUE(m.joint_moved);
  EXPECT_NEAR(m.joint_moved->rms_mm, 10, 1e-9);
  EXPECT_NEAR(m.joint_moved->relative_rms, 10 / 400.0, 1e-12);
  EXPECT_FALSE(m.joint_moved->intervals);
  exo.leg_knee.clear();
  EXPECT_FALSE(compare::CompareTrials({{human}, {}}, {{exo}, {}}, options).joint_moved);
}

// The same rise of a leg that leans by 3° more, with a joint beside its knee.
compare::StsCurve Leaning(compare::StsCurve curve) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-3 * M_PI / 180).toRotationMatrix();
  for (auto* points : {&curve.knee, &curve.leg_knee, &curve.hip})
    for (std::size_t i = 0; i < points->size(); ++i)
      (*points)[i] = curve.ankle[i] + turn * ((*points)[i] - curve.ankle[i]);
  return curve;
}

// What moving the joint removes is its place against the knee that it is worn on. How the leg leans is neither that nor
// pace.
TEST(JointMisalignment, PostureIsNoPlacement) {
  compare::StsCurve human = Worn({0, 0});
  human.leg_knee.clear();
  compare::MisalignmentOptions options;
  const compare::Misalignment m = compare::CompareTrials({{human}, {}}, {{Leaning(Worn({12, -20}))}, {}}, options);
  ASSERT_TRUE(m.joint);
  const compare::Decomposition& parts = m.decomposition;
  EXPECT_NEAR((parts.offset_mm - Eigen::Vector2d(12, -20)).norm(), 0, 1e-6);
  EXPECT_NEAR(std::sqrt(compare::MeanSquare(parts.placement_mm)), std::hypot(12, 20), 1e-6);
  EXPECT_LT(std::sqrt(compare::MeanSquare(parts.timing_mm)), 0.1);
  // The person's knee moves by 3° of 400 mm, and the joint's offset is turned by as much.
  EXPECT_NEAR(std::sqrt(compare::MeanSquare(parts.shape_mm)), 2 * 400 * std::sin(1.5 * M_PI / 180), 1.5);
  EXPECT_NEAR(parts.placement + parts.timing + parts.shape, 1, 1e-9);
}

// Another pace is found by the knee's angle, whatever the leg's lean.
TEST(JointMisalignment, PaceIsTiming) {
  const ClosedFormLeg leg;
  const compare::StsCurve human = MakeCurve(leg);
  compare::StsCurve exo = MakeCurve(leg, IssueWarp, {12, -20});
  exo.leg_knee = MakeCurve(leg, IssueWarp).knee;
  compare::MisalignmentOptions options;
  options.intervals = false;
  for (const bool leans : {false, true}) {
    const compare::Misalignment m = compare::CompareTrials({{human}, {}}, {{leans ? Leaning(exo) : exo}, {}}, options);
    EXPECT_NEAR((m.decomposition.offset_mm - Eigen::Vector2d(12, -20)).norm(), 0, 1e-6);
    // Before the knee extends, from 10 % on, its angle does not tell the pace.
    for (int percent = 25; percent <= 90; ++percent)
      EXPECT_NEAR(m.decomposition.timing_percent[static_cast<std::size_t>(percent)],
                  100 * (IssueWarp(percent / 100.0) - percent / 100.0), 0.5)
          << percent;
  }
}

TEST(JointMisalignment, SpikesAndRepetitionsWithoutAKneeAreLeftOut) {
  compare::StsCurve spiked = Worn({10, 0}), hidden = Worn({90, 0});
  spiked.knee[50] += Eigen::Vector2d(200, 0);
  hidden.leg_knee.clear();
  std::vector<bool> spike = kNoSpike;
  spike[50] = true;
  const auto joint = compare::FindJointMisalignment({{spiked, hidden}, {}}, spike);
  ASSERT_TRUE(joint);
  EXPECT_EQ(joint->repetitions, 1);
  EXPECT_NEAR(joint->max_mm, 10, 1e-9);
  EXPECT_FALSE(compare::FindJointMisalignment({{hidden}, {}}, kNoSpike));
  EXPECT_FALSE(compare::FindJointMisalignment({{spiked}, {}}, std::vector<bool>(compare::kPercentSamples, true)));
}

// The joint slips by 3 mm (SD) per axis from rise to rise: the intervals hold where it is on average.
TEST(JointMisalignment, IntervalsHoldTheTruth) {
  for (const std::size_t repetitions : {3U, 5U, 10U}) {
    constexpr int kDraws = 300;
    std::mt19937 random(7);
    std::normal_distribution<double> slip(0, 3);
    int held_x = 0, held_y = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      compare::RegisteredTrial trial;
      for (std::size_t r = 0; r < repetitions; ++r) {
        const double x = 12 + slip(random), y = -20 + slip(random);
        trial.repetitions.push_back(Worn({x, y}));
      }
      const auto joint = compare::FindJointMisalignment(trial, kNoSpike);
      ASSERT_TRUE(joint && joint->intervals);
      const auto holds = [](const compare::Interval& i, double truth) { return i.low <= truth && truth <= i.high; };
      held_x += holds(joint->intervals->mean_x_mm, 12);
      held_y += holds(joint->intervals->mean_y_mm, -20);
    }
    // 95 % of 600, known to 0.9 %.
    EXPECT_GE(held_x + held_y, 0.90 * 2 * kDraws) << repetitions;
    EXPECT_LE(held_x + held_y, 0.98 * 2 * kDraws) << repetitions;
  }
}

}  // namespace
}  // namespace lake
