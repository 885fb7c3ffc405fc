// lake-calibrate as a user runs it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>

#include "board_scene.h"
#include "cli/program_run.h"
#include "lake/camera/camera.h"
#include "lake/core/atomic_file.h"
#include "lake/core/json.h"
#include "lake/video/image.h"

namespace lake {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

class CalibrateProgram : public testing::Test {
 protected:
  // Pictures of the board in many poses, named 00.png …
  void Photograph(int count) {
    std::mt19937_64 random(9);
    for (int i = 0; i < count; ++i) {
      const auto pose = scene::PoseWellInside(kSmallCamera, kBoard, random, 25);
      video::WriteImage(folder_ / fmt::format("{:02}.png", i),
                        scene::Render(kSmallCamera, kBoard, pose, random, {0.6, 1.5, 3}));
    }
  }

  void Refused(const std::string& arguments, int exit_code, const std::string& text) const {
    EXPECT_EQ(ExpectRefused(folder_, "lake-calibrate " + arguments, exit_code, text).ErrorLines(), 1);
  }

  TemporaryFolder folder_;
};

const std::string kCalibrate = "lake-calibrate *.png --board chessboard:9x6:25 --quiet -o camera ";

// 6x4 inner corners of 25 mm, square to a camera of 220 px at 300 mm; each pixel is the mean of four rays.
cv::Mat1b BoardSquareToTheCamera() {
  cv::Mat1b picture(180, 240);
  const auto level = [](double u, double v) {
    const double x = (u - 120) / 220 * 300 / 25 + 3.5, y = (v - 90) / 220 * 300 / 25 + 2.5;
    const bool on_board = x >= 0 && x < 7 && y >= 0 && y < 5;
    return on_board && (static_cast<int>(x) + static_cast<int>(y)) % 2 == 0 ? 30 : 220;
  };
  for (int v = 0; v < picture.rows; ++v)
    for (int u = 0; u < picture.cols; ++u)
      picture(v, u) = static_cast<uchar>((level(u - 0.25, v - 0.25) + level(u - 0.25, v + 0.25) +
                                          level(u + 0.25, v - 0.25) + level(u + 0.25, v + 0.25)) /
                                         4);
  return picture;
}

// The same picture five times: focal length and distance are one, and Ceres, which finds no covariance, warns of it in
// its own log.
TEST_F(CalibrateProgram, SaysNothingInTheWordsOfALibrary) {
  for (int i = 0; i < 5; ++i) video::WriteImage(folder_ / fmt::format("{}.png", i), BoardSquareToTheCamera());
  Refused("*.png --board chessboard:6x4:25 --quiet -o camera", 1, "lake-calibrate: the views do not fix the camera");
}

TEST_F(CalibrateProgram, FromPicturesToThePlane) {
  Photograph(12);
  video::WriteImage(folder_ / "99.png", cv::Mat1b(480, 640, uchar{90}));
  const Outcome run = Done(folder_, kCalibrate + "--fix-k3 --json");
  EXPECT_THAT(run.err, HasSubstr("no board seen in 1 of 13 images, left out: 99.png"));
  const Json summary = Json::parse(run.out);
  for (const char* key :
       {"program", "version", "command", "options", "inputs", "warnings", "rms_px", "inlier_rms_px", "worst_view",
        "worst_corner", "outliers", "coverage", "cross_validation", "standard_deviations", "without_board"})
    EXPECT_TRUE(summary.contains(key)) << key;
  EXPECT_EQ(summary["inputs"].size(), 13u);
  for (const char* file : {"camera.yaml", "summary.json", "residuals.csv", "residuals.png", "cross_validation.png"})
    EXPECT_TRUE(fs::exists(folder_ / "camera" / file)) << file;
  const camera::CameraProfile profile = camera::ReadCameraProfile(folder_ / "camera/camera.yaml");
  ASSERT_TRUE(profile.uncertainty);
  EXPECT_LT(std::abs(profile.camera.fx - kSmallCamera.fx), 5 * profile.uncertainty->intrinsics_sd[0]);
  EXPECT_EQ(profile.uncertainty->rms_px, summary["rms_px"].get<double>());

  const Json plane = DoneJson(folder_,
                              "lake-calibrate plane 03.png --camera camera/camera.yaml --board chessboard:9x6:25 "
                              "-o camera --json");
  EXPECT_EQ(plane["options"]["board"], "chessboard:9x6:25");
  const camera::CameraProfile with_plane = camera::ReadCameraProfile(folder_ / "camera/camera.yaml");
  EXPECT_TRUE(with_plane.camera_from_plane && with_plane.plane_uncertainty && with_plane.uncertainty);
  EXPECT_EQ(with_plane.camera.fx, profile.camera.fx);
}

// Ten pictures, one of them squeezed, as of a bent board.
TEST_F(CalibrateProgram, AViewThatDoesNotFitIsLeftOutByNameAndTheLensModelIsSaid) {
  Photograph(10);
  cv::Mat squeezed = video::ReadImage(folder_ / "07.png", false);
  cv::resize(squeezed(cv::Rect(0, 0, 640, 400)).clone(), squeezed, {640, 480});
  video::WriteImage(folder_ / "07.png", squeezed);
  const Outcome run = Done(folder_, kCalibrate);
  EXPECT_THAT(run.err, HasSubstr("07.png does not fit the other views"));
  EXPECT_THAT(run.out, HasSubstr("lens model "));
  const Json summary = ReadJsonFile(folder_ / "camera/summary.json");
  EXPECT_EQ(summary["views"].size(), 9u);
  EXPECT_EQ(summary["lens"]["chosen"], true);
  EXPECT_TRUE(summary["lens"]["left_out_error_px"].contains("polynomial"));
  EXPECT_LT(summary["rms_px"].get<double>(), 0.1);  // a corner is found within 0.043 px
}

// Each picture bent in its own way: a camera can be fitted to anything, and is none then.
TEST_F(CalibrateProgram, WhatNoLensExplainsIsNoCamera) {
  Photograph(6);
  for (int i = 0; i < 6; ++i) {
    const fs::path file = folder_ / fmt::format("{:02}.png", i);
    const cv::Mat flat = video::ReadImage(file, false);
    cv::Mat1f x(flat.size()), y(flat.size());
    for (int v = 0; v < flat.rows; ++v)
      for (int u = 0; u < flat.cols; ++u) {
        x(v, u) = static_cast<float>(u + 22 * std::sin(v / 45.0 + i));
        y(v, u) = static_cast<float>(v + 22 * std::sin(u / 45.0 + 2 * i));
      }
    cv::Mat bent;
    cv::remap(flat, bent, x, y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    video::WriteImage(file, bent);
  }
  ExpectRefused(folder_, kCalibrate, 1, "lake-calibrate: no camera explains the corners: RMS");
  EXPECT_FALSE(fs::exists(folder_ / "camera/camera.yaml"));
}

TEST_F(CalibrateProgram, BadInputIsOneLineAndTheRightExitCode) {
  Photograph(3);
  video::WriteImage(folder_ / "small.png", cv::Mat1b(240, 320, uchar{90}));
  camera::WriteCameraProfile(folder_ / "camera.yaml", {kSmallCamera, {}, {}, {}});
  camera::Camera other = kSmallCamera;
  other.image_width = 1280;
  camera::WriteCameraProfile(folder_ / "other.yaml", {other, {}, {}, {}});
  Refused("", 2, "no pictures given");
  Refused("00.png", 2, "no board given");
  Refused("00.png --board chess:9x6:25", 2, "board 'chess:9x6:25'");
  Refused("00.png --board chessboard:9x6:25 --loss huber", 2, "huber");
  Refused("--no-such-option", 2, "--no-such-option");
  Refused("none.png 00.png --board chessboard:9x6:25", 1, "none.png");
  Refused("00.png 01.png --board chessboard:9x6:25 --quiet", 1, "the board was given in 2 views; at least 3");
  Refused("00.png small.png --board chessboard:9x6:25 --quiet", 1, "small.png: it has 320x240");
  Refused("00.png 01.png --board chessboard:11x8:25 --quiet", 1, "seen in none of 2 images");
  Refused("plane 00.png --camera camera.yaml", 2, "either --board or --points");
  Refused("plane 00.png --camera other.yaml --board chessboard:9x6:25", 1,
          "calibrated at 1280x480 px, but 00.png has 640x480");
  Refused("plane 00.png --camera camera.yaml --points '1,2=3,4'", 2, "at least 4 points");
  Refused("plane 00.png --camera camera.yaml --points '10,10=0,0;9000,10=9,0;90,90=9,9;10,90=0,9'", 2,
          "outside the picture");
  Refused("plane 00.png --camera camera.yaml --points '10,10=0,0;90,10=9,0;90,90=9,9;10,90=0,9'", 1, "mirrored");
  Refused("plane 00.png --camera camera.yaml --points '10,10=0,0;90,10=1.2,0;90,90=1.2,0.9;10,90=0,0.9'", 2,
          "within 1.5 mm of each other");
  // Points in a line, two at one place: no word of Ceres' own log.
  for (const char* points :
       {"10,10=0,0;300,10=900,0;500,10=1800,0;600,10=2000,0", "10,400=0,0;10,400=0,0;500,60=1800,1000;600,400=2000,0"})
    Refused(fmt::format("plane 00.png --camera camera.yaml --points '{}'", points), 1, "do not span a plane");
  Refused("00.png --board chessboard:9x6:0.025", 2, "is it in m?");
  Refused("plane 00.png --camera none.yaml --board chessboard:9x6:25", 1, "none.yaml");
  Refused("board --board chessboard:9x6:90 --paper a4", 1, "does not fit on a4");
  Refused("board --board chessboard:9x6:25 --paper b5", 2, "--paper 'b5'");
}

}  // namespace
}  // namespace lake
