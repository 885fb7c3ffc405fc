// The published design, worked out from the paper's own equations: every number to its printed digits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/linkage/linkage.h"
#include "places.h"
#include "published_links.h"

namespace lake {
namespace {

constexpr linkage::Links kInitial{85, 85, 85, 80, 80, 235};
constexpr double kDMin_mm = 242;

double AngleDeg(const linkage::Links& links, double stroke_mm) {
  return DegreesFromRadians(linkage::RequirePose(links, stroke_mm).theta_rad);
}

linkage::Pose PoseAt(double theta_deg) {
  const linkage::UsedRange range = linkage::FindUsedRange(kPublishedLinks, kDMin_mm, {});
  const auto stroke = linkage::StrokeForAngle(kPublishedLinks, range, RadiansFromDegrees(theta_deg));
  if (!stroke) throw std::runtime_error("no stroke for this angle");
  return linkage::RequirePose(kPublishedLinks, *stroke);
}

// Eqs. (1)-(6) as the paper prints them: unsigned arccos for both beta.
double PaperAngleDeg(const linkage::Links& l, double d) {
  const double alpha1 = std::atan(l.l5 / l.l6), l7 = std::hypot(l.l5, l.l6);
  const double alpha2 = std::acos((l7 * l7 + l.l2 * l.l2 - d * d) / (2 * l7 * l.l2));
  const double l8 = std::sqrt(l.l2 * l.l2 + l.l3 * l.l3 - 2 * l.l2 * l.l3 * std::cos(M_PI - alpha1 - alpha2));
  const double beta1 = std::acos((l8 * l8 + l.l3 * l.l3 - l.l2 * l.l2) / (2 * l8 * l.l3));
  const double beta2 = std::acos((l8 * l8 + l.l4 * l.l4 - l.l1 * l.l1) / (2 * l8 * l.l4));
  return 180 - DegreesFromRadians(beta1 + beta2);
}

TEST(PaperTables, HoldTheLinksUsedHere) {
  const CsvTable table = CsvTable::Read(SourceDir() / "data/paper/table1.csv");
  ASSERT_EQ(table.Rows(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(table.RequiredNumber(i, table.Column("initial_mm")), kInitial.Values()[i]);
    EXPECT_EQ(table.RequiredNumber(i, table.Column("optimum_mm")), kPublishedLinks.Values()[i]);
  }
}

// A parallelogram on a square: every quantity can be seen without a calculator (libs/design/linkage/README.md).
TEST(CheckPose, ParallelogramAtARightAngle) {
  const linkage::Links links{60, 72, 60, 72, 72, 240};
  const linkage::Pose pose = linkage::RequirePose(links, 240);
  const linkage::Transmission transmission = linkage::TransmissionOf(links, pose);
  constexpr double kRounding = 1e-12;
  EXPECT_NEAR(DegreesFromRadians(pose.theta_rad), 90, kRounding * 90);
  EXPECT_NEAR(DegreesFromRadians(pose.phi_rad), 90, kRounding * 90);
  EXPECT_NEAR((pose.tip - Eigen::Vector2d(72, 60)).norm(), 0, kRounding * 72);
  EXPECT_NEAR((pose.shank_pin - Eigen::Vector2d(72, 0)).norm(), 0, kRounding * 72);
  EXPECT_NEAR(transmission.moment_arm_mm, 72, kRounding * 72);
  EXPECT_NEAR(DegreesFromRadians(transmission.transmission_rad), 90, kRounding * 90);
  EXPECT_NEAR(DegreesFromRadians(transmission.actuator_rad), 90, kRounding * 90);
  EXPECT_NEAR(linkage::ActuatorForce(transmission, 72), 1000, 1e-9);
}

// Half a unit of the last printed digit.
TEST(PublishedDesign, RangeOfRotation) {
  EXPECT_NEAR(AngleDeg(kPublishedLinks, kDMin_mm), 148.5715, 5e-5);
}

TEST(PublishedDesign, InitialPointAndItsViolation) {
  EXPECT_NEAR(AngleDeg(kInitial, kDMin_mm), 85.119, 5e-4);
  EXPECT_DOUBLE_EQ(kInitial.l1 - kInitial.l4, 5);
}

TEST(PublishedDesign, GrashofAndSingularitySlack) {
  const linkage::Grashof grashof = linkage::GrashofOf(kPublishedLinks);
  EXPECT_EQ(grashof.type, linkage::GrashofClass::kCrankRocker);
  EXPECT_NEAR(grashof.slack_mm, 0.108, 5e-4);
  EXPECT_NEAR(linkage::DistancesToSingularities(kPublishedLinks, linkage::RequirePose(kPublishedLinks, kDMin_mm))
                  .actuator_folded_mm,
              0.00224, 5e-6);
}

TEST(PublishedDesign, StrokesAndTravel) {
  EXPECT_NEAR(PoseAt(2).stroke_mm, 373.962, 5e-4);
  EXPECT_NEAR(PoseAt(0).stroke_mm, 374.5205, 5e-5);
  EXPECT_NEAR(PoseAt(2).stroke_mm - kDMin_mm, 131.96, 5e-3);
  EXPECT_NEAR((PoseAt(2).stroke_mm - kDMin_mm) / 5, 26.4, 0.05);  // s at 5 mm/s
  const linkage::UsedRange range = linkage::FindUsedRange(kPublishedLinks, kDMin_mm, {});
  EXPECT_NEAR(range.stroke.Travel(), 132.52, 5e-3);
  EXPECT_EQ(range.end, linkage::UsedRange::End::kStanding);
}

TEST(PublishedDesign, ContinuesWhereTheArccosFormFoldsBack) {
  // phi passes 180 degrees where the slewing bar points straight down: |(0, l3 - l2) - M| by Pythagoras.
  const double fold_mm = std::hypot(kPublishedLinks.l5, kPublishedLinks.l6 + kPublishedLinks.l2);
  EXPECT_NEAR(fold_mm, 375.3877, 5e-5);
  EXPECT_NEAR(AngleDeg(kPublishedLinks, 377), -44.84, 5e-3);
  EXPECT_NEAR(PaperAngleDeg(kPublishedLinks, 377), 3.57, 5e-3);
  for (double d = kDMin_mm; d < fold_mm; d += 0.37)
    EXPECT_NEAR(AngleDeg(kPublishedLinks, d), PaperAngleDeg(kPublishedLinks, d), 1e-6) << d;
}

TEST(PublishedDesign, ActuatorForceForFortyNewtonMetres) {
  const auto force = [](double theta_deg) {
    return linkage::ActuatorForce(linkage::TransmissionOf(kPublishedLinks, PoseAt(theta_deg)), 40);
  };
  EXPECT_NEAR(force(90), 571, 0.5);
  EXPECT_NEAR(force(100), 604, 0.5);
  EXPECT_NEAR(force(140), 2060, 5);
  EXPECT_NEAR(force(148.5), 41000, 500);
  EXPECT_NEAR(force(2), 2160, 5);
}

TEST(PublishedDesign, TransmissionAngle) {
  const auto transmission = [](double theta_deg) {
    return DegreesFromRadians(linkage::TransmissionOf(kPublishedLinks, PoseAt(theta_deg)).transmission_rad);
  };
  EXPECT_NEAR(transmission(90), 87.0, 0.05);
  EXPECT_NEAR(transmission(2), 3.6, 0.05);
}

}  // namespace
}  // namespace lake
