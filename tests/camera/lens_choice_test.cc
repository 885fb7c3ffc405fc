// Strong lenses: which model is chosen, and how well it predicts.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "board_scene.h"
#include "lake/camera/calibration.h"
#include "lake/camera/calibration_quality.h"
#include "lake/core/error.h"

namespace lake {
namespace {

// As of an action camera: half of the picture's angle is compressed away.
camera::Camera Fisheye() {
  camera::Camera camera = {1280, 720, 560, 558, 645, 352, {0.02, -0.015, 0.008, -0.002, 0}};
  camera.model = camera::LensModel::kFisheye;
  return camera;
}

TEST(LensChoice, APolynomialLensStaysOneAndAFisheyeIsFound) {
  const camera::Camera strong = Fisheye();
  EXPECT_EQ(camera::ChooseLens(kBoard, scene::NoisyViews(scene::Lens(), 20, 0.1, 1), 1280, 720).lens,
            camera::LensFamily::kPolynomial);
  const std::vector<camera::BoardView> views = scene::NoisyViews(strong, 20, 0.1, 11);
  camera::CalibrationOptions options;
  options.lens = camera::ChooseLens(kBoard, views, 1280, 720).lens;
  EXPECT_NE(options.lens, camera::LensFamily::kPolynomial);
  const camera::CalibrationResult result = camera::CalibrateCamera(kBoard, views, 1280, 720, options);
  ASSERT_TRUE(result.summary.usable);
  const double polynomial_px =
                   camera::CompareCameras(strong, camera::CalibrateCamera(kBoard, views, 1280, 720).camera).rms_px,
               chosen_px = camera::CompareCameras(strong, result.camera).rms_px;
  RecordProperty("from_the_truth", fmt::format("{}: {:.3f} px RMS; k1..k3: {:.3f}", camera::ToString(options.lens),
                                               chosen_px, polynomial_px));
  EXPECT_LT(chosen_px, 0.15);
  EXPECT_LT(chosen_px, polynomial_px);
  EXPECT_NEAR(result.rms_px, 0.1 * std::sqrt(2.0), 0.01);
}

TEST(LensChoice, FisheyeParametersComeOutWithTheirErrors) {
  const camera::Camera truth = Fisheye();
  camera::CalibrationOptions options;
  options.lens = camera::LensFamily::kFisheye;
  const camera::CalibrationResult result =
      camera::CalibrateCamera(kBoard, scene::NoisyViews(truth, 20, 0.1, 5), 1280, 720, options);
  ASSERT_TRUE(result.summary.usable);
  EXPECT_EQ(result.camera.model, camera::LensModel::kFisheye);
  EXPECT_LT(std::abs(result.camera.fx - truth.fx), 4 * std::sqrt(result.covariance(0, 0)));
  EXPECT_LT(std::abs(result.camera.distortion[0] - truth.distortion[0]), 4 * std::sqrt(result.covariance(4, 4)));
  EXPECT_GT(result.covariance(4, 4), 0);
  options.fix_k3 = true;
  EXPECT_THROW(camera::CalibrateCamera(kBoard, scene::NoisyViews(truth, 12, 0.1, 5), 1280, 720, options), UsageError);
}

TEST(LensChoice, CornersOfAStronglyBentBoardAreGoodInRenderedPictures) {
  camera::Camera lens = {480, 300, 240, 239, 242, 148, {0.02, -0.015, 0.008, -0.002, 0}};
  lens.model = camera::LensModel::kFisheye;
  std::mt19937_64 random(3);
  std::vector<Eigen::Vector2d> errors;
  int seen = 0;
  scene::RenderOptions render;
  render.samples = 5;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Isometry3d pose = scene::RandomPose(lens, kBoard, random, 15);
    const auto view = camera::DetectBoard(scene::Render(lens, kBoard, pose, random, render), kBoard);
    if (!view) continue;
    ++seen;
    for (const Eigen::Vector2d& error : scene::Errors(*view, scene::CornerPixels(lens, kBoard, pose)))
      errors.push_back(error);
  }
  ASSERT_GE(seen, 2);
  EXPECT_LT(scene::RmsPx(errors), 0.1);
}

}  // namespace
}  // namespace lake
