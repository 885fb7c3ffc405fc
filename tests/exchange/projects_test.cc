// Project files that lie over a video: Tracker's .trk and .trz, Kinovea's .kva; and DLTdv's tables.
#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "lake/core/atomic_file.h"
#include "lake/core/utf8.h"
#include "lake/exchange/formats.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

// In the image, from frame `first` at any time; both markers are seen in the last frame, which is what a project keeps.
exchange::PointRecording MakeImagePoints(std::int64_t first, double start_s, double rate_hz) {
  exchange::PointRecording points = MakePoints(exchange::PointSpace::kImage, 30, 3, 11);
  for (std::size_t i = 0; i < points.frame.size(); ++i) {
    points.frame[i] = first + static_cast<std::int64_t>(i);
    points.time_s[i] = start_s + static_cast<double>(i) / rate_hz;
  }
  return points;
}

void ExpectSameByFrame(const exchange::PointRecording& written, const exchange::PointRecording& read,
                       double time_tolerance_s) {
  ASSERT_EQ(written.points.size(), read.points.size());
  ASSERT_EQ(read.frame.size(), static_cast<std::size_t>(written.frame.back()) + 1);
  for (std::size_t i = 0; i < written.frame.size(); ++i) {
    const auto frame = static_cast<std::size_t>(written.frame[i]);
    EXPECT_NEAR(read.time_s[frame], written.time_s[i], time_tolerance_s);
    for (std::size_t p = 0; p < written.points.size(); ++p) {
      EXPECT_EQ(read.points[p].name, written.points[p].name);
      const Eigen::Vector3d &a = written.points[p].positions[i], &b = read.points[p].positions[frame];
      ASSERT_EQ(a.allFinite(), b.allFinite()) << frame;
      // Half a pixel is added and taken off again, which costs the last digits.
      EXPECT_TRUE(!a.allFinite() || (a - b).norm() < 1e-9);
    }
  }
}

TEST(TrackerProject, ReadsBackWithAxesScaleAndTimes) {
  const TemporaryFolder folder;
  for (const double rate_hz : {30.0, 59.94, 240.0})
    for (const std::int64_t first : {0, 17}) {
      exchange::PointRecording written = MakeImagePoints(first, 0.35 + static_cast<double>(first) / rate_hz, rate_hz);
      written.mm_per_px = 1.7;
      written.axes = exchange::ImageAxes{{320.25, 411}, -3.5};
      written.video = exchange::SourceVideo{"/video/a <b> & c.mp4", 1280, 720};
      exchange::WritePoints(folder / "a.trk", written);
      const exchange::PointRecording read = exchange::ReadPoints(folder / "a.trk");
      ExpectSameByFrame(written, read, 1e-9);
      EXPECT_NEAR(*read.mm_per_px, 1.7, 1e-12);
      EXPECT_NEAR((read.axes->origin_px - written.axes->origin_px).norm(), 0, 1e-9);
      EXPECT_EQ(read.axes->angle_deg, -3.5);
      EXPECT_TRUE(read.warnings.empty());
    }
}

// World from image as Tracker's ImageCoordSystem has it: image = origin + scale × R(angle) × world, with y down.
TEST(TrackerProject, AxesTurnAndScaleAsTrackerHasThem) {
  exchange::PointRecording points = MakeImagePoints(0, 0, 30);
  points.mm_per_px = 2.5;
  points.axes = exchange::ImageAxes{{100, 200}, 30};
  const double angle_rad = 30 / 57.29577951308232, px_per_mm = 0.4;
  const Eigen::Vector2d world(120, -45);
  points.points[0].positions[1] = {
      100 + px_per_mm * (std::cos(angle_rad) * world.x() - std::sin(angle_rad) * world.y()),
      200 - px_per_mm * (std::sin(angle_rad) * world.x() + std::cos(angle_rad) * world.y()), 0};
  const exchange::PointRecording plane = exchange::PointsInPlane(points);
  EXPECT_EQ(plane.space, exchange::PointSpace::kPlane);
  EXPECT_NEAR((plane.points[0].positions[1].head<2>() - world).norm(), 0, 1e-9);
  EXPECT_FALSE(plane.points[0].positions[3].allFinite());
}

TEST(TrackerProject, AnArchiveHoldsOne) {
  const TemporaryFolder folder;
  const exchange::PointRecording written = MakeImagePoints(0, 0, 50);
  exchange::WritePoints(folder / "a.trk", written);
  WriteZip(folder / "a.trz", "videos/a.trk", ReadTextFile(folder / "a.trk"));
  ExpectSameByFrame(written, exchange::ReadPoints(folder / "a.trz"), 1e-9);
  WriteZip(folder / "b.trz", "readme.txt", "nothing");
  EXPECT_THAT(MessageOf([&] { exchange::ReadPoints(folder / "b.trz"); }), testing::HasSubstr("no *.trk"));
  WriteFile(folder / "c.trz", "PK but no archive");
  EXPECT_THAT(MessageOf([&] { exchange::ReadPoints(folder / "c.trz"); }), testing::HasSubstr("not a zip archive"));
}

