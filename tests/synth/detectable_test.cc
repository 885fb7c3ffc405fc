// Renderings for the other detectors: ArUco markers that OpenCV reads, dark markers that are the darkest, and the
// exoskeleton.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "lake/camera/aruco_opencv.h"
#include "lake/synth/scene.h"

namespace lake {
namespace {

using Eigen::Vector2d;

class ArucoFacing : public ::testing::TestWithParam<motion::Facing> {};

TEST_P(ArucoFacing, MarkersAreReadWithTheirNumbersAtTheirPlaces) {
  synth::SceneOptions options = synth::HardScene(12);
  options.occlusions.clear();
  options.motion.facing = GetParam();
  options.marker_kind = synth::MarkerKind::kAruco;
  const synth::Scene scene(options);
  const auto dictionary = camera::PredefinedArucoDictionary(cv::aruco::DICT_4X4_50);
  for (const int frame : {0, 30, 300}) {
    const auto [corners, ids] = camera::DetectArucoMarkers(scene.Render(frame), dictionary);
    const synth::FrameTruth truth = scene.Truth(frame);
    int found = 0;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      ASSERT_LT(ids[i], 4);
      // Where the diagonals cross is the centre in any perspective.
      const cv::Point2f a = corners[i][0], d = corners[i][2] - a, b = corners[i][1], e = corners[i][3] - b;
      const float t = ((b - a).x * e.y - (b - a).y * e.x) / (d.x * e.y - d.y * e.x);
      const Vector2d centre(a.x + t * d.x, a.y + t * d.y);
      EXPECT_LT((centre - truth.markers[ids[i]].px).norm(), 1.0) << frame;  // the detector's corners are whole pixels
      ++found;
    }
    EXPECT_EQ(found, 4) << frame;
  }
}

INSTANTIATE_TEST_SUITE_P(Both, ArucoFacing, ::testing::Values(motion::Facing::kRight, motion::Facing::kLeft));

TEST(DarkMarkers, AreDarkerThanAllAroundThem) {
  synth::SceneOptions options = synth::CleanScene(5);
  options.bright_room = true;
  options.marker_level = 18;
  const synth::Scene scene(options);
  for (const int frame : {0, 120, 240}) {
    const cv::Mat picture = scene.RenderIdeal(frame);
    for (const synth::MarkerTruth& marker : scene.Truth(frame).markers) {
      const cv::Point centre(std::lround(marker.px.x()), std::lround(marker.px.y()));
      EXPECT_LT(picture.at<float>(centre), 25);
      for (const cv::Point& off : {cv::Point(12, 0), cv::Point(-12, 0), cv::Point(0, 12), cv::Point(0, -12)})
        EXPECT_GT(picture.at<float>(centre + off), 90);
    }
  }
}

TEST(Exoskeleton, LinksAreGreyBesideTheMarkersAndMarkersLieOnTop) {
  synth::SceneOptions options = synth::CleanScene(5);
  options.motion.exo_knee_mm = Vector2d(20, 35);
  options.exoskeleton = true;
  const synth::Scene with(options);
  options.exoskeleton = false;
  const synth::Scene without(options);
  for (const int frame : {0, 150}) {
    const cv::Mat a = with.RenderIdeal(frame), b = without.RenderIdeal(frame);
    EXPECT_GT(cv::norm(a, b, cv::NORM_INF), 40);
    for (const synth::MarkerTruth& marker : with.Truth(frame).markers) {
      const cv::Point centre(std::lround(marker.px.x()), std::lround(marker.px.y()));
      EXPECT_NEAR(a.at<float>(centre), options.marker_level, 0.02 * options.marker_level);
    }
  }
}

TEST(Room, BrightnessIsAFactorOnAllButTheMarkers) {
  synth::SceneOptions options = synth::CleanScene(5);
  const synth::Scene normal(options);
  options.brightness = 0.4;
  const synth::Scene dark(options);
  const cv::Mat a = normal.RenderIdeal(0), b = dark.RenderIdeal(0);
  EXPECT_NEAR(b.at<float>(50, 640) / a.at<float>(50, 640), 0.4, 1e-3);
  const synth::MarkerTruth knee = dark.Truth(0).markers[1];
  EXPECT_NEAR(b.at<float>(std::lround(knee.px.y()), std::lround(knee.px.x())), options.marker_level, 2);
}

TEST(Reflections, KeepClearOfTheMarkersAndAreBright) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    synth::SceneOptions options = synth::HardScene(seed);
    options.occlusions.clear();
    options.glint = false;
    options.flicker = 0;
    const synth::Scene with(options);
    options.reflections = 0;
    const synth::Scene without(options);
    cv::Mat bright = with.RenderIdeal(0) - without.RenderIdeal(0) > 60;
    EXPECT_GT(cv::countNonZero(bright), 4 * 20);
    for (int frame = 0; frame < with.Frames(); frame += 20)
      for (const synth::MarkerTruth& marker : with.Truth(frame).markers) {
        const cv::Rect near = cv::Rect(std::lround(marker.px.x()) - 20, std::lround(marker.px.y()) - 20, 41, 41) &
                              cv::Rect({}, bright.size());
        EXPECT_EQ(cv::countNonZero(bright(near)), 0) << seed << " " << frame;
      }
  }
}

}  // namespace
}  // namespace lake
