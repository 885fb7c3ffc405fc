#include "synth/cramer_rao.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "synth/plain_scene.h"

namespace lake {
namespace {

using Eigen::Vector2d;

TEST(CramerRao, IsThatOfALargeSoftDisc) {
  // For a large disc with a Gaussian edge the information is an integral along the outline: amplitude² / (2 sqrt(pi)
  // sigma) per px of it, cos² of it on each axis; the pixel's box adds 1/12 to sigma².
  synth::SceneOptions options = test::PlainOptions();
  options.marker_radius_px = 25;
  options.psf_sigma_px = 1.5;
  options.width_px = 256;
  options.height_px = 200;
  options.noise = {3, 0};
  const synth::Scene scene(options, test::OneMarker({0, 0}));
  const double amplitude = options.marker_level - options.background_level, sigma = std::sqrt(1.5 * 1.5 + 1.0 / 12);
  const double information =
      amplitude * amplitude / (9 + 1.0 / 12) / (2 * std::sqrt(std::numbers::pi) * sigma) * std::numbers::pi * 25;
  const Vector2d bound = CramerRaoBound(scene, 0, "ball");
  EXPECT_NEAR(bound.x() * std::sqrt(information), 1, 0.01);  // curvature: (sigma / radius)² = 0.4 %
  EXPECT_NEAR(bound.y() * std::sqrt(information), 1, 0.01);
}

TEST(CramerRao, IsReachedByALinearEstimatorOnRecordedFrames) {
  synth::SceneOptions options = test::PlainOptions(21);
  options.duration_s = 400 / 60.0;
  options.noise = {1.5, 0.02};
  const synth::Scene scene(options, test::OneMarker({0.9, -1.7}));
  const Vector2d bound = CramerRaoBound(scene, 0, "ball");
  const cv::Mat ideal = scene.RenderIdeal(0);
  const synth::ImagePatch left = scene.RenderMarker(0, "ball", {-0.05, 0}),
                          right = scene.RenderMarker(0, "ball", {0.05, 0});
  const cv::Rect common = cv::Rect(left.corner, left.image.size()) & cv::Rect(right.corner, right.image.size());
  std::vector<double> estimates;
  for (int frame = 0; frame < scene.Frames(); ++frame) {
    const cv::Mat recorded = scene.Render(frame);
    double information = 0, product = 0;
    for (int y = common.y; y < common.br().y; ++y)
      for (int x = common.x; x < common.br().x; ++x) {
        const double slope = (right.image.at<float>(cv::Point(x, y) - right.corner) -
                              left.image.at<float>(cv::Point(x, y) - left.corner)) /
                             0.1;
        const double variance = synth::NoiseVariance(options.noise, ideal.at<float>(y, x));
        information += slope * slope / variance;
        product += slope / variance * (recorded.at<std::uint8_t>(y, x) - ideal.at<float>(y, x));
      }
    estimates.push_back(product / information);
  }
  // 400 estimates: the standard deviation is known to 1/sqrt(800) = 3.5 %; three of those.
  EXPECT_NEAR(StandardDeviation(estimates) / bound.x(), 1, 0.11);
  EXPECT_LT(std::abs(Mean(estimates)), 4 * bound.x() / 20);
}

TEST(CramerRao, SaturationCosts) {
  synth::SceneOptions options = test::PlainOptions();
  options.marker_level = 250;
  options.noise = {1.5, 0};
  const synth::Scene below(options, test::OneMarker({0, 0}));
  options.marker_level = 1000;
  const synth::Scene above(options, test::OneMarker({0, 0}));
  options.exposure = 0.25;  // the same light on a sensor that holds it
  options.background_level = 160;
  options.marker_level = 1000;
  const Vector2d clipped = CramerRaoBound(above, 0, "ball");
  // Unclipped the bound would fall with the amplitude: 210 / 960.
  EXPECT_GT(clipped.x(), 1.5 * CramerRaoBound(below, 0, "ball").x() * 210 / 960);
}

TEST(CramerRao, RefusesWhatCannotBeSeen) {
  synth::SceneOptions options = test::PlainOptions();
  const synth::Scene scene(options, test::OneMarker({0, 0}));
  EXPECT_THROW(CramerRaoBound(scene, 0, "elbow"), UsageError);
  options.camera = scene.Profile();
  const synth::Scene outside(options, test::OneMarker({5000, 0}));
  EXPECT_THROW(CramerRaoBound(outside, 0, "ball"), Error);
}

}  // namespace
}  // namespace lake
