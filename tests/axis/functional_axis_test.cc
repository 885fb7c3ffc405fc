#include "lake/axis/functional_axis.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/exchange/formats.h"

namespace lake::axis {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

// A hinge at (0, 0) of the shank, which stands, in a plane: the thigh turns to and fro about it, and its two markers
// share an error of `sigma` that is correlated over `memory` frames.
exchange::PointRecording Hinge(unsigned seed, double sigma, double memory) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  exchange::PointRecording points;
  points.space = exchange::PointSpace::kPlane;
  points.points = {{"s1", {}}, {"s2", {}}, {"t1", {}}, {"t2", {}}};
  const double keep = std::exp(-1 / memory);
  Vector3d error[4] = {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  const Vector3d at[4] = {{-20, -300, 0}, {30, -100, 0}, {0, 300, 0}, {20, 100, 0}};
  for (int i = 0; i < 1000; ++i) {
    const Eigen::AngleAxisd turn(0.8 + 0.8 * std::sin(i * 0.04), Vector3d::UnitZ());
    for (int m = 0; m < 4; ++m) {
      for (int k = 0; k < 2; ++k)
        error[m][k] = keep * error[m][k] + std::sqrt(1 - keep * keep) * sigma * normal(random);
      points.points[static_cast<std::size_t>(m)].positions.push_back((m < 2 ? at[m] : turn * at[m]) + error[m]);
    }
    points.frame.push_back(i);
    points.time_s.push_back(0.01 * i);
  }
  return points;
}

const SegmentMarkers kMarkers{{"s1", "s2"}, {"t1", "t2"}};

TEST(FunctionalAxis, FindsAnExactHinge) {
  const SegmentMotion motion = MotionOf(Hinge(1, 0, 1), kMarkers);
  const MeanAxis axis = MeanAxes(motion, 0, 10).whole;
  EXPECT_LT(axis.in_file.norm(), 1e-6);
  EXPECT_LT(axis.pin_residual_mm, 1e-6);
  EXPECT_NEAR(axis.flexion_deg, 1.6 * 180 / M_PI, 0.1);
}

// Ellipses of 95 % (2.45 standard deviations in two dimensions), with residuals correlated over 15 frames. Of 200 draws
// 90 to 98 % is the aim; the share itself is uncertain by 1.5 %.
TEST(FunctionalAxis, ItsIntervalHoldsTheAxis) {
  int held = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const MeanAxis axis = MeanAxes(MotionOf(Hinge(seed, 1, 15), kMarkers), 0, 10).whole;
    held += axis.in_file.norm() < 2.448 * axis.sd_mm;
  }
  EXPECT_GE(held, 180);
  EXPECT_LE(held, 198);
}

TEST(FunctionalAxis, RefusesMarkersItCannotUse) {
  EXPECT_THROW(MotionOf(Hinge(1, 0, 1), {{"s1"}, {"t1", "t2"}}), UsageError);
  EXPECT_THAT(
      [] {
        MotionOf(Hinge(1, 0, 1), {{"s1", "none"}, {"t1", "t2"}});
      },
      testing::ThrowsMessage<Error>(testing::AllOf(HasSubstr("'none'"), HasSubstr("s1, s2, t1, t2"))));
  EXPECT_THROW(MotionOf(Hinge(1, 0, 1), {{"s1", "t1"}, {"t1", "t2"}}), UsageError);
}

TEST(FunctionalAxis, TellsTheWindowsThatTurnTooLittle) {
  exchange::PointRecording points = Hinge(1, 0.1, 1);
  for (exchange::PointTrack& point : points.points)  // the second window stands still
    for (std::size_t i = 300; i < 600; ++i) point.positions[i] = point.positions[299];
  const MeanAxesResult result = MeanAxes(MotionOf(points, kMarkers), 300, 10);
  ASSERT_EQ(result.windows.size(), 2);
  EXPECT_EQ(result.windows[0].window, 1);
  EXPECT_EQ(result.windows[1].window, 3);
  EXPECT_THAT(result.warnings, testing::ElementsAre(HasSubstr("window 2 is left out")));
}

double FromHinge(const exchange::PointRecording& points, const SegmentMotion& motion, const Vector3d& in_shank,
                 std::size_t frame) {
  const Vector3d a = points.Find("ax1")->positions[frame], b = points.Find("ax2")->positions[frame];
  const Vector3d place = motion.shank[frame].turn * in_shank + motion.shank[frame].origin;
  return (b - a).normalized().cross(place - a).norm();
}

// The place of a knee's instantaneous centre is sought to 2 mm; a frame's centre by differences over 50 ms is 4.75 mm
// off.
TEST(FunctionalAxis, FindsTheCentresOfAMeasuredHinge) {
  const std::filesystem::path file = std::filesystem::path(LAKE_SHARED_DATA) / "hinge_axis/hinge_a.trc";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
  const exchange::PointRecording points = exchange::ReadPoints(file);
  const SegmentMotion motion = MotionOf(points, {{"dw1", "dw2", "dw3", "dw4", "dw5", "cld1", "cld2", "cld3"},
                                                 {"up1", "up2", "up3", "up4", "up5", "clu1", "clu2", "clu3"}});
  std::vector<double> off_mm;
  for (const InstantaneousCentre& c : InstantaneousCentres(motion, MeanAxes(motion, 0, 10).whole))
    off_mm.push_back(FromHinge(points, motion, c.in_shank, c.frame));
  EXPECT_LT(Median(off_mm), 2);
}

}  // namespace
}  // namespace lake::axis
