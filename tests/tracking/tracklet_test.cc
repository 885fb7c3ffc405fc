// What a tracklet keeps of what was detected.
#include "lake/tracking/tracklet.h"

#include <gtest/gtest.h>

#include <random>

namespace lake {
namespace {

// One disc that moves, whose measured size scatters, and of which a fifth is hidden from frame 60 to 63.
class ScatteringDisc : public tracking::MarkerDetector {
 public:
  ScatteringDisc(double scatter, unsigned seed) : scatter_(scatter), random_(seed) {}

  std::vector<tracking::MarkerDetection> Detect(const video::VideoFrame& frame,
                                                std::span<const tracking::MarkerPrediction>, bool) override {
    const bool hidden = frame.index >= 60 && frame.index < 64;
    tracking::MarkerDetection detection;
    detection.position = {100 + 4.0 * static_cast<double>(frame.index), 200};
    detection.sigma_px = 0.05;
    const double radius = kRadius_px * (hidden ? 0.8 : 1 + scatter_ * normal_(random_));
    detection.appearance.center = detection.position;
    detection.appearance.unit_circle_from_px = Eigen::Matrix2d::Identity() / radius;
    detection.appearance.amplitude = 100;
    detection.quality = 0.04;
    return {detection};
  }

  static constexpr double kRadius_px = 3;

 private:
  double scatter_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

std::vector<tracking::TrackletSample> Kept(double scatter, unsigned seed) {
  ScatteringDisc disc(scatter, seed);
  tracking::TrackletBuilder builder(disc, {});
  for (int i = 0; i < 120; ++i) {
    video::VideoFrame frame;
    frame.index = i, frame.time_s = i / 30.0;
    builder.Add(frame);
  }
  const std::vector<tracking::Tracklet> tracklets = builder.Finish();
  EXPECT_EQ(tracklets.size(), 1u);
  return tracklets.empty() ? std::vector<tracking::TrackletSample>() : tracklets.front().samples;
}

// Coded at crf 30, streaks of 3 px discs are measured with sizes that scatter by 3 to 4 %: a limit of 7 % refused one
// in twenty. The four that are hidden by a fifth go at any scatter; of the other 116, ends apart, 4 deviations lose
// none.
TEST(Tracklet, SizesThatAllScatterAreNoReasonToRefuseAMarker) {
  for (const unsigned seed : {1u, 2u, 3u})
    for (const double scatter : {0.005, 0.02, 0.045}) {
      const std::vector<tracking::TrackletSample> kept = Kept(scatter, seed);
      EXPECT_GE(kept.size(), 110u) << scatter << ", seed " << seed;
      for (const tracking::TrackletSample& sample : kept)
        EXPECT_FALSE(sample.frame >= 60 && sample.frame < 64) << "hidden, in frame " << sample.frame;
    }
}

}  // namespace
}  // namespace lake
