#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/synth/noise.h"
#include "lake/synth/scene.h"
#include "synth/plain_scene.h"

namespace lake {
namespace {

using Eigen::Vector2d;
using test::BlobOf;
using test::OneMarker;
using test::PlainOptions;

constexpr double kPi = std::numbers::pi;

// All phases of the pixel grid and 25 radii.
class DiscOnTheGrid : public ::testing::TestWithParam<int> {
 protected:
  test::Blob Render(double psf_sigma_px) {
    options_.psf_sigma_px = psf_sigma_px;
    options_.background_level = 0;  // an even background's rounding would add up over the picture
    options_.marker_radius_px = 3 + 0.1 * GetParam();
    options_.camera = synth::Scene(options_, OneMarker({0, 0})).Profile();
    const synth::Scene scene(options_, OneMarker({0.37 * GetParam(), -0.53 * GetParam()}));
    truth_ = scene.Truth(0).markers[0].px;
    return BlobOf(scene.RenderIdeal(0), 0);
  }
  double Area() const { return kPi * options_.marker_radius_px * options_.marker_radius_px; }

  synth::SceneOptions options_ = PlainOptions();
  Vector2d truth_;
};

TEST_P(DiscOnTheGrid, HoldsItsAreaTimesItsLevel) {
  for (const double psf : {0.0, 0.7, 1.6}) EXPECT_NEAR(Render(psf).sum / options_.marker_level / Area(), 1, 1e-6);
}

TEST_P(DiscOnTheGrid, HasItsCentroidAtTheTruth) {
  // The moment of box-shaped cells is not that of the disc: up to 0.007 px for whole pixels without point-spread at
  // these radii, falling with the power 2.5 of the cells' number (the disc's spectrum by 1.5, the moment by 1): 4 cells
  // leave 0.007 / 32.
  for (const double psf : {0.7, 1.6}) EXPECT_LT((Render(psf).centroid - truth_).norm(), 2.5e-4);
}

TEST(DiscBetweenPixels, HasItsCentroidExactlyAtTheTruth) {
  // At a corner of four pixels all is symmetric; float pixels are left.
  for (const double psf : {0.0, 0.7, 1.6}) {
    synth::SceneOptions options = PlainOptions();
    options.background_level = 0;
    options.psf_sigma_px = psf;
    options.camera = synth::Scene(options, OneMarker({0, 0})).Profile();
    const synth::Scene scene(options, OneMarker({0, 20}));
    const Vector2d truth = scene.Truth(0).markers[0].px;
    ASSERT_LT((truth - Vector2d(79.5, 59.5)).norm(), 1e-9);
    EXPECT_LT((BlobOf(scene.RenderIdeal(0), 0).centroid - truth).norm(), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Phases, DiscOnTheGrid, ::testing::Range(0, 25));

TEST(MarkerImage, LiesWhereTheCameraModelPutsItsCentre) {
  synth::SceneOptions options = synth::HardScene(5);
  const synth::Scene scene(options);
  for (int frame = 0; frame < scene.Frames(); frame += 50) {
    const synth::FrameTruth truth = scene.Truth(frame);
    for (const synth::MarkerTruth& marker : truth.markers)
      EXPECT_LT(
          (camera::PixelFromPlane(scene.Profile().camera, *scene.Profile().camera_from_plane, marker.mm) - marker.px)
              .norm(),
          1e-9);
  }
  options.marker_depth_mm["knee"] = 40;
  const synth::Scene proud(options);
  const synth::MarkerTruth knee = proud.Truth(100).markers[1];
  EXPECT_LT((camera::PixelFromPlane(proud.Profile().camera, *proud.Profile().camera_from_plane, knee.mm, 40) - knee.px)
                .norm(),
            1e-9);
  EXPECT_GT(
      (camera::PixelFromPlane(proud.Profile().camera, *proud.Profile().camera_from_plane, knee.mm) - knee.px).norm(),
      1);
}

TEST(MarkerImage, HasTheRadiusThatIsAskedFor) {
  for (const double radius : {2.5, 4.0, 6.0, 15.0}) {
    synth::SceneOptions options = PlainOptions();
    options.marker_radius_px = radius;
    const synth::Scene scene(options, OneMarker({0, 0}));
    const test::Blob blob = BlobOf(scene.RenderIdeal(0), options.background_level);
    EXPECT_NEAR(std::sqrt(blob.sum / (options.marker_level - options.background_level) / kPi), radius, 1e-3);
  }
}

TEST(MarkerImage, ObliqueDiscIsTheEllipseOfThePerspective) {
  synth::SceneOptions options = PlainOptions();
  options.yaw_deg = 40;
  options.marker_radius_px = 10,
  options.distance_mm = 800;  // close and large: the ellipse's centre is not the projected one
  const synth::Scene scene(options, OneMarker({0, 0}));
  const test::Blob blob = BlobOf(scene.RenderIdeal(0), options.background_level);
  // The image of the circle, integrated: its points on a fine polar grid with the area each one's neighbourhood is seen
  // under.
  const auto& profile = scene.Profile();
  double area = 0;
  Vector2d moment = Vector2d::Zero();
  constexpr int kRings = 60, kSpokes = 240;
  const auto at = [&](double r, double a) {
    return camera::PixelFromPlane(
        profile.camera, *profile.camera_from_plane,
        r * options.marker_radius_mm * Vector2d(std::cos(a), std::sin(a)) + scene.Truth(0).markers[0].mm);
  };
  for (int i = 0; i < kRings; ++i)
    for (int k = 0; k < kSpokes; ++k) {
      const double r0 = double(i) / kRings, r1 = double(i + 1) / kRings, a0 = 2 * kPi * k / kSpokes,
                   a1 = 2 * kPi * (k + 1) / kSpokes;
      const Vector2d p00 = at(r0, a0), p11 = at(r1, a1), d0 = p11 - p00, d1 = at(r0, a1) - at(r1, a0);
      const double cell = 0.5 * std::abs(d0.x() * d1.y() - d0.y() * d1.x());
      area += cell;
      moment += cell * at(0.5 * (r0 + r1), 0.5 * (a0 + a1));
    }
  EXPECT_NEAR(blob.sum / (options.marker_level - options.background_level), area, 2e-3 * area);
  EXPECT_LT((blob.centroid - moment / area).norm(), 2e-3);
  EXPECT_GT((moment / area - scene.Truth(0).markers[0].px).norm(), 0.02);  // the difference is there to be seen
}

TEST(MotionBlur, CentreIsTheMeanOfThePathOverTheShutter) {
  for (const double shutter : {0.3, 0.7, 1.0}) {
    synth::SceneOptions options = PlainOptions();
    options.shutter = shutter;
    options.frame_rate_hz = 60;
    options.duration_s = 0.2;
    options.width_px = 640;
    options.height_px = 480;
    options.camera = synth::Scene(options, OneMarker({0, 0})).Profile();
    const Vector2d start(-150, 100), velocity(1200, -700), acceleration(9000, -15000);
    const synth::Scene scene(options, OneMarker(start, velocity, acceleration));
    for (int frame = 1; frame < 10; ++frame) {
      const double open = shutter / 60;
      const Vector2d mid =
          start + velocity * scene.TimeS(frame) + 0.5 * acceleration * scene.TimeS(frame) * scene.TimeS(frame);
      const Vector2d mean_mm = mid + acceleration * open * open / 24;
      const Vector2d mean_px =
          camera::PixelFromPlane(scene.Profile().camera, *scene.Profile().camera_from_plane, mean_mm);
      EXPECT_LT((scene.Truth(frame).markers[0].mm - mid).norm(), 1e-9);
      EXPECT_LT((BlobOf(scene.RenderIdeal(frame), options.background_level).centroid - mean_px).norm(), 0.002);
    }
  }
}

TEST(MotionBlur, PictureIsThatOfADenseReference) {
  synth::SceneOptions options = PlainOptions();
  options.shutter = 0.7;
  const Vector2d velocity(1100, -800), acceleration(12000, 9000);
  options.camera = synth::Scene(options, OneMarker({0, 0})).Profile();
  const synth::Scene scene(options, OneMarker({-40, 30}, velocity, acceleration));
  synth::SceneOptions dense = options;
  dense.shutter = 0;
  constexpr int kPerFrame = 200;
  dense.frame_rate_hz = 60 * kPerFrame;
  const synth::Scene reference(dense, OneMarker({-40, 30}, velocity, acceleration));
  const int frame = 2, half = static_cast<int>(0.35 * kPerFrame);
  cv::Mat mean = cv::Mat::zeros(options.height_px, options.width_px, CV_32FC1);
  for (int i = -half; i <= half; ++i) {
    const double weight = (std::abs(i) == half ? 0.5 : 1.0) / (2 * half);  // trapezoids
    mean += weight * reference.RenderIdeal(frame * kPerFrame + i);
  }
  const cv::Mat picture = scene.RenderIdeal(frame);
  // The shift that explains the difference best, in px: the difference against the picture's slope.
  cv::Mat difference = picture - mean;
  double information[2] = {}, product[2] = {};
  for (int y = 1; y + 1 < picture.rows; ++y)
    for (int x = 1; x + 1 < picture.cols; ++x) {
      const double slope[2] = {0.5 * (mean.at<float>(y, x + 1) - mean.at<float>(y, x - 1)),
                               0.5 * (mean.at<float>(y + 1, x) - mean.at<float>(y - 1, x))};
      for (int axis = 0; axis < 2; ++axis)
        information[axis] += slope[axis] * slope[axis], product[axis] += slope[axis] * difference.at<float>(y, x);
    }
  for (int axis = 0; axis < 2; ++axis) EXPECT_LT(std::abs(product[axis] / information[axis]), 0.002);
  EXPECT_LT(cv::norm(difference, cv::NORM_INF), 0.01 * (options.marker_level - options.background_level));
}

TEST(Sensor, NoiseHasTheVarianceThatTheModelStates) {
  const synth::SensorNoise noise{1.4, 0.03};
  const synth::Sensor sensor(noise, 7);
  for (const double level : {12.3, 60.0, 200.7}) {
    const cv::Mat even(400, 500, CV_32FC1, cv::Scalar(level));
    std::vector<double> values;
    for (int frame = 0; frame < 3; ++frame) {
      const cv::Mat recorded = sensor.Record(even, frame);
      for (int i = 0; i < 400 * 500; ++i) values.push_back(recorded.data[i]);
    }
    // 6e5 values: the variance is known to sqrt(2 / 6e5) = 0.2 %, the mean to sd / 775; four of those.
    EXPECT_NEAR(StandardDeviation(values) * StandardDeviation(values) / synth::NoiseVariance(noise, level), 1, 0.008);
    EXPECT_NEAR(Mean(values), level, 4 * std::sqrt(synth::NoiseVariance(noise, level) / values.size()) + 1e-3);
  }
}

TEST(Sensor, NeighboursAndFramesAreIndependent) {
  const synth::Sensor sensor({4, 0}, 9);
  const cv::Mat even(300, 300, CV_32FC1, cv::Scalar(100));
  cv::Mat a, b;
  sensor.Record(even, 0).convertTo(a, CV_32F, 1, -100);
  sensor.Record(even, 1).convertTo(b, CV_32F, 1, -100);
  const double variance = a.dot(a) / 9e4;
  const auto correlation = [&](const cv::Mat& p, const cv::Mat& q) { return p.dot(q) / variance / p.total(); };
  // 9e4 products: a standard deviation of 1/300.
  EXPECT_LT(std::abs(correlation(a, b)), 4.0 / 300);
  EXPECT_LT(std::abs(correlation(a.colRange(1, 300).clone(), a.colRange(0, 299).clone())), 4.0 / 300);
  EXPECT_LT(std::abs(correlation(a.rowRange(1, 300).clone(), a.rowRange(0, 299).clone())), 4.0 / 300);
}

TEST(Sensor, RoundsAndClips) {
  const synth::Sensor sensor({0, 0}, 1);
  const cv::Mat levels = (cv::Mat_<float>(1, 7) << -20, 0.49, 0.51, 100.5, 254.49, 255, 400);
  const cv::Mat recorded = sensor.Record(levels, 0),
                expected = (cv::Mat_<std::uint8_t>(1, 7) << 0, 0, 1, 101, 254, 255, 255);
  EXPECT_EQ(cv::countNonZero(recorded != expected), 0) << recorded;
}

TEST(Scene, SaturatedMarkersAreFlatWhite) {
  synth::SceneOptions options = PlainOptions();
  options.marker_level = 400;
  options.marker_radius_px = 6;
  const synth::Scene scene(options, OneMarker({0, 0}));
  const Vector2d centre = scene.Truth(0).markers[0].px;
  const cv::Mat picture = scene.Render(0);
  for (int dy = -3; dy <= 3; ++dy)
    for (int dx = -3; dx <= 3; ++dx)
      EXPECT_EQ(picture.at<std::uint8_t>(std::lround(centre.y()) + dy, std::lround(centre.x()) + dx), 255);
}

TEST(Scene, FlickerAndExposureAreFactors) {
  synth::SceneOptions options = PlainOptions();
  options.duration_s = 4;
  options.flicker = 0.03;
  options.exposure = 1.5;
  const synth::Scene scene(options, OneMarker({0, 0}));
  std::vector<double> factors;
  for (int frame = 0; frame < scene.Frames(); ++frame)
    factors.push_back(scene.RenderIdeal(frame).at<float>(2, 2) / options.background_level);
  EXPECT_NEAR(Mean(factors), 1.5, 0.01);
  // A sinusoid of amplitude 3 % and a quarter of it at random: sqrt(1/2 + 1/16) · 3 %.
  EXPECT_NEAR(StandardDeviation(factors) / 1.5, 0.03 * std::sqrt(0.5 + 1.0 / 16), 0.003);
}

TEST(Scene, ColourMarkersHaveTheirColours) {
  synth::SceneOptions options = synth::CleanScene(2);
  options.colour = true;
  options.marker_bgr = synth::LedColours();
  const synth::Scene scene(options);
  const cv::Mat picture = scene.RenderIdeal(0);
  const synth::FrameTruth truth = scene.Truth(0);
  for (std::size_t m = 0; m < truth.markers.size(); ++m) {
    const cv::Vec3f seen =
        picture.at<cv::Vec3f>(std::lround(truth.markers[m].px.y()), std::lround(truth.markers[m].px.x()));
    EXPECT_LT(cv::norm(seen - synth::LedColours()[scene.Motion().Names()[m]]), 1) << scene.Motion().Names()[m] << seen;
  }
}

TEST(Scene, IsTheSameForTheSameSeedAndInAnyOrder) {
  const synth::Scene one(synth::HardScene(3)), two(synth::HardScene(3)), other(synth::HardScene(4));
  const cv::Mat late = one.Render(77), early = one.Render(5);
  EXPECT_EQ(cv::norm(early, two.Render(5), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(late, two.Render(77), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(late, other.Render(77), cv::NORM_INF), 0);
}

TEST(Scene, FacingLeftMirrorsTheMarkersInThePicture) {
  synth::SceneOptions options = synth::CleanScene(6);
  const synth::Scene right(options);
  options.motion.facing = motion::Facing::kLeft;
  const synth::Scene left(options);
  for (int frame = 0; frame < right.Frames(); frame += 37) {
    const synth::FrameTruth r = right.Truth(frame), l = left.Truth(frame);
    for (std::size_t m = 0; m < r.markers.size(); ++m) {
      EXPECT_NEAR(l.markers[m].px.x(), options.width_px - 1 - r.markers[m].px.x(), 1e-9);
      EXPECT_NEAR(l.markers[m].px.y(), r.markers[m].px.y(), 1e-9);
    }
    EXPECT_NEAR(l.knee_deg, r.knee_deg, 1e-9);
  }
}

TEST(Scene, SaysWhichOptionIsWrong) {
  synth::SceneOptions options = synth::CleanScene(1);
  options.shutter = 1.5;
  EXPECT_THROW(synth::Scene{options}, UsageError);
  options = synth::CleanScene(1);
  options.occlusions.push_back({"elbow", 1, 0.2});
  EXPECT_THROW(synth::Scene{options}, UsageError);
  options = synth::CleanScene(1);
  options.marker_depth_mm["elbow"] = 30;
  EXPECT_THROW(synth::Scene{options}, UsageError);
  options = synth::CleanScene(1);
  options.camera = camera::CameraProfile{};
  EXPECT_THROW(synth::Scene{options}, UsageError);
}

}  // namespace
}  // namespace lake
