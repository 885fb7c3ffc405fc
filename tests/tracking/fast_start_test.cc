// Markers that move fast when they are first seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "lake/tracking/tracklet.h"
#include "tracking/marker_scene.h"

namespace lake::fast_start {
namespace {

using Eigen::Vector2d;

constexpr int kFrames = 30;
constexpr double kShutter = 0.4, kRadius_px = 3;

// Comes in at 20 px per frame and is braked evenly until it rests, within 14 frames.
Vector2d Place(double frame) {
  constexpr double kSpeed_px = 20, kUntil = 14;
  const double t = std::min(frame, kUntil);
  return {20 + kSpeed_px * (t - t * t / (2 * kUntil)), 30.3};
}

video::VideoFrame FrameAt(int i, std::mt19937& random) {
  const SceneMarker moving{.center = Place(i),
                           .radius_px = kRadius_px,
                           .blur_px = Place(i + kShutter / 2) - Place(std::max(0.0, i - kShutter / 2))},
      resting{.center = {60.4, 70.2}, .radius_px = kRadius_px};
  video::VideoFrame frame;
  frame.index = i;
  frame.time_s = i / 25.0;
  frame.luma = AddNoise(DrawMarkers({220, 100}, {moving, resting}, 0.7, 40), {1.5, 0.02}, random);
  return frame;
}

// Its velocity is not known before it is slow enough to be followed: from then on it is followed back. It was found
// from frame 6 on. In the first frames it is faster than at any time after the shutter is known from it.
TEST(FastStart, IsFollowedBackOnceItsVelocityIsKnown) {
  const auto detector = tracking::MakeReflectiveDetector(tracking::Polarity::kBright, {});
  tracking::TrackletBuilder builder(*detector, {});
  std::mt19937 random(3);
  for (int i = 0; i < kFrames; ++i) builder.Add(FrameAt(i, random));
  const std::vector<tracking::Tracklet> tracklets = builder.Finish();
  const auto seen = [&](int i) {
    return std::ranges::any_of(tracklets, [&](const tracking::Tracklet& tracklet) {
      const tracking::TrackletSample* sample = tracklet.SampleIn(i);
      return sample && (sample->position - Place(i)).norm() < 0.3;  // 6 sigma
    });
  };
  constexpr int kFirst = 3;
  for (int i = kFirst; i < kFrames; ++i) EXPECT_TRUE(seen(i)) << "frame " << i;
  EXPECT_EQ(tracklets.size(), 2u);
}

}  // namespace
}  // namespace lake::fast_start
