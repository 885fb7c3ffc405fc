// The other detectors through TrackMarkers, on real recordings and on a patch that is followed for long.
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "lake/core/csv.h"
#include "lake/tracking/track_markers.h"
#include "lake/tracking/tracklet.h"
#include "tracking/marker_scene.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

TEST(ColorDetector, LightsOfAWalkingLegGiveTheirPublishedFlexion) {
  const fs::path video = fs::path(LAKE_SHARED_DATA) / "led_leg_walk" / "mocap1_Chang2.mp4";
  if (!fs::exists(video)) GTEST_SKIP() << video << " is not here";
  TrackOptions options;
  options.names = {"hip", "knee", "ankle", "toe"};
  options.detector = DetectorKind::kColor;
  options.colors = {"#ff0000", "#00ff00", "#0000ff", "#ffff00"};
  options.crop = {109, 69, 650, 170};
  options.quiet = true;
  const MarkerRecording recording = TrackMarkers(video, options).recording;
  ASSERT_EQ(recording.Frames(), 74u);
  constexpr double kFlexionDeg[] = {68, 43, 0, 20, 20, 23, 36, 65, 40, 4, 13, 16, 16, 21, 49};
  constexpr double kToleranceDeg = 8;  // of the published values, which were read off by hand
  for (std::size_t i = 0; i < std::size(kFlexionDeg); ++i) {
    const auto at = [&](const char* name) { return recording.Find(name)->samples[5 * i]; };
    const MarkerSample hip = at("hip"), knee = at("knee"), ankle = at("ankle");
    ASSERT_TRUE(hip.IsKnown() && knee.IsKnown() && ankle.IsKnown()) << "frame " << 5 * i;
    const Vector2d shank = knee.position - ankle.position, thigh = hip.position - knee.position;
    const double flexion = std::acos(shank.normalized().dot(thigh.normalized())) * 180 / std::numbers::pi;
    EXPECT_NEAR(flexion, kFlexionDeg[i], kToleranceDeg) << "frame " << 5 * i;
  }
}

}  // namespace
}  // namespace lake
