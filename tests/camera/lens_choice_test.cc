// Strong lenses: which model is chosen, and how well it predicts.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "board_scene.h"
#include "lake/camera/calibration.h"
#include "lake/camera/calibration_quality.h"
#include "lake/core/error.h"

namespace lake {
namespace {

const camera::Board kBoard = camera::ParseBoard("chessboard:9x6:25");

// As of an action camera: half of the picture's angle is compressed away.
camera::Camera Fisheye() {
  camera::Camera camera = {1280, 720, 560, 558, 645, 352, {0.02, -0.015, 0.008, -0.002, 0}};
  camera.model = camera::LensModel::kFisheye;
  return camera;
}

std::vector<camera::BoardView> RecordThrough(const camera::Camera& camera, int views, double sigma_px,
                                             std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<camera::BoardView> recording;
  for (int i = 0; i < views; ++i) {
    recording.push_back(scene::NoisyView(camera, kBoard, scene::RandomPose(camera, kBoard, random), sigma_px, random));
    recording.back().name = fmt::format("view {}", i);
  }
  return recording;
}

TEST(LensChoice, APolynomialLensStaysOneAndAFisheyeIsFound) {
  for (const std::uint64_t seed : {1u}) {
    const camera::Camera mild = scene::Lens(), strong = Fisheye();
    EXPECT_EQ(camera::ChooseLens(kBoard, RecordThrough(mild, 20, 0.1, seed), 1280, 720).lens,
              camera::LensFamily::kPolynomial);
    const std::vector<camera::BoardView> views = RecordThrough(strong, 20, 0.1, 10 + seed);
    const camera::LensChoice choice = camera::ChooseLens(kBoard, views, 1280, 720);
    EXPECT_NE(choice.lens, camera::LensFamily::kPolynomial);
    camera::CalibrationOptions options;
    options.lens = choice.lens;
    const camera::CalibrationResult result = camera::CalibrateCamera(kBoard, views, 1280, 720, options);
    ASSERT_TRUE(result.summary.usable);
    const double before =
        camera::CompareCameras(strong, camera::CalibrateCamera(kBoard, views, 1280, 720).camera).rms_px;
    const double after = camera::CompareCameras(strong, result.camera).rms_px;
    RecordProperty(fmt::format("seed_{}", seed), fmt::format("{}: {:.3f} px RMS from the truth; k1..k3: {:.3f}",
                                                             camera::ToString(choice.lens), after, before));
    EXPECT_LT(after, 0.15) << seed;
    EXPECT_LT(after, before) << seed;
    EXPECT_NEAR(result.rms_px, 0.1 * std::sqrt(2.0), 0.01);
  }
}

TEST(LensChoice, FisheyeParametersComeOutWithTheirErrors) {
  const camera::Camera truth = Fisheye();
  camera::CalibrationOptions options;
  options.lens = camera::LensFamily::kFisheye;
  const camera::CalibrationResult result =
      camera::CalibrateCamera(kBoard, RecordThrough(truth, 20, 0.1, 5), 1280, 720, options);
  ASSERT_TRUE(result.summary.usable);
  EXPECT_EQ(result.camera.model, camera::LensModel::kFisheye);
  EXPECT_LT(std::abs(result.camera.fx - truth.fx), 4 * std::sqrt(result.covariance(0, 0)));
  EXPECT_LT(std::abs(result.camera.distortion[0] - truth.distortion[0]), 4 * std::sqrt(result.covariance(4, 4)));
  EXPECT_GT(result.covariance(4, 4), 0);
  options.fix_k3 = true;
  EXPECT_THROW(camera::CalibrateCamera(kBoard, RecordThrough(truth, 12, 0.1, 5), 1280, 720, options), UsageError);
}

TEST(LensChoice, CornersOfAStronglyBentBoardAreGoodInRenderedPictures) {
  camera::Camera lens = {480, 300, 240, 239, 242, 148, {0.02, -0.015, 0.008, -0.002, 0}};
  lens.model = camera::LensModel::kFisheye;
  std::mt19937_64 random(3);
  double square = 0;
  int corners = 0, seen = 0;
  scene::RenderOptions render;
  render.samples = 5;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Isometry3d pose = scene::RandomPose(lens, kBoard, random, 15);
    const auto view = camera::DetectBoard(scene::Render(lens, kBoard, pose, random, render), kBoard);
    if (!view) continue;
    ++seen;
    const std::vector<Eigen::Vector2d> truth = scene::CornerPixels(lens, kBoard, pose);
    double same = 0, turned = 0;  // a board without codes may be taken to stand on its head
    for (std::size_t c = 0; c < view->corner.size(); ++c, ++corners) {
      same += (view->pixel[c] - truth[c]).squaredNorm();
      turned += (view->pixel[c] - truth[truth.size() - 1 - c]).squaredNorm();
    }
    square += std::min(same, turned);
  }
  ASSERT_GE(seen, 2);
  EXPECT_LT(std::sqrt(square / corners), 0.1);
}

}  // namespace
}  // namespace lake
