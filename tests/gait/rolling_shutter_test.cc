#include "lake/gait/rolling_shutter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lake {
namespace {

// A marker on a path as fast as a hip's in a quick rise, in a picture of 1280 x 720.
Eigen::Vector2d PathPx(double time_s) {
  return {640 + 220 * std::sin(4 * time_s), 330 + 240 * std::cos(5 * time_s + 0.4)};
}

// Where it is when its row is read.
Eigen::Vector2d SeenPx(double time_s, const gait::RollingShutter& shutter) {
  Eigen::Vector2d seen = PathPx(time_s);
  for (int round = 0; round < 20; ++round) seen = PathPx(time_s + shutter.DelayS(seen));
  return seen;
}

motion::MarkerRecording Record(double rate_hz, const gait::RollingShutter& shutter, double sigma_px, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  motion::MarkerRecording recording;
  recording.markers = {{"hip", {}}};
  for (int i = 0; i < static_cast<int>(3 * rate_hz); ++i) {
    recording.frame.push_back(i), recording.time_s.push_back(i / rate_hz);
    const Eigen::Vector2d error = sigma_px * Eigen::Vector2d{noise(random), noise(random)};
    recording.markers[0].samples.push_back(
        {SeenPx(i / rate_hz, shutter) + error, sigma_px, motion::SampleStatus::kDetected});
  }
  return recording;
}

double RmsPx(const motion::MarkerRecording& recording) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    const motion::MarkerSample& sample = recording.markers[0].samples[i];
    if (!sample.IsKnown()) continue;
    sum += (sample.position - PathPx(recording.time_s[i])).squaredNorm() / 2, ++count;
  }
  return std::sqrt(sum / count);
}

TEST(RollingShutter, PositionsComeToTheirFramesTimes) {
  for (const auto& [readout_s, rate_hz, rotation_deg] :
       {std::tuple{0.020, 60.0, 0}, {0.030, 30.0, 90}, {0.010, 120.0, 180}, {-0.015, 50.0, 270}}) {
    const gait::RollingShutter shutter = gait::ShutterOf(readout_s, 1280, 720, rotation_deg, false);
    const motion::MarkerRecording seen = Record(rate_hz, shutter, 0, 1);
    EXPECT_GT(RmsPx(seen), 0.5) << readout_s;
    EXPECT_LT(RmsPx(gait::AtFrameTimes(seen, shutter)), 0.02) << readout_s;  // the ends have neighbours on one side
    // Noise grows by little.
    EXPECT_LT(RmsPx(gait::AtFrameTimes(Record(rate_hz, shutter, 0.05, 2), shutter)), 0.065) << readout_s;
  }
}

TEST(RollingShutter, GapsAreNoNeighboursAndWithoutReadoutNothingMoves) {
  const gait::RollingShutter shutter = gait::ShutterOf(0.02, 1280, 720, 0, false);
  motion::MarkerRecording seen = Record(60, shutter, 0, 1);
  for (std::size_t i = 40; i < 60; ++i) seen.markers[0].samples[i] = {};
  const motion::MarkerRecording moved = gait::AtFrameTimes(seen, shutter);
  EXPECT_FALSE(moved.markers[0].samples[50].IsKnown());
  EXPECT_LT(RmsPx(moved), 0.1);
  const gait::RollingShutter global = gait::ShutterOf(0, 1280, 720, 0, false);
  EXPECT_EQ(gait::AtFrameTimes(seen, global).markers[0].samples[30].position, seen.markers[0].samples[30].position);
}

TEST(RollingShutter, RunsAlongTheSensorsRowsHoweverThePictureIsTurned) {
  // The sensor's first row is on the right of a picture that was turned clockwise by 90°.
  const gait::RollingShutter turned = gait::ShutterOf(0.02, 720, 1280, 90, false);
  EXPECT_NEAR(turned.DelayS({720, 100}), -0.01, 1e-12);
  EXPECT_NEAR(turned.DelayS({0, 900}), 0.01, 1e-12);
  EXPECT_NEAR(gait::ShutterOf(0.02, 1280, 720, 180, false).DelayS({5, 720}), -0.01, 1e-12);
  EXPECT_NEAR(gait::ShutterOf(0.02, 720, 1280, 270, false).DelayS({720, 5}), 0.01, 1e-12);
  EXPECT_NEAR(gait::ShutterOf(0.02, 720, 1280, 270, true).DelayS({720, 5}), -0.01, 1e-12);
}

}  // namespace
}  // namespace lake
