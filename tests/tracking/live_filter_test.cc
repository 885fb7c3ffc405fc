// The filter that follows markers while they come, and the scale of the picture that it starts with.
#include <gtest/gtest.h>

#include "lake/tracking/live_tracker.h"
#include "marker_scene.h"

namespace lake {
namespace {

// A disc in the picture of a close-up camera of 500 frames per second: 75 mm/s are 3 px a frame, which is quick for a
// filter that takes 20 px for a millimetre's length, and slow for a person.
TEST(LiveFilter, StartsWithWhatAPersonDoesAtTheScaleOfThePicture) {
  constexpr double kRate_hz = 500, kStep_px = 3;
  video::VideoInfo info;
  info.width = 160, info.height = 64, info.frame_rate_hz = kRate_hz, info.is_lossless = true;
  const auto place = [&](int i) { return Eigen::Vector2d(30.3 + kStep_px * i, 31.6); };
  tracking::LiveTrackOptions options;
  options.names = {"knee"};
  options.seeds = {{.name = "knee", .position = place(0)}};
  options.mm_per_px = 0.05;
  tracking::LiveTracker tracker(options, info);
  for (int i = 0; i < 20; ++i) {
    SceneMarker marker;
    marker.center = place(i);
    marker.radius_px = 6;
    video::VideoFrame frame;
    frame.index = i;
    frame.time_s = i / kRate_hz;
    DrawMarkers({info.width, info.height}, {marker}, 0.6, 30).convertTo(frame.luma, CV_8U);
    tracker.Add(frame);
  }
  const motion::MarkerTrack* knee = tracker.Reported().Find("knee");
  ASSERT_TRUE(knee);
  for (std::size_t i = 0; i < knee->samples.size(); ++i) {
    ASSERT_EQ(knee->samples[i].status, motion::SampleStatus::kDetected) << i;
    EXPECT_LT((knee->samples[i].position - place(static_cast<int>(i))).norm(), 0.05) << i;
  }
}

}  // namespace
}  // namespace lake
