// What lake-check says of recordings that are fit, and of those that are not.
#include "lake/commands/check.h"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgproc.hpp>

#include "lake/tracking/recording_verdicts.h"
#include "lake/video/video_writer.h"
#include "pipeline/rendered_trial.h"
#include "places.h"

namespace lake {
namespace {

synth::SceneOptions Short(std::uint64_t seed) {
  synth::SceneOptions scene = CleanLeg(seed);
  scene.duration_s = 4;
  return scene;
}

Json CheckVideo(const std::filesystem::path& video, const std::filesystem::path& out,
                commands::CheckRunOptions options = {}) {
  options.video = video;
  Run run({"lake-check", "test", Json::object(), out, true});
  return run.WriteSummary(commands::RunCheck(options, run));
}

std::string VerdictOf(const Json& summary, const std::string& name) {
  for (const Json& item : summary["checks"])
    if (item["name"] == name) return item["verdict"].get<std::string>();
  return "absent";
}

TEST(Check, SaysThatAGoodRecordingIsFitWithTheFiguresOfTheRendering) {
  const synth::SceneOptions options = Short(1);
  RenderedTrial trial(options, {});
  const Json summary = CheckVideo(trial.folder / "video.mp4", trial.folder / "check");
  const Json& figures = summary["figures"];
  EXPECT_TRUE(summary["fit"].get<bool>()) << summary["checks"].dump(1);
  EXPECT_GT(figures["all_seen_share"].get<double>(), 0.98);
  EXPECT_EQ(VerdictOf(summary, "travel_px"), "good") << figures["travel_px"];
  EXPECT_NEAR(figures["quality"]["radius_px"].get<double>(), options.marker_radius_px, 0.6);
  EXPECT_NEAR(figures["quality"]["contrast"].get<double>(), 200, 60);  // 235 over trousers and wall
  EXPECT_EQ(figures["repeated_frames"], 0);
  EXPECT_EQ(figures["dropped_frames"], 0);
  EXPECT_TRUE(std::filesystem::exists(trial.folder / "check" / "check.png"));
  // Of pictures that are too large for all of it less is seen, but beginning, middle and end.
  tracking::RecordingCheckOptions no_budget;
  no_budget.budget_mpx = 0;
  const tracking::RecordingCheck hurried = tracking::CheckRecording(trial.folder / "video.mp4", no_budget);
  EXPECT_LT(hurried.frames_seen, figures["frames_seen"].get<int>());
  EXPECT_NEAR(hurried.travel_px, figures["travel_px"].get<double>(), 0.1 * hurried.travel_px);
  // The figures of lake-track's own markers are the same.
  const Json tracked = trial.Track();
  EXPECT_NEAR(tracked["tracking"]["quality"]["radius_px"].get<double>(), figures["quality"]["radius_px"].get<double>(),
              0.3);
  EXPECT_NEAR(tracked["tracking"]["quality"]["contrast"].get<double>(), figures["quality"]["contrast"].get<double>(),
              30);
}

TEST(Check, NamesWhatMakesARecordingUnfit) {
  synth::SceneOptions dark = Short(3);
  dark.exposure = 0.12;
  dark.noise.read_sd = 6;
  RenderedTrial trial(dark, kQuickly);
  const Json unlit = CheckVideo(trial.folder / "video.mp4", trial.folder / "check");
  EXPECT_FALSE(unlit["fit"].get<bool>());
  EXPECT_THAT(unlit["checks"].dump(), testing::HasSubstr("lamp beside the lens"));

  synth::SceneOptions small = Short(4);
  small.marker_radius_px = 1.6;
  RenderedTrial far(small, kQuickly);
  EXPECT_EQ(VerdictOf(CheckVideo(far.folder / "video.mp4", far.folder / "check"), "radius_px"), "unfit");

  synth::SceneOptions still = Short(5);
  still.duration_s = 0.6;  // before the rise
  RenderedTrial resting(still, kQuickly);
  const Json seated = CheckVideo(resting.folder / "video.mp4", resting.folder / "check");
  EXPECT_EQ(VerdictOf(seated, "travel_px"), "unfit") << seated["checks"].dump(1);
}

// A marker of one level over its background, as coding leaves it; the share of its samples that is overexposed.
double OverexposedAt(double level, double background, const tracking::ImageFigures& image, int white_level) {
  tracking::Tracklet marker;
  for (int frame = 0; frame < 30; ++frame)
    marker.samples.push_back(
        {.frame = frame, .radius_px = 5, .amplitude = level - background, .background = background});
  video::VideoInfo video;
  video.white_level = white_level;
  const tracking::Tracklet* const markers[] = {&marker};
  return tracking::FiguresOf(markers, image, video).saturated_share;
}

// It is the level of a marker that is clipped, not its contrast to what is round it.
TEST(Check, KnowsWhiteMarkersFromBrightOnes) {
  const tracking::ImageFigures blurred;  // nothing piles up on one level
  for (const double background : {5.0, 40.0, 90.0}) {
    for (const int white : {255, 235}) {
      EXPECT_EQ(OverexposedAt(0.98 * white, background, blurred, white), 1) << white << " over " << background;
      EXPECT_EQ(OverexposedAt(0.96 * white, background, blurred, white), 0) << white << " over " << background;
    }
    // A camera that goes beyond its stream's white.
    EXPECT_EQ(OverexposedAt(244, background, blurred, 235), 0);
    EXPECT_EQ(OverexposedAt(254, background, blurred, 235), 1);
  }
  const tracking::ImageFigures clipped{.noise = {}, .saturation_level = 220, .shutter_fraction = {}};
  EXPECT_EQ(OverexposedAt(240, 40, clipped, 255), 1);
  EXPECT_EQ(OverexposedAt(210, 40, clipped, 255), 0);
}

// What is said of coding rests on the pictures' bits; a file holds sound and more beside them.
TEST(Check, CountsThePicturesBitsAlone) {
  RenderedTrial trial(Short(8), kQuickly);
  const std::filesystem::path film = trial.folder / "video.mp4", larger = trial.folder / "larger.mp4";
  std::filesystem::copy_file(film, larger);
  constexpr unsigned kMore = 1 << 22;
  std::ofstream(larger, std::ios::binary | std::ios::app)
      << std::string{0, 0x40, 0, 0} << "free" << std::string(kMore - 8, '\0');
  const Json bits = CheckVideo(film, trial.folder / "check")["figures"]["bits_per_pixel"];
  EXPECT_EQ(CheckVideo(larger, trial.folder / "again")["figures"]["bits_per_pixel"], bits);
  const double whole = 8.0 * static_cast<double>(std::filesystem::file_size(film)) / (240.0 * 720 * 720);
  EXPECT_NEAR(bits.get<double>(), whole, 0.05 * whole);  // but for the container's tables
}

// What nothing was seen of, what leans, and fields instead of frames are judged without a video.
TEST(Check, JudgesFiguresOneByOne) {
  tracking::RecordingCheck check;
  check.video.frame_rate_hz = 60;
  check.frames_seen = 240;
  check.all_seen_share = 1;
  check.why_not_named = "fewer than four markers";
  const auto verdict = [&](const std::string& name) {
    for (const tracking::CheckItem& item : tracking::JudgeRecording(check, 4))
      if (item.name == name) return fmt::format("{} {}", static_cast<int>(item.verdict), item.advice);
    return std::string("absent");
  };
  EXPECT_THAT(verdict("markers"), testing::AllOf(testing::StartsWith("3 "), testing::HasSubstr("--detector")));
  EXPECT_EQ(verdict("radius_px"), "absent");
  EXPECT_EQ(verdict("blur_px"), "absent");
  EXPECT_EQ(verdict("travel_px"), "absent");
  EXPECT_EQ(verdict("tilt_deg"), "absent");
  check.tilt_deg = -3;
  EXPECT_THAT(verdict("tilt_deg"), testing::AllOf(testing::StartsWith("1 "), testing::HasSubstr("--vertical")));
  check.tilt_deg = 1.5;
  EXPECT_THAT(verdict("tilt_deg"), testing::StartsWith("0 "));
  EXPECT_EQ(verdict("interlaced"), "absent");
  check.video.interlaced = true;
  EXPECT_THAT(verdict("interlaced"), testing::StartsWith("2 "));
  check.clutter = 60;
  check.strongest_clutter = 0.5;
  EXPECT_THAT(verdict("clutter"), testing::AllOf(testing::StartsWith("2 "), testing::HasSubstr("--crop")));
  EXPECT_EQ(verdict("knee_hidden_share"), "absent");
  check.knee_hidden_share = 0.83;
  check.why_not_named.clear();
  EXPECT_THAT(verdict("knee_hidden_share"), testing::HasSubstr("1 two markers on the shank would replace it"));
  const auto with_technical = tracking::JudgeRecording(check, 7);
  EXPECT_THAT(std::ranges::find(with_technical, "knee_hidden_share", &tracking::CheckItem::name)->advice,
              testing::HasSubstr("--technical"));
  // Lamps do not make a recording unfit in which the markers are named all the same
  EXPECT_THAT(verdict("clutter"), testing::StartsWith("1 "));
}

// Lamps that stay where they are, and lights that go about each by itself: what lake track cannot name is not judged.
TEST(Check, WhatCannotBeNamedIsNotJudged) {
  const TemporaryFolder folder;
  for (const double speed_px : {0.0, 1.0}) {
    video::VideoWriterOptions options;
    options.width = 640;
    options.height = 360;
    options.frame_rate_hz = 60;
    options.grey = true;
    options.crf = 18;
    video::VideoWriter writer(folder / "lamps.mp4", options);
    for (int i = 0; i < 120; ++i) {
      cv::Mat1b picture(360, 640, uchar{40});
      for (int lamp = 0; lamp < 4; ++lamp) {
        const double along = speed_px * i * (lamp - 1.5);
        cv::circle(picture, cv::Point2d(320 + 60 * (lamp - 1.5) + along, 60 + 70 * lamp), 7, 250, cv::FILLED,
                   cv::LINE_AA);
      }
      writer.Write(picture, i / 60.0);
    }
    writer.Finish();
    const Json check = CheckVideo(folder / "lamps.mp4", folder / "out");
    EXPECT_EQ(VerdictOf(check, "markers"), "not judged") << check["checks"].dump(1);
    EXPECT_FALSE(check["fit"].get<bool>());
    EXPECT_EQ(VerdictOf(check, "travel_px"), speed_px > 0 ? "absent" : "unfit");
    EXPECT_THAT(check["checks"].dump(), testing::Not(testing::HasSubstr("seen_share\",\"verdict\":\"good")));
    for (const char* name : {"radius_px", "contrast_over_noise", "blur_px", "expected_knee_sd_deg"})
      EXPECT_EQ(VerdictOf(check, name), "absent") << name;
    EXPECT_TRUE(check["figures"]["expected_knee_sd_deg"].is_null());
  }
}

// A subject at rest repeats nothing, however well the picture is compressed.
TEST(Check, FindsTheSampleStudyFit) {
  const TemporaryFolder folder;
  const std::filesystem::path study = SourceDir() / "data/sts-study";
  for (const char* video : {"human.mp4", "exo.mp4"}) {
    const Json check = CheckVideo(study / video, folder / video);
    EXPECT_EQ(check["figures"]["repeated_frames"], 0) << video;
    EXPECT_TRUE(check["fit"].get<bool>()) << video << ": " << check["checks"].dump();
  }
}

// Names and places as lake track takes them: a film with more markers than the leg's, whose hub hides the knee.
TEST(Check, SaysThatAHubHidesTheKnee) {
  const TemporaryFolder folder;
  commands::CheckRunOptions options;
  options.check.names = {"ankle", "hip", "waist", "exo_knee", "shank1", "shank2"};
  options.check.seeds = {{.name = "ankle", .position = {703, 648}},  {.name = "hip", .position = {508, 413}},
                         {.name = "waist", .position = {519, 304}},  {.name = "exo_knee", .position = {730, 434}},
                         {.name = "shank1", .position = {741, 505}}, {.name = "shank2", .position = {728, 580}}};
  const Json check = CheckVideo(SourceDir() / "data/sts-study/hub-exo.mp4", folder / "out", options);
  EXPECT_TRUE(check["figures"]["named"].get<bool>()) << check["checks"].dump(1);
  EXPECT_EQ(VerdictOf(check, "knee_hidden_share"), "poor");
  EXPECT_THAT(check["checks"].dump(), testing::AllOf(testing::HasSubstr("knee hidden in 100 % of the frames"),
                                                     testing::HasSubstr("--technical shank=A,B rebuilds it")));
}

// Among sixty lamps the rings are round the markers that lake track names, not round the brightest.
TEST(Check, AmongSixtyLampsItJudgesTheMarkersThatAreTracked) {
  synth::SceneOptions scene = Short(6);
  scene.reflections = 60;
  RenderedTrial trial(scene, kQuickly);
  tracking::RecordingCheckOptions options;
  const tracking::RecordingCheck check = tracking::CheckRecording(trial.folder / "video.mp4", options);
  ASSERT_TRUE(check.IsNamed()) << check.why_not_named;
  EXPECT_GT(check.clutter, 20);  // of sixty, those that shine as markers do
  const auto frame = static_cast<int>(std::lround(check.shown_frame_ms * scene.frame_rate_hz / 1000));
  std::size_t named = 0;
  for (const tracking::CheckedSpot& spot : check.spots_shown) {
    if (spot.name.empty()) continue;
    ++named;
    const auto marker = static_cast<std::size_t>(synth::IndexOfMarker(trial.scene.Motion(), spot.name));
    EXPECT_LT((spot.position - trial.Truth(frame).markers[marker].px).norm(), 1) << spot.name;
  }
  EXPECT_EQ(named, 4u);
  for (const tracking::CheckItem& item : tracking::JudgeRecording(check, 4))
    EXPECT_LT(item.verdict, tracking::Verdict::kUnfit) << item.shown;
}

TEST(Check, CountsRepeatedAndDroppedFrames) {
  const synth::Scene scene(Short(5));
  const TemporaryFolder folder;
  video::VideoWriterOptions options;
  options.width = scene.Options().width_px, options.height = scene.Options().height_px, options.frame_rate_hz = 60,
  options.grey = true, options.crf = 18;
  {
    video::VideoWriter repeating(folder / "repeated.mp4", options), dropping(folder / "dropped.mp4", options);
    for (int i = 0; i < 150; ++i) {
      const cv::Mat picture = scene.Render(60 + (i % 5 == 4 ? i - 1 : i));
      repeating.Write(picture, i / 60.0);
      if (i < 40 || i % 10 != 0) dropping.Write(scene.Render(60 + i), i / 60.0);
    }
    repeating.Finish();
    dropping.Finish();
  }
  const Json repeated = CheckVideo(folder / "repeated.mp4", folder / "a"),
             dropped = CheckVideo(folder / "dropped.mp4", folder / "b");
  EXPECT_EQ(VerdictOf(repeated, "repeated_frames"), "unfit");
  EXPECT_FALSE(repeated["fit"].get<bool>());
  EXPECT_EQ(VerdictOf(dropped, "dropped_frames"), "unfit");
  EXPECT_EQ(dropped["figures"]["dropped_frames"], 11);
  EXPECT_EQ(VerdictOf(dropped, "repeated_frames"), "good");
}

}  // namespace
}  // namespace lake
