#include "lake/tracking/noise_estimate.h"

#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "tracking/marker_scene.h"

namespace lake {
namespace {

TEST(NoiseEstimator, RecoversReadNoiseAndGain) {
  for (const auto& [read_sd, gain] : {std::pair(1.5, 0.02), std::pair(1.0, 0.0), std::pair(2.5, 0.05)}) {
    std::mt19937 random(23);
    // A ramp through all levels, and something that moves over it.
    cv::Mat ramp(180, 320, CV_64F);
    for (int y = 0; y < ramp.rows; ++y)
      for (int x = 0; x < ramp.cols; ++x) ramp.at<double>(y, x) = 15 + 215.0 * x / ramp.cols;
    tracking::NoiseEstimator estimator;
    for (int i = 0; i < 12; ++i) {
      cv::Mat picture = ramp.clone();
      picture(cv::Rect(10 * i, 40, 20, 20)) = 230;
      estimator.Add(AddNoise(picture, {read_sd, gain}, random));
    }
    const tracking::NoiseModel model = estimator.Estimate();
    // Rounding to whole levels adds 1/12. 70000 differences fix the line's variance to about 1 %; bins of 16 levels and
    // what moves cost some more.
    for (const double level : {20.0, 120.0, 220.0}) {
      const double truth = read_sd * read_sd + gain * level + 1.0 / 12;
      EXPECT_NEAR(model.Variance(level), truth, 0.08 * truth)
          << "read sd " << read_sd << ", gain " << gain << ", level " << level;
    }
    EXPECT_NEAR(model.gain, gain, 0.005);
  }
}

TEST(NoiseEstimator, KnowsWhereTheVideoSaturates) {
  std::mt19937 random(24);
  cv::Mat picture(120, 160, CV_64F, cv::Scalar(60));
  picture(cv::Rect(40, 40, 30, 30)) = 400;
  cv::Mat clipped = AddNoise(picture, SceneNoise{}, random);
  tracking::NoiseEstimator full, studio, dark;
  full.Add(clipped);
  EXPECT_EQ(full.SaturationLevel(), 255);
  studio.Add(cv::min(clipped, 235));
  EXPECT_EQ(studio.SaturationLevel(), 235);
  dark.Add(AddNoise(cv::Mat(120, 160, CV_64F, cv::Scalar(60)), SceneNoise{}, random));
  EXPECT_EQ(dark.SaturationLevel(), 255);
}

}  // namespace
}  // namespace lake
