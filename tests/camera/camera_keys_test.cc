#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <set>

#include "lake/camera/camera.h"
#include "lake/core/atomic_file.h"
#include "temporary_folder.h"

namespace lake {
namespace {

std::set<std::string> KeysOf(const std::string& text) {
  const cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
  const std::vector<std::string> keys = file.root().keys();
  return {keys.begin(), keys.end()};
}

std::set<std::string> Described(bool needed_alone) {
  std::set<std::string> keys;
  for (const camera::CameraKey& key : camera::CameraKeys())
    if (key.is_needed || !needed_alone) keys.insert(key.name);
  return keys;
}

TEST(CameraKeys, AreThoseThatACalibrationWrites) {
  const TemporaryFolder folder;
  camera::CameraProfile profile;
  profile.camera = {1280, 720, 1100, 1100, 639.5, 359.5, {}};
  profile.camera.model = camera::LensModel::kFisheye;
  profile.readout_s = 0.01;
  profile.uncertainty.emplace();
  profile.camera_from_plane = camera::PlanePose::Identity();
  profile.plane_uncertainty.emplace();
  camera::WriteCameraProfile(folder / "camera.yaml", profile);
  EXPECT_EQ(KeysOf(ReadTextFile(folder / "camera.yaml")), Described(false));
}

TEST(CameraKeys, TheTemplateIsACamera) {
  const TemporaryFolder folder;
  const std::string text = camera::CameraTemplate();
  EXPECT_EQ(KeysOf(text), Described(true));
  WriteTextFile(folder / "camera.yaml", text);
  const camera::CameraProfile profile = camera::ReadCameraProfile(folder / "camera.yaml");
  EXPECT_EQ(profile.camera.fx, 1100);
  EXPECT_FALSE(profile.camera_from_plane);
  // With what may be absent, of a lens as it is usual.
  std::string all = "%YAML:1.0\n---\n";
  for (const camera::CameraKey& key : camera::CameraKeys())
    if (std::string(key.name) != "distortion_model") all += std::string(key.name) + ": " + key.value + "\n";
  WriteTextFile(folder / "all.yaml", all);
  const camera::CameraProfile whole = camera::ReadCameraProfile(folder / "all.yaml");
  EXPECT_TRUE(whole.camera_from_plane && whole.uncertainty && whole.plane_uncertainty);
  EXPECT_EQ(whole.readout_s, 0.012);
}

}  // namespace
}  // namespace lake
