// The lens models beyond k1 k2 p1 p2 k3, against OpenCV's own functions; cameras at another size; readout.
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/calib3d.hpp>

#include "lake/camera/camera.h"
#include "lake/core/error.h"
#include "temporary_folder.h"

namespace lake {
namespace {

struct LensFile {
  const char* name;
  std::vector<double> coefficients;
  bool fisheye = false;
};

const std::vector<LensFile> kLensFiles = {
    {"4", {-0.31, 0.12, 7e-4, -5e-4}},
    {"5", {-0.31, 0.12, 7e-4, -5e-4, -0.02}},
    {"8", {0.4, 0.05, 7e-4, -5e-4, 0.002, 0.72, 0.1, 0.004}},
    {"12", {0.4, 0.05, 7e-4, -5e-4, 0.002, 0.72, 0.1, 0.004, 1e-3, -4e-4, 6e-4, 2e-4}},
    {"14", {0.4, 0.05, 7e-4, -5e-4, 0.002, 0.72, 0.1, 0.004, 1e-3, -4e-4, 6e-4, 2e-4, 0.02, -0.03}},
    {"fisheye", {0.03, -0.012, 0.004, -0.0006}, true}};

camera::CameraProfile Read(const TemporaryFolder& folder, const LensFile& lens, const char* key) {
  std::ofstream file(folder / "camera.yaml");
  file << "%YAML:1.0\n---\nimage_width: 1280\nimage_height: 720\n"
       << "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
       << "   data: [ 700., 0., 645., 0., 705., 352., 0., 0., 1. ]\n"
       << "distortion_coefficients: !!opencv-matrix\n   rows: " << lens.coefficients.size()
       << "\n   cols: 1\n   dt: d\n   data: [ " << fmt::format("{:.8f}", fmt::join(lens.coefficients, ", ")) << " ]\n";
  if (lens.fisheye) file << key;
  file.close();
  return camera::ReadCameraProfile(folder / "camera.yaml");
}

TEST(Lens, EveryModelOfOpenCvProjectsAsThereAndIsInverted) {
  const TemporaryFolder folder;
  const cv::Matx33d matrix(700, 0, 645, 0, 705, 352, 0, 0, 1);
  for (const LensFile& lens : kLensFiles)
    for (const char* key : {"distortion_model: fisheye\n", "fisheye_model: 1\n"}) {
      const camera::Camera camera = Read(folder, lens, key).camera;
      int seen = 0;
      for (double x = -0.85; x <= 0.86; x += 0.17)
        for (double y = -0.45; y <= 0.46; y += 0.15) {
          const std::vector<cv::Point3d> point = {{1000 * x, 1000 * y, 1000}};
          std::vector<cv::Point2d> pixel;
          if (lens.fisheye)
            cv::fisheye::projectPoints(point, pixel, cv::Vec3d(), cv::Vec3d(), matrix, lens.coefficients);
          else
            cv::projectPoints(point, cv::Vec3d(), cv::Vec3d(), matrix, lens.coefficients, pixel);
          const Eigen::Vector2d expected(pixel[0].x, pixel[0].y);
          EXPECT_LT((camera::Project(camera, {1000 * x, 1000 * y, 1000}) - expected).norm(), 1e-6) << lens.name;
          if (expected.x() < 0 || expected.y() < 0 || expected.x() > 1279 || expected.y() > 719) continue;
          EXPECT_LT((camera::RayFromPixel(camera, expected).head<2>() - Eigen::Vector2d(x, y)).norm(), 1e-8)
              << lens.name << " at " << x << ", " << y;
          ++seen;
        }
      EXPECT_GT(seen, 50) << lens.name;
    }
}

TEST(Lens, PositionsInThePlaneCarryTheirDerivatives) {
  const TemporaryFolder folder;
  camera::PlanePose pose = camera::PlanePose::Identity();
  pose.linear() = Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitX()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(-300, 400, 2500);
  for (const LensFile& lens : kLensFiles) {
    const camera::Camera camera = Read(folder, lens, "fisheye_model: 1\n").camera;
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(200, 150), Eigen::Vector2d(900, 600)}) {
      const camera::PlanePoint point = camera::PlanePointFromPixel(camera, pose, pixel);
      EXPECT_LT((camera::PixelFromPlane(camera, pose, point.position_mm) - pixel).norm(), 1e-7) << lens.name;
      for (int axis = 0; axis < 2; ++axis) {
        constexpr double kStep = 0.01;
        const Eigen::Vector2d moved = camera::PlaneFromPixel(camera, pose, pixel + kStep * Eigen::Vector2d::Unit(axis));
        EXPECT_LT(((moved - point.position_mm) / kStep - point.mm_per_px.col(axis)).norm(), 1e-2) << lens.name;
      }
    }
  }
}

TEST(Lens, WhatIsWrittenReadsBack) {
  const TemporaryFolder folder;
  for (const LensFile& lens : kLensFiles) {
    camera::CameraProfile profile = Read(folder, lens, "fisheye_model: 1\n");
    profile.readout_s = 0.0125;
    camera::WriteCameraProfile(folder / "again.yaml", profile);
    const camera::CameraProfile again = camera::ReadCameraProfile(folder / "again.yaml");
    EXPECT_EQ(again.camera.distortion, profile.camera.distortion) << lens.name;
    EXPECT_EQ(again.camera.more, profile.camera.more) << lens.name;
    EXPECT_EQ(again.camera.model, profile.camera.model) << lens.name;
    EXPECT_EQ(again.readout_s, 0.0125);
  }
}

TEST(Lens, ACameraIsTheSameAtAnotherSizeOfTheSameAspect) {
  const TemporaryFolder folder;
  const camera::Camera camera = Read(folder, kLensFiles[1], "").camera;  // 1280 x 720
  for (const auto& [width, height] : {std::pair{1920, 1080}, {640, 360}, {854, 480}, {3840, 2160}}) {
    const std::optional<camera::Camera> scaled = camera::CameraAtSize(camera, width, height);
    ASSERT_TRUE(scaled) << width;
    // The picture's corners are the pixels' outer edges.
    const auto scale = [width = width, height = height](const Eigen::Vector2d& p) {
      return Eigen::Vector2d((p.x() + 0.5) * width / 1280 - 0.5, (p.y() + 0.5) * height / 720 - 0.5);
    };
    const Eigen::Vector3d point(300, -150, 1000);
    EXPECT_LT((camera::Project(*scaled, point) - scale(camera::Project(camera, point))).norm(), 1e-9) << width;
  }
  EXPECT_FALSE(camera::CameraAtSize(camera, 720, 1280));
  EXPECT_FALSE(camera::CameraAtSize(camera, 640, 480));
}

}  // namespace
}  // namespace lake
