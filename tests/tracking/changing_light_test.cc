// Light and gain that change while markers are followed: what was learnt of noise and saturation must follow.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "lake/tracking/tracklet.h"
#include "tracking/marker_scene.h"

namespace lake::changing_light {
namespace {

using Eigen::Vector2d;

constexpr int kFrames = 90, kChange = 36, kDiscs = 3;

Vector2d Truth(int disc, int frame) {
  return {16.3 + 24 * disc + 0.23 * frame, 20.2 + 8 * disc + 9 * std::sin(frame / 13.0)};
}

// Noise-free pictures of three discs of 150 grey levels before 40.
const std::vector<cv::Mat>& Pictures() {
  static const std::vector<cv::Mat> pictures = [] {
    std::vector<cv::Mat> drawn;
    for (int frame = 0; frame < kFrames; ++frame) {
      std::vector<SceneMarker> discs;
      for (int disc = 0; disc < kDiscs; ++disc) discs.push_back({.center = Truth(disc, frame)});
      drawn.push_back(DrawMarkers({104, 68}, discs, 0.7, 40));
    }
    return drawn;
  }();
  return pictures;
}

struct Camera {
  double gain;
  SceneNoise noise;
  double white = 255;
};

// Of the discs in some frames of some recordings.
struct Followed {
  double seen = 0, rms_px = 0, z = 0;  // share; error per axis; of error over sigma
};

std::vector<tracking::Tracklet> Track(const std::function<Camera(int)>& camera, std::uint32_t seed) {
  const auto detector = tracking::MakeReflectiveDetector(tracking::Polarity::kBright, {});
  tracking::TrackletBuilder builder(*detector, {});
  std::mt19937 random(seed);
  for (int i = 0; i < kFrames; ++i) {
    const Camera now = camera(i);
    video::VideoFrame frame;
    frame.index = i, frame.time_s = i / 60.0;
    frame.luma = cv::min(AddNoise(now.gain * Pictures()[static_cast<std::size_t>(i)], now.noise, random), now.white);
    builder.Add(frame);
  }
  return builder.Finish();
}

// Four recordings of other noise, their frames first..last.
Followed Follow(const std::function<Camera(int)>& camera, int first, int last) {
  constexpr std::uint32_t kSeeds = 4;
  double squares = 0, z_squares = 0;
  int seen = 0, all = 0;
  for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
    const std::vector<tracking::Tracklet> tracklets = Track(camera, seed);
    for (int i = first; i <= last; ++i)
      for (int disc = 0; disc < kDiscs; ++disc, ++all)
        for (const tracking::Tracklet& tracklet : tracklets) {
          const tracking::TrackletSample* sample = tracklet.SampleIn(i);
          if (!sample || (sample->position - Truth(disc, i)).norm() > 2) continue;
          ++seen;
          const double square = 0.5 * (sample->position - Truth(disc, i)).squaredNorm();
          squares += square, z_squares += square / (sample->sigma_px * sample->sigma_px);
          break;
        }
  }
  return {seen / static_cast<double>(all), std::sqrt(squares / seen), std::sqrt(z_squares / seen)};
}

void ExpectHonest(const Followed& followed) {
  EXPECT_GE(followed.seen, 0.97);
  EXPECT_LE(followed.z, 1.2);
  EXPECT_GE(followed.z, 0.8);
}

// A cloud: the camera keeps the levels and raises its gain, and with it the noise. From some 800 errors z is known to
// 3 %; with weights that went on as learnt before, or that followed within a second, it was 1.4.
TEST(ChangingLight, NoiseThatGrowsIsLearntWithinFrames) {
  const Followed followed = Follow(
      [](int i) {
        return Camera{1, i < kChange ? SceneNoise{1, 0.005} : SceneNoise{6, 0.4}};
      },
      kChange + 3, kChange + 36);
  ExpectHonest(followed);
}

TEST(ChangingLight, NoiseThatFallsIsLearntWithinFrames) {
  const Followed followed = Follow(
      [](int i) {
        return Camera{1, i < kChange ? SceneNoise{6, 0.4} : SceneNoise{1, 0.005}};
      },
      kChange + 3, kChange + 36);
  ExpectHonest(followed);
}

// The sun comes out: markers that were dim are clipped at the camera's white from then on. With the first frames'
// saturation level the error was 0.0127 px, and 1.6 of its sigma.
TEST(ChangingLight, SaturationThatBeginsLaterIsLearnt) {
  const Followed followed = Follow(
      [](int i) {
        return Camera{std::clamp(0.9 + 0.07 * (i - kChange), 0.9, 2.0), {1, 0.02}, 235};
      },
      kChange + 20, kFrames - 1);
  EXPECT_GE(followed.seen, 0.95);
  EXPECT_LE(followed.rms_px, 0.007);
  EXPECT_LE(followed.z, 1.3);
  EXPECT_GE(followed.z, 0.8);
}

}  // namespace
}  // namespace lake::changing_light
