// The other detectors through TrackMarkers, on real recordings and on a patch that is followed for long.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <random>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/options.h"
#include "lake/tracking/track_markers.h"
#include "lake/tracking/tracklet.h"
#include "places.h"
#include "tracking/marker_scene.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

TEST(ColorDetector, LightsOfAWalkingLegGiveTheirPublishedFlexion) {
  const fs::path video = SharedData() / "led_leg_walk" / "mocap1_Chang2.mp4";
  if (!fs::exists(video)) GTEST_SKIP() << video << " is not here";
  tracking::TrackOptions options;
  options.names = {"hip", "knee", "ankle", "toe"};
  options.detector = "color";
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

// A colour as a camera gives it: brightness in every pixel, chroma in one of four, the mean of them.
video::VideoFrame ColourFrame(int index, const std::vector<cv::Mat>& bgr) {
  cv::Mat picture, converted;
  cv::merge(bgr, picture);
  cv::cvtColor(picture, converted, cv::COLOR_BGR2YCrCb);
  std::vector<cv::Mat> planes;
  cv::split(converted, planes);
  const cv::Size half = picture.size() / 2;
  video::VideoFrame frame;
  frame.index = index, frame.time_s = index / 60.0, frame.luma = planes[0];
  frame.preview.create(picture.rows * 3 / 2, picture.cols, CV_8UC1);
  planes[0].copyTo(frame.preview.rowRange(0, picture.rows));
  for (const int plane : {2, 1}) {
    const std::size_t offset = picture.total() + (plane == 1 ? half.area() : 0);
    cv::resize(planes[static_cast<std::size_t>(plane)], cv::Mat(half, CV_8UC1, frame.preview.data + offset), half, 0, 0,
               cv::INTER_AREA);
  }
  return frame;
}

// Discs of one colour before another; `lamp`, if not empty, is three times as vivid and as large, and stands still.
struct ColourScene {
  cv::Vec3d disc, behind;
  std::vector<Vector2d> lamp = {};
  cv::Size size = {170, 130};

  static Vector2d Truth(int disc, int frame) {
    return {30.3 + 55 * disc + 0.31 * frame, 40.2 + 30 * disc + 12 * std::sin(frame / 11.0)};
  }

  video::VideoFrame Draw(int frame, std::mt19937& random) const {
    std::vector<SceneMarker> discs, lamps;
    for (int i = 0; i < 3; ++i) discs.push_back({.center = Truth(i, frame), .radius_px = 4, .amplitude = 1});
    for (const Vector2d& place : lamp) lamps.push_back({.center = place, .radius_px = 10, .amplitude = 1});
    const cv::Mat of_disc = DrawMarkers(size, discs, 0.7, 0),
                  of_lamp = lamps.empty() ? cv::Mat(cv::Mat::zeros(size, CV_64F)) : DrawMarkers(size, lamps, 0.7, 0);
    std::vector<cv::Mat> bgr;
    for (int c = 0; c < 3; ++c) {
      const double lamp_level = c == 2 ? 255 : 0;
      const cv::Mat levels = behind[c] + (disc[c] - behind[c]) * of_disc + (lamp_level - behind[c]) * of_lamp;
      bgr.push_back(AddNoise(levels, {2, 0}, random));
    }
    return ColourFrame(frame, bgr);
  }
};

struct ColourResult {
  double seen = 0, rms_px = 0, z = 0;  // share of discs and frames; 2-D; of error over sigma
};

ColourResult FollowColour(const ColourScene& scene, std::uint32_t seed) {
  constexpr int kFrames = 40;
  std::mt19937 random(seed);
  const Vector2d first = ColourScene::Truth(1, 0).array().round();
  const tracking::MarkerColor picked = tracking::ParseMarkerColor(fmt::format("@{},{}", first.x(), first.y()));
  std::unique_ptr<tracking::MarkerDetector> detector;
  std::unique_ptr<tracking::TrackletBuilder> builder;
  for (int i = 0; i < kFrames; ++i) {
    const video::VideoFrame frame = scene.Draw(i, random);
    if (!detector) {
      detector = tracking::MakeColorDetector({tracking::HueAt(frame, picked)}, {});
      builder = std::make_unique<tracking::TrackletBuilder>(*detector, tracking::TrackletOptions{});
    }
    builder->Add(frame);
  }
  const std::vector<tracking::Tracklet> tracklets = builder->Finish();
  int seen = 0;
  double squares = 0, z_squares = 0;
  for (int i = 0; i < kFrames; ++i)
    for (int disc = 0; disc < 3; ++disc) {
      const Vector2d truth = ColourScene::Truth(disc, i);
      for (const tracking::Tracklet& tracklet : tracklets) {
        const tracking::TrackletSample* sample = tracklet.SampleIn(i);
        if (!sample || (sample->position - truth).norm() > 2) continue;
        ++seen;
        squares += (sample->position - truth).squaredNorm();
        z_squares += (sample->position - truth).squaredNorm() / (2 * sample->sigma_px * sample->sigma_px);
        break;
      }
    }
  return {seen / (3.0 * kFrames), std::sqrt(squares / seen), std::sqrt(z_squares / seen)};
}

constexpr double kLeastSeen = 0.99;

// Darker than what is behind them, of one colour: of such a hand-held card 51 % of the frames were seen whole.
TEST(ColorDetector, RedDotsOnAWhiteCard) {
  const ColourResult result = FollowColour({{40, 40, 200}, {225, 230, 228}}, 41);
  EXPECT_GE(result.seen, kLeastSeen);
  EXPECT_LE(result.rms_px, 0.05);  // the bound of luma alone is 0.02 px
  EXPECT_LE(result.z, 1.4);
  EXPECT_GE(result.z, 0.7);
}

// As bright as the cloth: only the chroma, of half the resolution, shows them.
TEST(ColorDetector, DotsAsBrightAsTheClothBehindThem) {
  const ColourResult result = FollowColour({{50, 60, 190}, {98, 98, 98}}, 42);
  EXPECT_GE(result.seen, kLeastSeen);
  EXPECT_LE(result.rms_px, 0.08);
  EXPECT_LE(result.z, 1.4);
  EXPECT_GE(result.z, 0.7);
}

TEST(ColorDetector, ALampOfTheSameColourHidesNothing) {
  const ColourResult result = FollowColour({{70, 70, 150}, {60, 70, 75}, {{148, 30}}}, 43);
  EXPECT_GE(result.seen, kLeastSeen);
  EXPECT_LE(result.rms_px, 0.08);
}

TEST(MarkerColor, IsToldByLevelsOrByAPlace) {
  const tracking::MarkerColor place = tracking::ParseMarkerColor("@12.5,7@30");
  EXPECT_FALSE(place.bgr);
  EXPECT_EQ(place.position, Vector2d(12.5, 7));
  EXPECT_EQ(place.frame, 30);
  EXPECT_EQ(tracking::ParseMarkerColor("#ff8001").bgr, cv::Vec3b(1, 128, 255));
  for (const char* wrong : {"red", "#ff80", "@12", "@1,2@-1", "@1,2@0.5", "@", "12,7"})
    EXPECT_THROW(tracking::ParseMarkerColor(wrong), UsageError) << wrong;
}

TEST(MarkerColor, APlaceWithoutColourIsRefused) {
  std::mt19937 random(5);
  const video::VideoFrame frame = ColourScene{{40, 40, 200}, {225, 230, 228}}.Draw(0, random);
  EXPECT_THROW(tracking::HueAt(frame, tracking::ParseMarkerColor("@150,20")), Error);
  EXPECT_THROW(tracking::HueAt(frame, tracking::ParseMarkerColor("@500,20")), Error);
  EXPECT_NO_THROW(tracking::HueAt(frame, tracking::ParseMarkerColor("@30,40")));
}

TEST(MarkerColor, ListsWithCommasKeepPlacesWhole) {
  tracking::TrackOptions track;
  OptionList options = OptionsOf(track);
  for (Option& option : options.All())
    if (option.Name() == "color") option.SetFromCommandLine({"#ff0000,@12,7@3,#00ff00", "@1,2"});
  EXPECT_EQ(track.colors, (std::vector<std::string>{"#ff0000", "@12,7@3", "#00ff00", "@1,2"}));
}

// A ball of 4.5 px that moves up to 70 px a frame past brighter things; in frame 5 it touches one of them.
TEST(ReflectiveDetector, AThrownBallIsWhereTrackerSawIt) {
  const fs::path folder = SharedData() / "tracker_balltoss";
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
