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
  tracking::TrackOptions options;
  options.names = {"hip", "knee", "ankle", "toe"};
  options.detector = tracking::DetectorKind::kColor;
  options.colors = {"#ff0000", "#00ff00", "#0000ff", "#ffff00"};
  options.crop = {109, 69, 650, 170};
  options.quiet = true;
  const motion::MarkerRecording recording = tracking::TrackMarkers(video, options).recording;
  ASSERT_EQ(recording.Frames(), 74u);
  constexpr double kFlexionDeg[] = {68, 43, 0, 20, 20, 23, 36, 65, 40, 4, 13, 16, 16, 21, 49};
  constexpr double kToleranceDeg = 8;  // of the published values, which were read off by hand
  for (std::size_t i = 0; i < std::size(kFlexionDeg); ++i) {
    const auto at = [&](const char* name) { return recording.Find(name)->samples[5 * i]; };
    const motion::MarkerSample hip = at("hip"), knee = at("knee"), ankle = at("ankle");
    ASSERT_TRUE(hip.IsKnown() && knee.IsKnown() && ankle.IsKnown()) << "frame " << 5 * i;
    const Vector2d shank = knee.position - ankle.position, thigh = hip.position - knee.position;
    const double flexion = std::acos(shank.normalized().dot(thigh.normalized())) * 180 / std::numbers::pi;
    EXPECT_NEAR(flexion, kFlexionDeg[i], kToleranceDeg) << "frame " << 5 * i;
  }
}

// A ball of 4.5 px that moves up to 70 px a frame past brighter things; in frame 5 it touches one of them.
TEST(ReflectiveDetector, AThrownBallIsWhereTrackerSawIt) {
  const fs::path folder = fs::path(LAKE_SHARED_DATA) / "tracker_balltoss";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not here";
  const CsvTable truth = CsvTable::Read(folder / "truth_ball_from_trk.csv");
  const auto place = [&](std::size_t row) {
    return Vector2d(truth.RequiredNumber(row, truth.Column("x_px")), truth.RequiredNumber(row, truth.Column("y_px")));
  };
  tracking::TrackOptions options;
  options.names = {"ball"};
  options.seeds = {{"ball", place(0), static_cast<std::int64_t>(truth.RequiredNumber(0, truth.Column("frame")))}};
  options.quiet = true;
  const motion::MarkerRecording recording =
      tracking::TrackMarkers(folder / "videos" / "BallToss_new_BallToss.mp4", options).recording;
  int near = 0;
  for (std::size_t row = 0; row < truth.Rows(); ++row) {
    const motion::MarkerSample& sample =
        recording.markers[0].samples.at(static_cast<std::size_t>(truth.RequiredNumber(row, truth.Column("frame"))));
    near += sample.IsKnown() && (sample.position - place(row)).norm() <= 2;
  }
  EXPECT_GE(near, 10);
}

// A textured patch that wanders 40 px by known fractions of a pixel.
TEST(TemplateDetector, DoesNotDriftIn200Frames) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> offset(-16, 16), level(20, 90);
  std::vector<SceneMarker> texture(12);
  for (SceneMarker& spot : texture)
    spot.center = {offset(random), offset(random)}, spot.radius_px = 4, spot.amplitude = level(random);
  const auto truth = [](int frame) { return Vector2d(50 + 0.217 * frame, 60 + 9 * std::sin(frame / 17.0)); };
  const auto picture = [&](int frame) {
    std::vector<SceneMarker> spots = texture;
    for (SceneMarker& spot : spots) spot.center += truth(frame);
    return AddNoise(DrawMarkers({150, 120}, spots, 0.7, 40), SceneNoise{}, random);
  };
  const auto detector = tracking::MakeTemplateDetector({{"patch", truth(0), 0}}, {picture(0)}, {});
  tracking::TrackletBuilder builder(*detector, {});
  for (int i = 0; i < 200; ++i) {
    video::VideoFrame frame;
    frame.index = i, frame.time_s = i / 60.0, frame.luma = picture(i);
    builder.Add(frame);
  }
  const std::vector<tracking::Tracklet> tracklets = builder.Finish();
  ASSERT_EQ(tracklets.size(), 1u);
  ASSERT_EQ(tracklets[0].LastFrame(), 199);
  EXPECT_LE((tracklets[0].samples.back().position - truth(199)).norm(), 0.1);
}

}  // namespace
}  // namespace lake