TEST(TrackerProject, AFrameNumberDoesNotAllocateWhatTheFileCannotHold) {
  const TemporaryFolder folder;
  exchange::WritePoints(folder / "a.trk", MakeImagePoints(0, 0, 50));
  std::string text = ReadTextFile(folder / "a.trk");
  for (std::size_t at = text.find("\"[29]\""); at != std::string::npos; at = text.find("\"[29]\""))
    text.replace(at, 6, "\"[9999999]\"");
  WriteFile(folder / "b.trk", text);
  EXPECT_THAT(MessageOf([&] { exchange::ReadPoints(folder / "b.trk"); }), testing::HasSubstr("9999999"));
}

TEST(TrackerProject, HoldsNoMillimetres) {
  const TemporaryFolder folder;
  EXPECT_THAT(
      MessageOf([&] { exchange::WritePoints(folder / "a.trk", MakePoints(exchange::PointSpace::kPlane, 5, 1, 1)); }),
      testing::HasSubstr("px"));
  EXPECT_FALSE(fs::exists(folder / "a.trk"));
}

TEST(KinoveaAnnotations, ReadBackWithScaleAndUnevenTimes) {
  const TemporaryFolder folder;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> jitter(-0.2, 0.2);
  for (const double rate_hz : {25.0, 59.94}) {
    exchange::PointRecording written = MakeImagePoints(4, 4 / rate_hz, rate_hz);
    for (std::size_t i = 1; i + 1 < written.time_s.size(); ++i) written.time_s[i] += jitter(random) / rate_hz;
    written.mm_per_px = 0.8;
    exchange::WritePoints(folder / "a.kva", written);
    const exchange::PointRecording read = exchange::ReadPoints(folder / "a.kva");
    ExpectSameByFrame(written, read, 1e-6);  // stamps are whole numbers, 100 000 a frame
    EXPECT_NEAR(*read.mm_per_px, 0.8, 1e-12);
  }
}

// As Kinovea 0.9.5 writes it, with what matters here.
std::string Kva(const std::string& head, const std::string& calibration, const std::string& points) {
  return "<?xml version=\"1.0\" encoding=\"utf-8\"?><KinoveaVideoAnalysis><FormatVersion>2.0</FormatVersion>"
         "<ImageSize>1920;1080</ImageSize>" +
         head + calibration + "<Tracks><Track id=\"3f\" name=\"knee\"><TimePosition>2002</TimePosition>" +
         "<Mode>Complete</Mode><TrackPointList Count=\"2\">" + points + "</TrackPointList>" +
         "<MainLabel Text=\"other\"/></Track></Tracks></KinoveaVideoAnalysis>";
}

const char* kKvaHead =
    "<AverageTimeStampsPerFrame>1001</AverageTimeStampsPerFrame><CaptureFramerate>29.97</CaptureFramerate>"
    "<UserFramerate>30</UserFramerate><FirstTimeStamp>1001</FirstTimeStamp>";

TEST(KinoveaAnnotations, AreUnderstood) {
  const TemporaryFolder folder;
  const std::string line =
      "<Calibration><CalibrationLine><Length>50</Length><Segment><A>10;20</A><B>40;60</B></Segment></CalibrationLine>"
      "<Unit Abbreviation=\"cm\">Centimeters</Unit></Calibration>";
  const exchange::PointRecording read = exchange::ReadPoints(
      WriteFile(folder / "a.kva",
                Kva(kKvaHead, line, "<TrackPoint>10.5;20.25;2002</TrackPoint><TrackPoint>11;21;4004;8</TrackPoint>")));
  ASSERT_EQ(read.time_s.size(), 4u);
  EXPECT_EQ(read.points[0].name, "knee");
  EXPECT_EQ(read.points[0].positions[1], Eigen::Vector3d(10, 19.75, 0));
  EXPECT_EQ(read.points[0].positions[3], Eigen::Vector3d(10.5, 20.5, 0));
  EXPECT_FALSE(read.points[0].positions[2].allFinite());
  EXPECT_NEAR(read.time_s[3], 3 / 29.97, 1e-12);
  EXPECT_NEAR(*read.mm_per_px, 10, 1e-12);  // 500 mm over 50 px
  const exchange::PointRecording plane =
      exchange::ReadPoints(WriteFile(folder / "b.kva", Kva(kKvaHead, "<Calibration><CalibrationPlane/></Calibration>",
                                                           "<TrackPoint>1;2;2002</TrackPoint>")));
  EXPECT_FALSE(plane.mm_per_px);
  EXPECT_THAT(plane.warnings, testing::ElementsAre(testing::HasSubstr("perspective")));
  const std::string broken = std::string(line).replace(line.find("40;60"), 5, "40");
  const exchange::PointRecording in_px =
      exchange::ReadPoints(WriteFile(folder / "c.kva", Kva(kKvaHead, broken, "<TrackPoint>1;2;2002</TrackPoint>")));
  EXPECT_FALSE(in_px.mm_per_px);
  EXPECT_THAT(in_px.warnings, testing::ElementsAre(testing::HasSubstr("calibration line has no readable")));
}

