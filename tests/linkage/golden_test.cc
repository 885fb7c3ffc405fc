// The published design, worked out from the paper's own equations: every number to its printed digits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lake/core/angles.h"
#include "lake/linkage/linkage.h"

namespace lake {
namespace {

constexpr Links kOptimum{59.081, 68.840, 55.964, 71.849, 118.630, 287.310};  // Table 1
constexpr Links kInitial{85, 85, 85, 80, 80, 235};
constexpr double kDMin_mm = 242;

double AngleDeg(const Links& links, double stroke_mm) {
  return DegreesFromRadians(RequirePose(links, stroke_mm).theta_rad);
}

Pose PoseAt(double theta_deg) {
  const UsedRange range = FindUsedRange(kOptimum, kDMin_mm, {});
  const auto stroke = StrokeForAngle(kOptimum, range, RadiansFromDegrees(theta_deg));
  if (!stroke) throw std::runtime_error("no stroke for this angle");
  return RequirePose(kOptimum, *stroke);
}

// Eqs. (1)-(6) as the paper prints them: unsigned arccos for both beta.
double PaperAngleDeg(const Links& l, double d) {
  const double alpha1 = std::atan(l.l5 / l.l6), l7 = std::hypot(l.l5, l.l6);
  const double alpha2 = std::acos((l7 * l7 + l.l2 * l.l2 - d * d) / (2 * l7 * l.l2));
  const double l8 = std::sqrt(l.l2 * l.l2 + l.l3 * l.l3 - 2 * l.l2 * l.l3 * std::cos(M_PI - alpha1 - alpha2));
  const double beta1 = std::acos((l8 * l8 + l.l3 * l.l3 - l.l2 * l.l2) / (2 * l8 * l.l3));
  const double beta2 = std::acos((l8 * l8 + l.l4 * l.l4 - l.l1 * l.l1) / (2 * l8 * l.l4));
  return 180 - DegreesFromRadians(beta1 + beta2);
}

// Half a unit of the last printed digit.
TEST(PublishedDesign, RangeOfRotation) {
  EXPECT_NEAR(AngleDeg(kOptimum, kDMin_mm), 148.5715, 5e-5);
}

TEST(PublishedDesign, InitialPointAndItsViolation) {
  EXPECT_NEAR(AngleDeg(kInitial, kDMin_mm), 85.119, 5e-4);
  EXPECT_DOUBLE_EQ(kInitial.l1 - kInitial.l4, 5);
}

TEST(PublishedDesign, GrashofAndSingularitySlack) {
  const Grashof grashof = GrashofOf(kOptimum);
  EXPECT_EQ(grashof.type, GrashofClass::kCrankRocker);
  EXPECT_NEAR(grashof.slack_mm, 0.108, 5e-4);
  EXPECT_NEAR(DistancesToSingularities(kOptimum, RequirePose(kOptimum, kDMin_mm)).actuator_folded_mm, 0.00224, 5e-6);
}

TEST(PublishedDesign, StrokesAndTravel) {
  EXPECT_NEAR(PoseAt(2).stroke_mm, 373.962, 5e-4);
  EXPECT_NEAR(PoseAt(0).stroke_mm, 374.5205, 5e-5);
  EXPECT_NEAR(PoseAt(2).stroke_mm - kDMin_mm, 131.96, 5e-3);
  EXPECT_NEAR((PoseAt(2).stroke_mm - kDMin_mm) / 5, 26.4, 0.05);  // s at 5 mm/s
  const UsedRange range = FindUsedRange(kOptimum, kDMin_mm, {});
  EXPECT_NEAR(range.stroke.Travel(), 132.52, 5e-3);
  EXPECT_EQ(range.end, UsedRange::End::kStanding);
}

TEST(PublishedDesign, ContinuesWhereTheArccosFormFoldsBack) {
  // phi passes 180 degrees where the slewing bar points straight down: |(0, l3 - l2) - M| by Pythagoras.
  const double fold_mm = std::hypot(kOptimum.l5, kOptimum.l6 + kOptimum.l2);
  EXPECT_NEAR(fold_mm, 375.3877, 5e-5);
  EXPECT_NEAR(AngleDeg(kOptimum, 377), -44.84, 5e-3);
  EXPECT_NEAR(PaperAngleDeg(kOptimum, 377), 3.57, 5e-3);
  for (double d = kDMin_mm; d < fold_mm; d += 0.37)
    EXPECT_NEAR(AngleDeg(kOptimum, d), PaperAngleDeg(kOptimum, d), 1e-6) << d;
}

TEST(PublishedDesign, ActuatorForceForFortyNewtonMetres) {
  const auto force = [](double theta_deg) { return ActuatorForce(TransmissionOf(kOptimum, PoseAt(theta_deg)), 40); };
  EXPECT_NEAR(force(90), 571, 0.5);
  EXPECT_NEAR(force(100), 604, 0.5);
  EXPECT_NEAR(force(140), 2060, 5);
  EXPECT_NEAR(force(148.5), 41000, 500);
  EXPECT_NEAR(force(2), 2160, 5);
}

TEST(PublishedDesign, TransmissionAngle) {
  const auto transmission = [](double theta_deg) {
    return DegreesFromRadians(TransmissionOf(kOptimum, PoseAt(theta_deg)).transmission_rad);
  };
  EXPECT_NEAR(transmission(90), 87.0, 0.05);
  EXPECT_NEAR(transmission(2), 3.6, 0.05);
}

}  // namespace
}  // namespace lake
