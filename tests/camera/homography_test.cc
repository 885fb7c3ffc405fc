// Of people's films, whose corners are known, the angles it gives are held against a sensor's:
// tests/gait/sts_imu_test.cc.
#include "lake/camera/homography.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <random>
#include <vector>

#include "lake/core/error.h"
#include "message_of.h"

namespace lake {
namespace {

using Points = std::vector<camera::PlaneCorrespondence>;

// A tilted view: mm to px.
Eigen::Matrix3d SomeView() {
  Eigen::Matrix3d h;
  h << 0.6, 0.08, 300, 0.05, -0.7, 500, 1e-4, -5e-5, 1;
  return h;
}

Points Seen(const Eigen::Matrix3d& image_from_plane, const std::vector<Eigen::Vector2d>& plane) {
  Points points;
  for (const auto& p : plane) points.push_back({(image_from_plane * p.homogeneous()).hnormalized(), p});
  return points;
}

const std::vector<Eigen::Vector2d> kCorners = {{0, 0}, {0, 740}, {590, 0}, {590, 740}};

TEST(PlaneHomography, FourExactPointsGiveTheMapping) {
  const camera::HomographyFit fit = camera::PlaneHomography(Seen(SomeView(), kCorners));
  const Eigen::Vector2d point(137, 412);
  const Eigen::Vector2d pixel = (SomeView() * point.homogeneous()).hnormalized();
  EXPECT_LT((camera::ApplyHomography(fit, pixel) - point).norm(), 1e-9);  // rounding of coordinates of 1e3
  EXPECT_LT(fit.rms_px, 1e-10);
}

TEST(PlaneHomography, NoiseAveragesOutAndTheRmsIsThatOfTheNoise) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, 0.2);
  std::vector<Eigen::Vector2d> plane;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x) plane.emplace_back(50 * x, 50 * y);
  Points points = Seen(SomeView(), plane);
  for (auto& p : points) p.pixel += Eigen::Vector2d{noise(random), noise(random)};
  const camera::HomographyFit fit = camera::PlaneHomography(points);
  // 2-D RMS of 288 residuals with 8 unknowns: 0.2 sqrt(2) sqrt(280/288) = 0.279, relative sd 1/sqrt(2*280) = 4 %: three
  // of them.
  EXPECT_NEAR(fit.rms_px, 0.279, 0.036);
  const Eigen::Vector2d middle(275, 275);
  // One point's noise is about 0.35 mm; the mean of 144 points brings the middle to about 0.05 mm; four of that.
  EXPECT_LT((camera::ApplyHomography(fit, (SomeView() * middle.homogeneous()).hnormalized()) - middle).norm(), 0.2);
}

TEST(PlaneHomography, RefinementIsBetterThanItsStartForUnequalWeights) {
  // A strong perspective makes the algebraic error of the linear solution weigh far points too much: the geometric RMS
  // must be a minimum.
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 0.5);
  Eigen::Matrix3d view;
  view << 0.6, 0.1, 300, 0.05, -0.7, 700, 1e-3, 8e-4, 1;
  std::vector<Eigen::Vector2d> plane;
  for (int i = 0; i < 40; ++i) plane.emplace_back(std::fmod(137.0 * i, 600), std::fmod(211.0 * i, 700));
  Points points = Seen(view, plane);
  for (auto& p : points) p.pixel += Eigen::Vector2d{noise(random), noise(random)};
  const camera::HomographyFit fit = camera::PlaneHomography(points);
  const Eigen::Matrix3d back = fit.plane_from_image.inverse() / fit.plane_from_image.inverse().norm();
  for (int i = 0; i < 9; ++i) {
    for (const double step : {-1e-5, 1e-5}) {
      Eigen::Matrix3d moved = back;
      moved(i / 3, i % 3) *= 1 + step;
      double sum = 0;
      for (const auto& p : points)
        sum += ((moved * p.point_in_plane.homogeneous()).hnormalized() - p.pixel).squaredNorm();
      EXPECT_GE(std::sqrt(sum / 40), fit.rms_px * (1 - 1e-12)) << "element " << i;
    }
  }
}

TEST(PlaneHomography, SaysWhatIsWrong) {
  const auto message = [](const Points& points) { return MessageOf([&] { camera::PlaneHomography(points); }); };
  Points points = Seen(SomeView(), kCorners);
  EXPECT_THAT(message({points.begin(), points.begin() + 3}), testing::HasSubstr("at least 4"));
  EXPECT_THAT(message(Seen(SomeView(), {{0, 0}, {100, 0}, {200, 0}, {0, 100}})), testing::HasSubstr("in one line"));
  EXPECT_THAT(message(Seen(SomeView(), {{5, 5}, {5, 5}, {5, 5}, {5, 5}})), testing::HasSubstr("coincide"));
  std::swap(points[0].pixel, points[1].pixel);  // a bow tie
  EXPECT_THAT(message(points), testing::HasSubstr("same order"));
  points[0].pixel.x() = std::nan("");
  EXPECT_THAT(message(points), testing::HasSubstr("not finite"));
}

TEST(PlaneHomography, TellsTheHorizon) {
  const camera::HomographyFit fit = camera::PlaneHomography(Seen(SomeView(), kCorners));
  const Eigen::RowVector3d horizon = fit.plane_from_image.row(2);
  const Eigen::Vector2d at_horizon = -horizon.z() * horizon.head<2>().transpose() / horizon.head<2>().squaredNorm();
  EXPECT_THROW(camera::ApplyHomography(fit, 1.001 * at_horizon), Error);
  EXPECT_NO_THROW(camera::ApplyHomography(fit, 0.999 * at_horizon));
}

}  // namespace
}  // namespace lake
