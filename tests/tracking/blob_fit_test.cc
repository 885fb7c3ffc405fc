#include "lake/tracking/blob_fit.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "lake/core/statistics.h"
#include "tracking/marker_scene.h"

namespace lake {
namespace {

constexpr double kPsf = 0.7;
constexpr double kBackground = 40;
const cv::Size kSize(48, 40);

tracking::BlobFitOptions Options(const SceneNoise& noise) {
  tracking::BlobFitOptions options;
  options.noise = {noise.read_sd * noise.read_sd, noise.gain};
  return options;
}

// The standard deviation per axis that no unbiased estimate can beat, rounding to whole grey levels (1/12) included:
// inverse Fisher information of the noise-free image's derivative by position.
double CramerRaoBound(const SceneMarker& marker, const SceneNoise& noise) {
  constexpr double kStep = 0.05;
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  const cv::Mat image = DrawMarkers(kSize, {marker}, kPsf, kBackground);
  std::vector<cv::Mat> slope;
  for (const Eigen::Vector2d& axis : {Eigen::Vector2d(kStep, 0), Eigen::Vector2d(0, kStep)}) {
    SceneMarker ahead = marker, behind = marker;
    ahead.center += axis, behind.center -= axis;
    slope.push_back((DrawMarkers(kSize, {ahead}, kPsf, kBackground) - DrawMarkers(kSize, {behind}, kPsf, kBackground)) /
                    (2 * kStep));
  }
  for (int y = 0; y < kSize.height; ++y)
    for (int x = 0; x < kSize.width; ++x) {
      if (image.at<double>(y, x) >= 255) continue;  // a saturated pixel tells nothing
      const Eigen::Vector2d g(slope[0].at<double>(y, x), slope[1].at<double>(y, x));
      information +=
          g * g.transpose() / (noise.read_sd * noise.read_sd + noise.gain * image.at<double>(y, x) + 1.0 / 12);
    }
  return std::sqrt(information.inverse().trace() / 2);
}

struct Case {
  const char* name;
  SceneMarker marker;
  // Error over the bound, as is promised. About 1.06 is expected; 800 errors estimate it to 2.5 %.
  double allowed = 1.15;
  // How much too large the stated sigma may be: it holds what the model itself misses, which is symmetric and moves no
  // centre; error / sigma is 0.906 on average for the small disc, 0.93..0.98 for others. And 2.5 % three times.
  double caution = 0.17;
  double allowed_bias_px = 0;  // beyond chance
};

std::ostream& operator<<(std::ostream& stream, const Case& c) {
  return stream << c.name;
}

class BlobFitTest : public testing::TestWithParam<Case> {};

TEST_P(BlobFitTest, ReachesTheCramerRaoBoundWithAnHonestSigma) {
  const SceneNoise noise;
  std::mt19937 generator(20240);
  std::uniform_real_distribution<double> fraction(-0.5, 0.5);
  const int trials = 400;
  double square_sum = 0, z_square_sum = 0, bound_square_sum = 0;
  Eigen::Vector2d error_sum(0, 0);
  for (int i = 0; i < trials; ++i) {
    SceneMarker marker = GetParam().marker;
    marker.center = Eigen::Vector2d(23, 20) + Eigen::Vector2d{fraction(generator), fraction(generator)};
    const cv::Mat grey = AddNoise(DrawMarkers(kSize, {marker}, kPsf, kBackground), noise, generator);
    tracking::Blob start = tracking::DiscBlob(marker.center + Eigen::Vector2d(0.6, -0.7), marker.radius_px * 1.1);
    start.blur_px = marker.blur_px;
    const auto fits = tracking::FitBlobs(grey, std::span(&start, 1), Options(noise));
    ASSERT_TRUE(fits) << "trial " << i;
    const Eigen::Vector2d error = fits->front().blob.center - marker.center;
    square_sum += error.squaredNorm() / 2;
    z_square_sum += error.squaredNorm() / 2 / std::pow(fits->front().SigmaPx(), 2);
    error_sum += error;
    if (i % 40 == 0) bound_square_sum += std::pow(CramerRaoBound(marker, noise), 2) / (trials / 40);
  }
  const double rms = std::sqrt(square_sum / trials), bound = std::sqrt(bound_square_sum);
  EXPECT_LE(rms, GetParam().allowed * bound) << "rms " << rms << " px, bound " << bound << " px";
  const double z_deviation = std::sqrt(z_square_sum / trials);
  EXPECT_GE(z_deviation, 1 - GetParam().caution);
  EXPECT_LE(z_deviation, 1.1);  // 1 is right; 1.06 with the error's share over the bound; 2.5 % of chance
  // All start on the same side of the truth; the iteration stops with as much left as its last step at most.
  const double unconverged = tracking::BlobFitOptions().converged_px;
  EXPECT_LE((error_sum / trials).norm(), 4 * rms / std::sqrt(trials) + unconverged + GetParam().allowed_bias_px)
      << "bias";
}

SceneMarker Disc(double radius, double amplitude, Eigen::Vector2d blur = {0, 0}, double aspect = 1) {
  SceneMarker marker;
  marker.radius_px = radius, marker.amplitude = amplitude, marker.blur_px = blur, marker.aspect = aspect;
  return marker;
}

INSTANTIATE_TEST_SUITE_P(Markers, BlobFitTest,
                         testing::Values(Case{"small", Disc(2, 150)}, Case{"usual", Disc(4, 150)},
                                         Case{"large", Disc(8, 150)}, Case{"dim", Disc(5, 30)},
                                         Case{"oblique", Disc(6, 150, {0, 0}, 0.85)}, Case{"saturated", Disc(5, 240)},
                                         // Only the point-spread's outer tail is not saturated; there the model's edge
                                         // is an approximation, and the error is still under 0.005 px.
                                         Case{"overexposed", Disc(5, 400), 1.6, 0.3, 0.002},
                                         Case{"streaked", Disc(6, 150, {6, -3})},
                                         Case{"streaked_small", Disc(4, 150, {2, 2})}),
                         [](const auto& info) { return std::string(info.param.name); });

// From hardly to wholly saturated, as flicker does from frame to frame.
TEST(BlobFit, ApparentRadiusDoesNotDependOnTheExposure) {
  const SceneNoise noise;
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> fraction(-0.5, 0.5), amplitude(230, 300);
  std::vector<double> apparent;
  for (int i = 0; i < 100; ++i) {
    SceneMarker marker = Disc(6, amplitude(generator));
    marker.center = Eigen::Vector2d{23 + fraction(generator), 20 + fraction(generator)};
    const cv::Mat grey = AddNoise(DrawMarkers(kSize, {marker}, kPsf, kBackground), noise, generator);
    const tracking::Blob start = tracking::DiscBlob(marker.center, 6.5);
    const auto fits = tracking::FitBlobs(grey, std::span(&start, 1), Options(noise));
    ASSERT_TRUE(fits) << "amplitude " << marker.amplitude;
    apparent.push_back(fits->front().blob.ApparentRadiusPx());
  }
  const auto [least, most] = std::minmax_element(apparent.begin(), apparent.end());
  // The level of 100 lies 0.2 to 0.4 edge widths (0.76 px) outside the half of the light: 0.15 px between 230 and 300;
  // and the place of a saturated edge is uncertain by 0.03 px. The radius itself varies by 0.5 px and more.
  EXPECT_LT(*most - *least, 0.15 + 6 * 0.03) << *least << " to " << *most;
  EXPECT_NEAR(Median(apparent), 6 + 0.3 * 0.76, 0.1);
}

TEST(BlobFit, NeighboursWithinADiameterDoNotPullEachOther) {
  const SceneNoise noise;
  std::mt19937 generator(7);
  double square_sum = 0;
  const int trials = 200;
  for (int i = 0; i < trials; ++i) {
    const SceneMarker a{{20.3, 20.1}, 4, 150}, b{{26.9, 21.4}, 4, 150};  // 6.7 px apart: they overlap
    const cv::Mat grey = AddNoise(DrawMarkers(kSize, {a, b}, kPsf, kBackground), noise, generator);
    const std::vector<tracking::Blob> starts = {tracking::DiscBlob(a.center + Eigen::Vector2d(0.4, 0.3), 4.1),
                                                tracking::DiscBlob(b.center, 4.1)};
    const auto fits = tracking::FitBlobs(grey, starts, Options(noise));
    ASSERT_TRUE(fits) << "trial " << i;
    square_sum += ((*fits)[0].blob.center - a.center).squaredNorm() / 2;
  }
  // Overlapping light adds up in this scene, so both edges stay visible: half as much again as a lone marker's bound.
  EXPECT_LE(std::sqrt(square_sum / trials), 1.5 * CramerRaoBound(Disc(4, 150), noise) + 0.002);
}

// A background that is not even pulls what lies at the side of the pixels that take part: the place that is found must
// not depend on where it was looked for.
TEST(BlobFit, StartsAnywhereAndFindsTheSamePlaceBeforeAnUnevenBackground) {
  const cv::Size size(80, 40);
  SceneMarker marker;
  marker.center = {40, 20};
  marker.radius_px = 3;
  marker.blur_px = {20, 4};
  cv::Mat image = DrawMarkers(size, {marker}, kPsf, kBackground);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) image.at<double>(y, x) += 25 * std::pow((x - marker.center.x()) / 20, 2);
  cv::Mat grey;
  image.convertTo(grey, CV_8U);
  for (const double along : {-0.3, -0.15, 0.15, 0.3}) {
    tracking::Blob start = tracking::DiscBlob(marker.center + along * marker.blur_px, marker.radius_px);
    start.blur_px = 0.9 * marker.blur_px;
    tracking::BlobFitOptions options = Options(SceneNoise());
    options.shape_freedom = 0.04;
    options.streak_freedom_px = 2;
    const auto fits = tracking::FitBlobs(grey, std::span(&start, 1), options);
    ASSERT_TRUE(fits) << along;
    EXPECT_LE((fits->front().blob.center - marker.center).norm(), 0.1) << along;
  }
}

TEST(BlobFit, RefusesWhatIsNoBlob) {
  std::mt19937 generator(3);
  const cv::Mat flat = AddNoise(cv::Mat(kSize, CV_64F, cv::Scalar(60)), SceneNoise{}, generator);
  cv::Mat step(kSize, CV_64F, cv::Scalar(60));
  step.colRange(24, 48) = 180;
  const tracking::Blob start = tracking::DiscBlob({22, 20}, 4);
  // The same start, noise and options with a marker there: the fit is not refused for anything else.
  SceneMarker marker = Disc(4, 150);
  marker.center = {22.3, 20.2};
  const cv::Mat grey = AddNoise(DrawMarkers(kSize, {marker}, kPsf, kBackground), SceneNoise{}, generator);
  const auto on_marker = tracking::FitBlobs(grey, std::span(&start, 1), tracking::BlobFitOptions{});
  ASSERT_TRUE(on_marker);
  EXPECT_LT((on_marker->front().blob.center - marker.center).norm(), 0.1);
  EXPECT_GT(on_marker->front().blob.amplitude, 100);
  EXPECT_LT(on_marker->front().relative_residual, 0.1);
  const auto on_flat = tracking::FitBlobs(flat, std::span(&start, 1), tracking::BlobFitOptions{});
  EXPECT_TRUE(!on_flat || on_flat->front().blob.amplitude < 10);
  const auto on_step =
      tracking::FitBlobs(AddNoise(step, SceneNoise{}, generator), std::span(&start, 1), tracking::BlobFitOptions{});
  EXPECT_TRUE(!on_step || on_step->front().relative_residual > 0.1);
}

}  // namespace
}  // namespace lake
