#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "camera_formats.h"
#include "lake/camera/camera.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::camera {
namespace {

template <int N>
Eigen::Matrix<double, N, 1> VectorAt(const Json& file, const char* key, const std::string& where) {
  return Eigen::Map<const Eigen::Matrix<double, N, 1>>(NumbersAt(file, key, where, N).data());
}

PlanePose ReadPlane(const Json& file, const std::string& where) {
  const Eigen::Vector3d rotation = VectorAt<3>(file, "plane_rvec", where);
  PlanePose pose = PlanePose::Identity();
  if (rotation.norm() > 0) pose.linear() = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
  pose.translation() = VectorAt<3>(file, "plane_tvec", where);
  if (!(pose.inverse().translation().z() > 0))
    throw Fail("{}: 'plane_rvec' and 'plane_tvec' put the camera behind the plane; its z must point towards the camera",
               where);
  constexpr double kNearest_mm = 50;  // in m, farther than any camera of a person
  if (const double distance_mm = pose.translation().norm(); distance_mm < kNearest_mm)
    throw Fail("{}: 'plane_tvec' puts the plane {} mm from the camera, where no person fits: is it in m, not mm?",
               where, SignificantText(distance_mm, 3));
  return pose;
}

// What only files of lake say.
void ReadOwnKeys(const Json& file, const std::string& where, CameraProfile& profile) {
  const auto has = [&](const char* key) { return FindKey(file, key) != nullptr; };
  if (has("rms_px")) {
    CameraUncertainty& uncertainty = profile.uncertainty.emplace();
    uncertainty.rms_px = NumberAt(file, "rms_px", where);
    uncertainty.intrinsics_sd = VectorAt<4>(file, "intrinsics_sd", where);
    Eigen::Map<Eigen::Matrix<double, 5, 1>>(uncertainty.distortion_sd.data()) =
        VectorAt<5>(file, "distortion_sd", where);
  }
  if (has("readout_s")) {
    profile.readout_s = NumberAt(file, "readout_s", where);
    constexpr double kLongest_s = 0.2;  // longer than any frame in which a motion could be followed
    if (std::abs(profile.readout_s) > kLongest_s)
      throw Fail("{}: 'readout_s' is {} s, not the time in which a picture is read ({} s at most)", where,
                 profile.readout_s, kLongest_s);
  }
  if (has("plane_rvec") || has("plane_tvec")) profile.camera_from_plane = ReadPlane(file, where);
  if (has("plane_rms_px"))
    profile.plane_uncertainty = {NumberAt(file, "plane_rms_px", where),
                                 VectorAt<3>(file, "plane_rotation_sd_rad", where),
                                 VectorAt<3>(file, "plane_translation_sd_mm", where)};
}

template <typename List>
cv::Mat Row(const List& values) {
  return cv::Mat(std::vector<double>(values.begin(), values.end()), true).t();
}

// As many as the model has.
cv::Mat Coefficients(const Camera& camera) {
  std::vector<double> values(camera.distortion.begin(), camera.distortion.end());
  if (camera.model == LensModel::kFisheye) values.resize(4);
  if (camera.model == LensModel::kBrownConrady && !camera.IsPlain())
    values.insert(values.end(), camera.more.begin(), camera.more.end());
  if (values.size() == 14 && std::all_of(values.begin() + 8, values.end(), [](double v) { return v == 0; }))
    values.resize(8);
  return cv::Mat(values, true).t();
}

constexpr const char* kEndings[] = {".yaml", ".yml", ".json", ".xml", ".toml", ".xcp", ".qca.txt"};

// Camera files that are not read, and the way out.
struct ForeignCamera {
  const char *ending, *what;
};
constexpr const char* kOfMotive =
    "a calibration of OptiTrack Motive, whose lens model is not published; film a board with this camera and run lake "
    "calibrate, or take fx, fy, cx, cy and k1, k2, k3 from Motive's camera API into a camera.yaml (lake calibrate "
    "--template)";
constexpr ForeignCamera kForeign[] = {
    {".cal", kOfMotive},
    {".mcal", kOfMotive},
    {".ini",
     "an oST file of ROS: rosrun camera_calibration_parsers convert FILE.ini camera.yaml makes one that is read"},
    {".pickle",
     "a camera of OpenCap in Python's own format: Pose2Sim's calibration converts it to TOML, which is read"},
    {".npz", "an archive of numpy: write its matrix and coefficients into a camera.yaml (lake calibrate --template)"}};

const ForeignCamera* FindForeign(const std::filesystem::path& path) {
  const auto* found = std::ranges::find(kForeign, cv::toLowerCase(path.extension().string()), &ForeignCamera::ending);
  return found == std::end(kForeign) ? nullptr : found;
}

}  // namespace

CameraProfile ReadCameraProfile(const std::filesystem::path& path, const std::string& view) {
  if (const ForeignCamera* foreign = FindForeign(path)) throw Fail("{}: is {}", path.string(), foreign->what);
  const Json file = ReadTree(path);
  CameraProfile profile = CameraOf(file, path, view);
  ReadOwnKeys(file, path.string(), profile);
  return profile;
}

bool IsCameraFile(const std::filesystem::path& path) {
  const std::string name = cv::toLowerCase(path.filename().string());
  return FindForeign(path) || std::ranges::any_of(kEndings, [&](const char* end) { return name.ends_with(end); });
}

void WriteCameraProfile(const std::filesystem::path& path, const CameraProfile& profile) {
  const Camera& camera = profile.camera;
  cv::FileStorage file(".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
  file << "image_width" << camera.image_width << "image_height" << camera.image_height;
  file << "camera_matrix" << cv::Mat(cv::Matx33d(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1));
  if (camera.model == LensModel::kFisheye)
    file << "distortion_model"
         << "fisheye";
  file << "distortion_coefficients" << Coefficients(camera);
  if (profile.readout_s != 0) file << "readout_s" << profile.readout_s;
  if (const auto& u = profile.uncertainty) {
    file << "rms_px" << u->rms_px << "intrinsics_sd" << Row(u->intrinsics_sd);
    file << "distortion_sd" << Row(u->distortion_sd);
  }
  if (profile.camera_from_plane) {
    const Eigen::AngleAxisd rotation(profile.camera_from_plane->linear());
    file << "plane_rvec" << Row(Eigen::Vector3d(rotation.angle() * rotation.axis()));
    file << "plane_tvec" << Row(profile.camera_from_plane->translation());
  }
  if (const auto& u = profile.plane_uncertainty) {
    file << "plane_rms_px" << u->rms_px << "plane_rotation_sd_rad" << Row(u->rotation_sd_rad);
    file << "plane_translation_sd_mm" << Row(u->translation_sd_mm);
  }
  WriteTextFile(path, file.releaseAndGetString());
}

}  // namespace lake::camera
