#include "lake/gait/leg_angles.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "lake/core/angles.h"

namespace lake {
namespace {

Eigen::Vector2d Polar(double length, double lean_deg) {
  return length * Eigen::Vector2d(std::sin(RadiansFromDegrees(lean_deg)), std::cos(RadiansFromDegrees(lean_deg)));
}

// A leg facing right with the given segment angles.
gait::LegPoints LegAt(double shank_deg, double thigh_deg, double trunk_deg) {
  gait::LegPoints points;
  points.ankle = Eigen::Vector2d(100, 50);
  points.knee = *points.ankle + Polar(430, shank_deg);
  points.hip = *points.knee + Polar(410, thigh_deg);
  points.waist = *points.hip + Polar(250, trunk_deg);
  return points;
}

motion::LegSample SampleOf(const gait::LegPoints& points, motion::Facing facing = motion::Facing::kRight,
                           const Eigen::Vector2d& up = Eigen::Vector2d::UnitY()) {
  return gait::MakeLegSample(points, facing, up);
}

gait::LegPoints Mirrored(gait::LegPoints points) {
  for (auto* point : {&points.ankle, &points.knee, &points.hip, &points.waist}) (*point)->x() *= -1;
  return points;
}

TEST(LegAngles, SeatedLegHasItsKneeInFront) {
  const motion::LegSample sample = SampleOf(LegAt(15, -75, 20));
  EXPECT_NEAR(sample.shank_deg, 15, 1e-12);
  EXPECT_NEAR(sample.thigh_deg, -75, 1e-12);
  EXPECT_NEAR(sample.trunk_deg, 20, 1e-12);
  EXPECT_NEAR(sample.knee_deg, 90, 1e-12);
  EXPECT_GT(sample.ak.x(), 0);  // the knee is anterior of the ankle
  EXPECT_LT(sample.kh.x(), 0);  // the hip behind the knee
}

TEST(LegAngles, FacingLeftOrInATiltedPictureALegGivesTheSameSample) {
  const Eigen::Rotation2D<double> tilt(RadiansFromDegrees(7));
  const gait::LegPoints points = LegAt(12, -60, 30);
  gait::LegPoints turned = points;
  for (auto* point : {&turned.ankle, &turned.knee, &turned.hip, &turned.waist})
    *point = Eigen::Vector2d(tilt * **point);
  const motion::LegSample right = SampleOf(points);
  for (const motion::LegSample& same : {SampleOf(Mirrored(points), motion::Facing::kLeft),
                                        SampleOf(turned, motion::Facing::kRight, tilt * Eigen::Vector2d::UnitY())}) {
    EXPECT_NEAR((right.ak - same.ak).norm() + (right.kh - same.kh).norm() + (right.hw - same.hw).norm(), 0, 1e-9);
    EXPECT_NEAR(right.shank_deg, same.shank_deg, 1e-12);
    EXPECT_NEAR(right.knee_deg, same.knee_deg, 1e-12);
    EXPECT_NEAR(right.trunk_deg, same.trunk_deg, 1e-12);
  }
}

TEST(LegAngles, KneeAngleIsThePapersFormulaWithASign) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-170, 170), length(50, 500);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d ak = Polar(length(random), angle(random)), kh = Polar(length(random), angle(random));
    const double paper_deg = DegreesFromRadians(std::acos(ak.dot(kh) / (ak.norm() * kh.norm())));
    const double knee_deg = gait::KneeAngleDeg(ak, kh);
    EXPECT_NEAR(std::abs(knee_deg), paper_deg, 1e-5);  // arccos loses half the digits near 0 and 180
    EXPECT_NEAR(knee_deg, std::remainder(gait::SegmentAngleDeg(ak) - gait::SegmentAngleDeg(kh), 360), 1e-9);
  }
  EXPECT_NEAR(gait::KneeAngleDeg(Polar(400, 0), Polar(400, 5)), -5, 1e-12);  // hyperextension does not fold at 0
}

TEST(LegAngles, MissingMarkersLeaveUnknowns) {
  gait::LegPoints points = LegAt(10, -20, 5);
  points.waist.reset();
  motion::LegSample sample = SampleOf(points);
  EXPECT_TRUE(std::isnan(sample.trunk_deg));
  EXPECT_NEAR(sample.knee_deg, 30, 1e-12);
  points.hip.reset();
  sample = SampleOf(points);
  EXPECT_TRUE(std::isnan(sample.knee_deg));
  EXPECT_NEAR(sample.shank_deg, 10, 1e-12);
}

// Mostly standing, a few degrees hyperextended, with one short bend and two wrong detections.
TEST(LegAngles, FacingIsTheSideOfTheFlexions) {
  std::vector<gait::LegPoints> right;
  for (int i = 0; i < 300; ++i) right.push_back(LegAt(-1, 3, 0));
  for (int i = 0; i < 60; ++i) right.push_back(LegAt(10, -50 + 0.1 * i, 10));
  right.push_back(LegAt(0, 150, 0));
  right.push_back(LegAt(0, 120, 0));
  std::vector<gait::LegPoints> left;
  for (const gait::LegPoints& points : right) left.push_back(Mirrored(points));
  EXPECT_EQ(gait::FindFacing(right).facing, motion::Facing::kRight);
  EXPECT_EQ(gait::FindFacing(left).facing, motion::Facing::kLeft);
  EXPECT_TRUE(gait::FindFacing(left).IsCertain());
  EXPECT_FALSE(gait::FindFacing({LegAt(0, -3, 0)}).IsCertain());
}

}  // namespace
}  // namespace lake
