// Overlays of small made-up recordings; what a decoded frame shows is compared with what was to be drawn.
#include "lake/overlay/overlay_video.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/threads.h"
#include "lake/video/video_writer.h"
#include "temporary_folder.h"
#include "turned_film.h"

namespace lake {
namespace {

constexpr int kFrames = 12;

double IrregularTime_s(int i) {
  return 0.5 + i / 30.0 + (i % 3) * 0.004;
}

// Even grey, with irregular stamps.
void WriteGreyVideo(const std::filesystem::path& path, int width, int height) {
  video::VideoWriter writer(path, {.width = width, .height = height, .lossless = true, .grey = true});
  for (int i = 0; i < kFrames; ++i) writer.Write(cv::Mat(height, width, CV_8UC1, cv::Scalar(60)), IrregularTime_s(i));
  writer.Finish();
}

// A bent leg that stands still.
motion::MarkerRecording Leg(double scale = 1) {
  motion::MarkerRecording recording;
  const std::vector<std::pair<const char*, Eigen::Vector2d>> places = {
      {"ankle", {420, 430}}, {"knee", {440, 300}}, {"hip", {300, 290}}, {"waist", {310, 180}}};
  for (int i = 0; i < kFrames; ++i) recording.frame.push_back(i), recording.time_s.push_back(IrregularTime_s(i));
  for (const auto& [name, place] : places)
    recording.markers.push_back(
        {name, std::vector<motion::MarkerSample>(kFrames, {place * scale, 0.05, motion::SampleStatus::kDetected})});
  return recording;
}

void SetStatus(motion::MarkerRecording& recording, std::size_t marker, motion::SampleStatus status) {
  for (motion::MarkerSample& sample : recording.markers[marker].samples) sample.status = status;
}

motion::LegMotion Motion(const motion::MarkerRecording& recording) {
  motion::LegMotion motion;
  motion.frame = recording.frame;
  motion.time_s = recording.time_s;
  motion::LegSample sample;
  sample.knee_deg = 85.4;
  sample.knee_sigma_deg = 0.2;
  sample.repetition = 1;
  sample.percent = 40;
  motion.samples.assign(recording.Frames(), sample);
  return motion;
}

struct Decoded {
  video::VideoInfo info;
  std::vector<double> time_s;
  cv::Mat last;  // BGR
};

Decoded Decode(const std::filesystem::path& path) {
  const auto reader = video::VideoReader::Open(path, {.colour = true});
  Decoded decoded;
  for (video::VideoFrame frame; reader->Read(frame);) decoded.time_s.push_back(frame.time_s), decoded.last = frame.bgr;
  decoded.info = reader->Info();
  return decoded;
}

bool IsColoured(const cv::Mat& bgr, const Eigen::Vector2d& place) {
  const cv::Vec3b& p = bgr.at<cv::Vec3b>(cv::Point(cvRound(place.x()), cvRound(place.y())));
  return std::max({p[0], p[1], p[2]}) - std::min({p[0], p[1], p[2]}) > 40;  // thinned by chroma of half resolution
}

// How many of a cross's four arms are there: coloured half-way from its open middle to its end.
int ArmsOfCross(const cv::Mat& bgr, const Eigen::Vector2d& centre) {
  constexpr double kHalfWay_px = 10;  // at 720 px height
  int arms = 0;
  for (const Eigen::Vector2d& arm :
       {Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0), Eigen::Vector2d(0, 1), Eigen::Vector2d(0, -1)})
    arms += IsColoured(bgr, centre + kHalfWay_px * arm);
  return arms;
}

// Of 360 places on a circle, how many are coloured rather than grey.
int ColouredOnCircle(const cv::Mat& bgr, const Eigen::Vector2d& centre, double radius_px) {
  int coloured = 0;
  for (int degree = 0; degree < 360; ++degree) {
    const double angle = degree * CV_PI / 180;
    coloured += IsColoured(bgr, centre + radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return coloured;
}

class OverlayVideoTest : public testing::Test {
 protected:
  Decoded Overlay(int width, int height, const overlay::OverlayContent& content, overlay::OverlayOptions options = {}) {
    options.quiet = true;
    if (!std::filesystem::exists(video_)) WriteGreyVideo(video_, width, height);
    overlay::WriteOverlayVideo(video_, content, options, out_);
    return Decode(out_);
  }

  TemporaryFolder folder_;
  std::filesystem::path video_ = folder_ / "video.mp4", out_ = folder_ / "overlay.mp4";
};

// At 720 px height the ring of a filled sample has a radius of 10 px.
constexpr double kRing_px = 10;

TEST_F(OverlayVideoTest, KeepsFramesSizeAndTimeStamps) {
  const motion::MarkerRecording tracks = Leg();
  const Decoded decoded = Overlay(960, 720, {tracks});
  EXPECT_EQ(decoded.info.width, 960);
  EXPECT_EQ(decoded.info.height, 720);
  ASSERT_EQ(decoded.time_s.size(), std::size_t{kFrames});
  for (int i = 0; i < kFrames; ++i)
    EXPECT_NEAR(decoded.time_s[static_cast<std::size_t>(i)], IrregularTime_s(i), 0.5 / 90000);  // the writer's ticks
}

TEST_F(OverlayVideoTest, IsTheSameOnOneThreadAndOnTwo) {
  const motion::MarkerRecording tracks = Leg();
  const motion::LegMotion motion = Motion(tracks);
  const int usual = Threads();
  std::vector<std::string> files;
  for (const int threads : {1, 2}) {
    SetThreads(threads);
    Overlay(960, 720, {tracks, &motion});
    files.push_back(ReadTextFile(out_));
  }
  SetThreads(usual);
  EXPECT_TRUE(files[0] == files[1]);
}

TEST_F(OverlayVideoTest, CrossHasTheMarkersColourAndLeavesTheMarkerFree) {
  const motion::MarkerRecording tracks = Leg();
  const cv::Mat picture = Overlay(960, 720, {tracks}).last;
  // The hip's green #009E73: right of the centre no bone begins.
  const cv::Vec3b arm = picture.at<cv::Vec3b>(290, 310);
  EXPECT_GT(arm[1], arm[2] + 60);
  EXPECT_GT(arm[1], arm[0]);
  for (const motion::MarkerTrack& marker : tracks.markers) {
    const Eigen::Vector2d place = marker.samples[0].position;
    EXPECT_EQ(ArmsOfCross(picture, place), 4) << marker.name;
    for (const double radius_px : {0.0, 3.0})
      EXPECT_EQ(ColouredOnCircle(picture, place, radius_px), 0) << marker.name << " at " << radius_px << " px";
  }
  const cv::Vec3b untouched = picture.at<cv::Vec3b>(600, 700);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(untouched[c], 60, 3);  // limited range and compression
}

TEST_F(OverlayVideoTest, FilledIsABrokenRingAndMissingNothing) {
  motion::MarkerRecording tracks = Leg();
  const Eigen::Vector2d ankle = tracks.markers[0].samples[0].position, waist = tracks.markers[3].samples[0].position;
  SetStatus(tracks, 0, motion::SampleStatus::kFilled);
  SetStatus(tracks, 3, motion::SampleStatus::kMissing);
  const cv::Mat picture = Overlay(960, 720, {tracks}).last;
  const int filled = ColouredOnCircle(picture, ankle, kRing_px);
  EXPECT_GT(filled, 80);
  EXPECT_LT(filled, 300);  // half of it is gaps, which chroma at half resolution narrows
  EXPECT_EQ(ColouredOnCircle(picture, waist, kRing_px), 0);
  EXPECT_EQ(ArmsOfCross(picture, waist), 0);
}

// A bright dot on grey, and a track a pixel beside it: the inset shows the dot that much off its middle, magnified.
TEST_F(OverlayVideoTest, InsetShowsTheRecordingMagnified) {
  cv::Mat frame(720, 960, CV_8UC1, cv::Scalar(60));
  frame(cv::Rect(296, 287, 8, 8)) = 230;  // its middle at (299.5, 290.5)
  video::VideoWriter writer(video_, {.width = 960, .height = 720, .lossless = true, .grey = true});
  for (int i = 0; i < kFrames; ++i) writer.Write(frame, IrregularTime_s(i));
  writer.Finish();
  motion::MarkerRecording tracks = Leg();
  for (motion::MarkerSample& sample : tracks.markers[2].samples) sample.position = {298.5, 290.5};
  const cv::Mat picture = Overlay(960, 720, {tracks}).last;
  // In the corner below the leg: the third inset, behind the panel of 246 px and two insets of 120, 6 px between them;
  // an inset and its two lines of text are 160 px high, and 12 px stay free at the picture's edge.
  const cv::Point corner(12 + 246 + 6 + 2 * (120 + 6), 720 - 12 - 160);
  const double magnified = 120 / 24.0;
  const auto at = [&](double x_px, double y_px) {  // about the track's position
    const cv::Vec3b& p =
        picture.at<cv::Vec3b>(corner + cv::Point(cvRound(60 + x_px * magnified), cvRound(60 + y_px * magnified)));
    return (p[0] + p[1] + p[2]) / 3;
  };
  // The dot reaches from -3 to 5 px about the position, up and down 4 px; a pixel's width for interpolation.
  EXPECT_GT(at(4, 2), 190);
  EXPECT_LT(at(6, 2), 90);
  EXPECT_GT(at(-2, 2), 190);
  EXPECT_LT(at(-4, 2), 90);
  EXPECT_GT(at(2, 3), 190);
  EXPECT_LT(at(2, 5), 90);
}

TEST_F(OverlayVideoTest, AngleIsDrawnWithMotionOnly) {
  const motion::MarkerRecording tracks = Leg();
  const motion::LegMotion motion = Motion(tracks);
  const std::vector<motion::StsEvent> events = {{1, motion::StsEventKind::kOnset, 0, IrregularTime_s(0)}};
  // Between the shank's line and the thigh, up and left of the knee, at the arc's radius: 0.35 × 131 px.
  const Eigen::Vector2d knee = tracks.markers[1].samples[0].position;
  const double radius = 0.35 * std::hypot(20, 130), middle = -2.25;  // rad, image axes
  const cv::Point arc(cvRound(knee.x() + radius * std::cos(middle)), cvRound(knee.y() + radius * std::sin(middle)));
  const auto spread = [&](const cv::Mat& picture) {
    const cv::Vec3b& p = picture.at<cv::Vec3b>(arc);
    return std::max({p[0], p[1], p[2]}) - std::min({p[0], p[1], p[2]});
  };
  EXPECT_LT(spread(Overlay(960, 720, {tracks}).last), 20);
  EXPECT_GT(spread(Overlay(960, 720, {tracks, &motion, &events}).last), 80);
  const motion::LegMotion empty;
  const std::vector<motion::StsEvent> none;
  EXPECT_LT(spread(Overlay(960, 720, {tracks, &empty, &none}).last), 20);
}

TEST_F(OverlayVideoTest, WideVideosAreScaledDownAndTheDrawingWithThem) {
  const motion::MarkerRecording tracks = Leg(2);
  const Decoded decoded = Overlay(1920, 1440, {tracks}, {.max_width_px = 960});
  EXPECT_EQ(decoded.info.width, 960);
  EXPECT_EQ(decoded.info.height, 720);
  EXPECT_EQ(ArmsOfCross(decoded.last, tracks.markers[2].samples[0].position / 2), 4);
}

TEST_F(OverlayVideoTest, OddSidesBecomeEven) {
  const std::string command =
      "ffmpeg -y -v error -nostdin -f lavfi -i color=gray:size=641x481:rate=30:duration=0.4 "
      "-c:v libx264 -pix_fmt yuv444p '" +
      video_.string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const motion::MarkerRecording tracks = Leg();
  const Decoded decoded = Overlay(641, 481, {tracks});
  EXPECT_EQ(decoded.info.width % 2 + decoded.info.height % 2, 0);
  EXPECT_NEAR(decoded.info.width, 641, 1);
  EXPECT_NEAR(decoded.info.height, 481, 1);
  EXPECT_EQ(decoded.time_s.size(), std::size_t{kFrames});
}

// Stored 720×960, shown 960×720: the tracks are in the picture as shown.
TEST_F(OverlayVideoTest, TurnedVideosAreShownUpright) {
  const auto stored = folder_ / "stored.mp4";
  WriteGreyVideo(stored, 720, 960);
  TurnFilm(stored, 90, video_);
  const motion::MarkerRecording tracks = Leg();
  const Decoded decoded = Overlay(0, 0, {tracks});
  EXPECT_EQ(decoded.info.width, 960);
  EXPECT_EQ(decoded.info.height, 720);
  EXPECT_EQ(decoded.info.rotation_deg, 0);
  for (const motion::MarkerTrack& marker : tracks.markers)
    EXPECT_EQ(ArmsOfCross(decoded.last, marker.samples[0].position), 4) << marker.name;
}

// The whole way through the preview: a colour comes out as the reader's own BGR of the recording has it.
TEST_F(OverlayVideoTest, ColoursOfTheRecordingStay) {
  video::VideoWriter writer(video_, {.width = 640, .height = 480});
  const cv::Scalar colour(40, 90, 200);
  for (int i = 0; i < kFrames; ++i) writer.Write(cv::Mat(480, 640, CV_8UC3, colour), i / 30.0);
  writer.Finish();
  const motion::MarkerRecording tracks = Leg();
  const cv::Vec3b p = Overlay(640, 480, {tracks}).last.at<cv::Vec3b>(400, 600);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(p[c], colour[c], 5);  // two encodings, 8 bits of YUV each
}

TEST_F(OverlayVideoTest, FramesBesideTheTracksAreShownAsTheyAre) {
  motion::MarkerRecording tracks = Leg();
  for (std::int64_t& frame : tracks.frame) frame += 1000;
  const cv::Mat picture = Overlay(960, 720, {tracks}).last;
  EXPECT_EQ(ArmsOfCross(picture, tracks.markers[2].samples[0].position), 0);
}

TEST_F(OverlayVideoTest, UnwritableOutputIsAnErrorWithoutAFile) {
  WriteGreyVideo(video_, 320, 240);
  const motion::MarkerRecording tracks = Leg();
  const auto out = folder_ / "absent" / "overlay.mp4";
  EXPECT_THROW(overlay::WriteOverlayVideo(video_, {tracks}, {.quiet = true}, out), Error);
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(OverlayVideoTest, TruncatedVideoLeavesNoFile) {
  WriteGreyVideo(video_, 320, 240);
  std::filesystem::resize_file(video_, std::filesystem::file_size(video_) - 40);
  const motion::MarkerRecording tracks = Leg();
  EXPECT_THROW(overlay::WriteOverlayVideo(video_, {tracks}, {.quiet = true}, out_), Error);
  EXPECT_FALSE(std::filesystem::exists(out_));
}

TEST_F(OverlayVideoTest, TracksInMillimetresAreRefused) {
  motion::MarkerRecording tracks = Leg();
  tracks.unit = motion::LengthUnit::kMm;
  WriteGreyVideo(video_, 320, 240);
  EXPECT_THROW(overlay::WriteOverlayVideo(video_, {tracks}, {.quiet = true}, out_), Error);
}

}  // namespace
}  // namespace lake
