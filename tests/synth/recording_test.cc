#include "lake/synth/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/video/image.h"
#include "lake/video/video_reader.h"
#include "synth/plain_scene.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

class Recording : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) /
              ("synth_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static synth::SceneOptions ShortScene() {
    synth::SceneOptions options = synth::CleanScene(8);
    options.duration_s = 0.25;
    return options;
  }

  // The largest difference between the file's frames and rendered ones; frames and time stamps must agree.
  double WorstDifference(const synth::Scene& scene, const fs::path& video) {
    const auto reader = video::VideoReader::Open(video);
    video::VideoFrame frame;
    double worst = 0;
    int count = 0;
    for (; reader->Read(frame); ++count) {
      EXPECT_NEAR(frame.time_s, scene.TimeS(count), 1e-9);
      worst = std::max(worst, cv::norm(frame.luma, scene.Render(count), cv::NORM_INF));
    }
    EXPECT_EQ(count, scene.Frames());
    return worst;
  }

  fs::path folder_;
};

TEST_F(Recording, LosslessVideoHoldsTheRenderedFramesToTheBit) {
  const synth::Scene scene(ShortScene());
  synth::WriteRecording(scene, folder_, {.lossless = true});
  EXPECT_EQ(WorstDifference(scene, folder_ / "video.mp4"), 0);
}

TEST_F(Recording, LossyVideoIsClose) {
  const synth::Scene scene(ShortScene());
  synth::WriteRecording(scene, folder_, {.crf = 17});
  EXPECT_LT(WorstDifference(scene, folder_ / "video.mp4"), 40);
}

TEST_F(Recording, JitteredTimeStampsThatDoNotStartAtZeroAreKept) {
  synth::SceneOptions options = ShortScene();
  options.start_s = 1.25;
  options.time_jitter = 0.3;
  const synth::Scene scene(options);
  EXPECT_EQ(scene.TimeS(0), 1.25);
  synth::WriteRecording(scene, folder_, {.lossless = true});
  EXPECT_EQ(WorstDifference(scene, folder_ / "video.mp4"), 0);
}

TEST_F(Recording, PicturesHoldTheRenderedFrames) {
  synth::SceneOptions options = ShortScene();
  options.duration_s = 0.05;
  const synth::Scene scene(options);
  synth::WriteRecording(scene, folder_, {.pictures = true});
  EXPECT_FALSE(fs::exists(folder_ / "video.mp4"));
  for (int frame = 0; frame < scene.Frames(); ++frame)
    EXPECT_EQ(cv::norm(video::ReadImage(folder_ / fmt::format("frames/{:05d}.png", frame), false), scene.Render(frame),
                       cv::NORM_INF),
              0);
}

TEST_F(Recording, TruthHasTheColumnsOfTheInterfaceAndReadsBack) {
  synth::SceneOptions options = ShortScene();
  options.motion.exo_knee_mm = Eigen::Vector2d(25, 30);
  const synth::Scene scene(options);
  synth::WriteRecording(scene, folder_, {});
  const CsvTable csv = CsvTable::Read(folder_ / "truth.csv");
  const std::vector<std::string> start(csv.Header().begin(), csv.Header().begin() + 8);
  EXPECT_THAT(start, ::testing::ElementsAre("frame", "time_s", "ankle_x_px", "ankle_y_px", "ankle_visible",
                                            "ankle_x_mm", "ankle_y_mm", "knee_x_px"));
  EXPECT_EQ(csv.Header()[2 + 5 * 5], "knee_deg");
  ASSERT_EQ(csv.Rows(), 15u);
  const synth::FrameTruth truth = scene.Truth(7);
  EXPECT_EQ(csv.RequiredNumber(7, csv.Column("time_s")), truth.time_s);
  EXPECT_EQ(csv.RequiredNumber(7, csv.Column("exo_knee_y_px")), truth.markers[4].px.y());
  EXPECT_EQ(csv.RequiredNumber(7, csv.Column("knee_deg")), truth.knee_deg);
  EXPECT_EQ(csv.RequiredNumber(7, csv.Column("hip_visible")), 1);
  const synth::MotionTable again = synth::ReadMotionTable(folder_ / "truth.csv");
  EXPECT_EQ(again.names, scene.Motion().Names());
}

TEST_F(Recording, CameraFileIsTheScenesCamera) {
  synth::SceneOptions options = synth::HardScene(2);
  options.duration_s = 0.02;
  const synth::Scene scene(options);
  synth::WriteRecording(scene, folder_, {});
  const camera::CameraProfile read = camera::ReadCameraProfile(folder_ / "camera.yaml");
  const synth::MarkerTruth hip = scene.Truth(0).markers[2];
  EXPECT_LT((camera::PixelFromPlane(read.camera, *read.camera_from_plane, hip.mm) - hip.px).norm(), 1e-6);
}

}  // namespace
}  // namespace lake