TEST(KinoveaAnnotations, ErrorsSayWhatIsWrong) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& text) {
    return MessageOf([&] { exchange::ReadPoints(WriteFile(folder / "e.kva", text)); });
  };
  const std::string point = "<TrackPoint>1;2;2002</TrackPoint>";
  EXPECT_THAT(message(""), testing::HasSubstr("not XML"));
  EXPECT_THAT(message("<a/>"), testing::HasSubstr("KinoveaVideoAnalysis"));
  EXPECT_THAT(message(Kva("", "", point)), testing::HasSubstr("AverageTimeStampsPerFrame"));
  EXPECT_THAT(message(Kva("<AverageTimeStampsPerFrame>1</AverageTimeStampsPerFrame>", "", point)),
              testing::HasSubstr("CaptureFramerate"));
  EXPECT_THAT(message(Kva(kKvaHead, "", "")), testing::HasSubstr("no track"));
  EXPECT_THAT(message(Kva(kKvaHead, "", "<TrackPoint>1;2</TrackPoint>")), testing::HasSubstr("x;y;timestamp"));
  EXPECT_THAT(message(Kva(kKvaHead, "", "<TrackPoint>1;b;2002</TrackPoint>")), testing::HasSubstr("'1;b;2002'"));
  EXPECT_THAT(message(Kva(kKvaHead, "", "<TrackPoint>1;2;-9002</TrackPoint>")), testing::HasSubstr("of the video"));
  EXPECT_THAT(message(Kva(kKvaHead, "", "<TrackPoint>1;2;9009009000</TrackPoint>")),
              testing::HasSubstr("such long video"));
}

TEST(Projects, AreUtf8WhateverTheVideosNameIs) {
  exchange::PointRecording points = MakeImagePoints(0, 0, 30);
  points.video = exchange::SourceVideo{"J\xFCrgen <&\"a\">.mp4", 640, 480};
  const TemporaryFolder folder;
  exchange::WritePoints(folder / "a.trk", points);
  exchange::WritePoints(folder / "a.kva", points);
  for (const char* name : {"a.trk", "a.kva"}) {
    const std::string text = ReadTextFile(folder / name);
    EXPECT_TRUE(IsUtf8(text)) << name;
    EXPECT_THAT(text, testing::HasSubstr("J\uFFFDrgen &lt;&amp;\"a\"&gt;")) << name;
  }
}

TEST(Dltdv, PointsOfOneCameraAndOfTwo) {
  const TemporaryFolder folder;
  const exchange::PointRecording one = exchange::ReadPoints(
      WriteFile(folder / "axypts.csv",
                "\xEF\xBB\xBFpt1_cam1_X,pt1_cam1_Y,pt2_cam1_X,pt2_cam1_Y\r\n1,1,NaN,NaN\r\n3.5,2,11,12\r\n"),
      {.rate_hz = 50});
  EXPECT_EQ(one.space, exchange::PointSpace::kImage);
  EXPECT_EQ(one.Find("pt1")->positions[0], Eigen::Vector3d(0, 0, 0));  // the first pixel is 1
  EXPECT_EQ(one.Find("pt1")->positions[1], Eigen::Vector3d(2.5, 1, 0));
  EXPECT_FALSE(one.Find("pt2")->positions[0].allFinite());
  EXPECT_EQ(one.time_s[1], 0.02);
  const exchange::PointRecording two = exchange::ReadPoints(
      WriteFile(folder / "b.csv", "pt1_cam1_X,pt1_cam1_Y,pt1_cam2_X,pt1_cam2_Y\n1,2,3,4\n"), {.rate_hz = 50});
  EXPECT_EQ(two.Find("pt1_cam2")->positions[0], Eigen::Vector3d(2, 3, 0));
}

TEST(Dltdv, ErrorsSayWhere) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& text, double rate_hz = 50) {
    return SaidOf(
        [&] { return exchange::ReadPoints(WriteFile(folder / "e.csv", text), {.rate_hz = rate_hz}).warnings; });
  };
  EXPECT_THAT(message("pt1_cam1_X,pt1_cam1_Y\n1,2\n", 0), testing::HasSubstr("--rate"));
  EXPECT_THAT(message("pt1_cam1_X,pt1_cam1_Y\n1,2,3\n"), testing::HasSubstr("e.csv:2"));
  EXPECT_THAT(message("pt1_cam1_X,pt1_cam1_Y\n1,b\n"),
              testing::AllOf(testing::HasSubstr("e.csv:2"), testing::HasSubstr("'b'")));
  EXPECT_THAT(message("pt1_cam1_X,pt2_cam1_Y\n1,2\n"), testing::HasSubstr("follows the x of pt1"));
  EXPECT_THAT(message("pt1_cam1_X\n1\n"), testing::HasSubstr("ptN_camM_X, ptN_camM_Y"));
}

}  // namespace
}  // namespace lake
