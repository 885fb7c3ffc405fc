// The body's centre of mass and its momentum against closed forms.
#include "lake/loads/centre_of_mass.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lake::loads {
namespace {

using Eigen::Vector2d;

constexpr double kBody_kg = 70, kLower_m = 0.4, kUpper_m = 0.42, kBack_m = 0.5;

LegBody BodyOf70Kg() {
  LegBody body;
  body.foot = {1, 0.05, 0.06};
  body.shank = {3.2, 0.17, 0.12};
  body.thigh = {7.1, 0.18, 0.13};
  body.trunk = {20, 0.3, 0.24};  // this leg bears less than half of the 47.4 kg that both legs leave
  body.ankle_height_m = 0.07;
  return body;
}

// A smooth angle from the vertical, positive leaning forward, with its rate.
struct SwingingTilt {
  double mean, swing, rate;
  double At(double t) const { return mean + swing * std::sin(rate * t); }
  double Rate(double t) const { return swing * rate * std::cos(rate * t); }
};
constexpr SwingingTilt kShankTilt{0.3, 0.2, 3}, kThighTilt{-0.7, 0.6, 2}, kTrunkTilt{0.4, 0.5, 4};

PointMotion EndOf(const PointMotion& lower, double length_m, double tilt, double rate) {
  PointMotion upper = lower;
  upper.position_m += length_m * Vector2d(std::sin(tilt), std::cos(tilt));
  upper.velocity_m_s += length_m * rate * Vector2d(std::cos(tilt), -std::sin(tilt));
  return upper;
}

LegPoints SwingingLeg(double t, const SwingingTilt& shank, const SwingingTilt& thigh, const SwingingTilt& trunk) {
  LegPoints points;
  points[kAnkle].position_m = {0.8, 0.09};
  points[kKnee] = EndOf(points[kAnkle], kLower_m, shank.At(t), shank.Rate(t));
  points[kHip] = EndOf(points[kKnee], kUpper_m, thigh.At(t), thigh.Rate(t));
  points[kTrunkTop] = EndOf(points[kHip], kBack_m, trunk.At(t), trunk.Rate(t));
  return points;
}

// By angles alone, from the ground under the ankle.
Vector2d CentreByAngles(double t, double along_m, double across_m) {
  const auto up = [](double tilt) { return Vector2d(std::sin(tilt), std::cos(tilt)); };
  const Vector2d ankle(0, 0.07), shank = up(kShankTilt.At(t)), thigh = up(kThighTilt.At(t)),
                                 trunk = up(kTrunkTilt.At(t)), forward(trunk.y(), -trunk.x());
  const Vector2d knee = ankle + 0.4 * shank, hip = knee + 0.42 * thigh;
  return (2 * 1 * Vector2d(0.05, 0.035) + 2 * 3.2 * (knee - 0.17 * shank) + 2 * 7.1 * (hip - 0.18 * thigh) +
          47.4 * (hip + (0.3 + along_m) * trunk + across_m * forward)) /
         70;
}

TEST(CentreOfMass, IsTheSegmentsMean) {
  for (double t = 0; t < 2; t += 0.1) {
    const CentreOfMass centre =
        CentreOfMassOf(SwingingLeg(t, kShankTilt, kThighTilt, kTrunkTilt), BodyOf70Kg(), kBody_kg, {0.04, -0.03});
    constexpr double kStep_s = 1e-5;
    EXPECT_LT((centre.position_m - CentreByAngles(t, 0.04, -0.03)).norm(), 1e-12) << t;
    const Vector2d rate =
        (CentreByAngles(t + kStep_s, 0.04, -0.03) - CentreByAngles(t - kStep_s, 0.04, -0.03)) / (2 * kStep_s);
    EXPECT_LT((centre.velocity_m_s - rate).norm(), 1e-8) << t;
  }
}

// A straight body that falls forward about its ankle by a(1 − cos wt)/2: speeds are known at every moment.
TEST(CentreOfMass, PeaksAndSeatOffAreThoseOfAFallingPole) {
  constexpr double kLean = 0.6, kRate = M_PI / 1.5;
  LegPath path;
  for (int i = 0; i <= 200; ++i) {
    const double t = i / 100.0;
    LegPoints points = SwingingLeg(0, {}, {}, {});
    const double tilt = kLean * (1 - std::cos(kRate * t)) / 2, rate = kLean * kRate * std::sin(kRate * t) / 2;
    points[kKnee] = EndOf(points[kAnkle], kLower_m, tilt, rate);
    points[kHip] = EndOf(points[kKnee], kUpper_m, tilt, rate);
    points[kTrunkTop] = EndOf(points[kHip], kBack_m, tilt, rate);
    path.time_s.push_back(t);
    path.frames.push_back(points);
    path.known.push_back(1);
  }
  // What is above the ankle, times its distance from it, over the body's mass.
  const double arm_m = (2 * 3.2 * (0.4 - 0.17) + 2 * 7.1 * (0.82 - 0.18) + 47.4 * (0.82 + 0.3)) / 70;
  const auto forward = [&](double t) {
    const double tilt = kLean * (1 - std::cos(kRate * t)) / 2;
    return arm_m * std::cos(tilt) * kLean * kRate * std::sin(kRate * t) / 2;
  };
  double largest = 0, at_s = 0;
  for (double t = 0; t <= 1.5; t += 1e-4)
    if (forward(t) > largest) largest = forward(t), at_s = t;
  const RiseMomentum momentum = FindMomentum(path, BodyOf70Kg(), kBody_kg, Vector2d::Zero(), 0, 0.9, 1.5);
  ASSERT_EQ(momentum.rows.size(), 101u);
  EXPECT_NEAR(momentum.forward_max_m_s, largest, 1e-3 * largest);
  EXPECT_NEAR(momentum.forward_lead_s, 0.9 - at_s, 0.0151);  // a percent of the rise
  EXPECT_NEAR(momentum.forward_seat_off_m_s, forward(0.9), 1e-6);
  EXPECT_NEAR(momentum.upward_max_m_s, 0, 1e-9);  // it only falls
  const double tilt = kLean * (1 - std::cos(kRate * 0.9)) / 2;
  EXPECT_NEAR(momentum.seat_off_m, arm_m * std::sin(tilt) + 2 * 1 * 0.05 / 70, 1e-6);
  path.known[90] = 0;
  const RiseMomentum gap = FindMomentum(path, BodyOf70Kg(), kBody_kg, Vector2d::Zero(), 0, 0.9, 1.5);
  EXPECT_TRUE(std::isnan(gap.seat_off_m));
  EXPECT_NEAR(gap.forward_lead_s, momentum.forward_lead_s, 1e-9);
  path.known.assign(path.known.size(), 0);
  const RiseMomentum unknown = FindMomentum(path, BodyOf70Kg(), kBody_kg, Vector2d::Zero(), 0, 0.9, 1.5);
  EXPECT_TRUE(std::isnan(unknown.forward_max_m_s));
  EXPECT_TRUE(std::isnan(unknown.forward_lead_s)) << "of a largest velocity that is not known";
}

}  // namespace
}  // namespace lake::loads
