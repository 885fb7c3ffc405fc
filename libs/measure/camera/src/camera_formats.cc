#include "camera_formats.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::camera {

// Each in its own source.
std::vector<CameraFacts> ReadTomlCameras(const std::string& text, const std::filesystem::path& path);
std::vector<CameraFacts> ReadViconCameras(const std::string& text, const std::filesystem::path& path);
std::vector<CameraFacts> ReadQualisysCameras(const std::string& text, const std::filesystem::path& path);
std::vector<CameraFacts> ReadKalibrCameras(const std::string& text, const std::filesystem::path& path);
std::vector<CameraFacts> ReadRosCamera(const std::string& text, const std::filesystem::path& path);

namespace {

// A program's files: recognised by their ending, or by what their text holds.
struct CameraFormat {
  const char *name, *ending, *mark;
  std::vector<CameraFacts> (*read)(const std::string& text, const std::filesystem::path& path);
};
constexpr CameraFormat kFormats[] = {{"Pose2Sim or caliscope", ".toml", "", ReadTomlCameras},
                                     {"Vicon", ".xcp", "<KeyFrame ", ReadViconCameras},
                                     {"Qualisys", "", "centerPointU", ReadQualisysCameras},
                                     {"kalibr", "", "intrinsics:", ReadKalibrCameras},
                                     {"ROS", "", "\ncamera_matrix:", ReadRosCamera}};

// What other programs call OpenCV's models.
struct LensName {
  std::string_view name;
  LensModel model;
};
constexpr LensName kLensNames[] = {{"", LensModel::kBrownConrady},
                                   {"brown_conrady", LensModel::kBrownConrady},
                                   {"plumb_bob", LensModel::kBrownConrady},
                                   {"rational_polynomial", LensModel::kBrownConrady},
                                   {"radtan", LensModel::kBrownConrady},
                                   {"none", LensModel::kBrownConrady},
                                   {"fisheye", LensModel::kFisheye},
                                   {"equidistant", LensModel::kFisheye},
                                   {"equi", LensModel::kFisheye}};

void SetLens(const std::string& model, const std::vector<double>& coefficients, const std::string& where,
             Camera& camera) {
  const auto* known = std::ranges::find(kLensNames, model, &LensName::name);
  if (known == std::end(kLensNames))
    throw Fail(
        "{}: its lens model '{}' has no counterpart here; plumb_bob (radtan), rational_polynomial and equidistant "
        "(fisheye) are read: calibrate with one of these, or by lake calibrate",
        where, model);
  camera.model = known->model;
  std::size_t count = coefficients.size();
  if (camera.model == LensModel::kFisheye) {
    while (count > 4 && coefficients[count - 1] == 0) --count;
    if (count > 4 || coefficients.size() < 4)
      throw Fail("{}: a fisheye has four distortion coefficients, not {}", where, coefficients.size());
  } else if (count != 0 && count != 2 && count != 4 && count != 5 && count != 8 && count != 12 && count != 14) {
    throw Fail("{}: {} distortion coefficients; k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [τx τy]]]] are needed", where,
               count);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(coefficients[i])) throw Fail("{}: a distortion coefficient is not finite", where);
    (i < 5 ? camera.distortion[i] : camera.more[i - 5]) = coefficients[i];
  }
}

}  // namespace

std::vector<double> NumbersOf(const std::string& text, std::size_t least, const std::string& where) {
  std::vector<double> numbers;
  for (const std::string& part : SplitText(text, ' ')) {
    if (part.empty()) continue;
    const std::optional<double> number = ParseNumber(part);
    if (!number) throw Fail("{}: '{}' is not a finite number", where, part);
    numbers.push_back(*number);
  }
  if (numbers.size() < least) throw Fail("{}: '{}' holds fewer than {} numbers", where, text, least);
  return numbers;
}

Camera CameraOf(const CameraFacts& facts, const std::string& where) {
  constexpr double kLargest_px = 1 << 16;
  Camera camera;
  for (const double size : {facts.width_px, facts.height_px})
    if (!(size >= 1 && size <= kLargest_px))
      throw Fail("{}: {}x{} is not the size of a picture", where, facts.width_px, facts.height_px);
  camera.image_width = static_cast<int>(std::lround(facts.width_px));
  camera.image_height = static_cast<int>(std::lround(facts.height_px));
  const Eigen::Matrix3d& k = facts.matrix;
  if (!k.allFinite() || !(k(0, 0) > 0) || !(k(1, 1) > 0))
    throw Fail("{}: a focal length is not positive: {} and {} px", where, k(0, 0), k(1, 1));
  if (k(0, 1) != 0) throw Fail("{}: a skew of {} px, which no model here has", where, k(0, 1));
  camera.fx = k(0, 0);
  camera.fy = k(1, 1);
  camera.cx = k(0, 2);
  camera.cy = k(1, 2);
  SetLens(facts.model, facts.coefficients, where, camera);
  return camera;
}

std::optional<CameraProfile> ReadForeignCamera(const std::filesystem::path& path, const std::string& text,
                                               const std::string& view) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending == ".cal" || ending == ".mcal")
    throw Fail(
        "{}: is a calibration of OptiTrack Motive, whose lens model is not published; film a board with this camera "
        "and "
        "run lake calibrate, or take fx, fy, cx, cy and k1, k2, k3 from Motive's camera API into a camera.yaml (lake "
        "calibrate --template)",
        path.string());
  if (text.starts_with("%YAML")) return std::nullopt;  // OpenCV's
  const auto* format = std::ranges::find_if(kFormats, [&](const CameraFormat& each) {
    return *each.ending && ending == each.ending ? true : *each.mark && text.find(each.mark) != text.npos;
  });
  if (format == std::end(kFormats)) return std::nullopt;
  std::vector<CameraFacts> cameras = format->read(text, path);
  std::vector<std::string> names;
  names.reserve(cameras.size());
  for (const CameraFacts& camera : cameras) names.push_back(camera.name);
  if (cameras.empty()) throw Fail("{}: a file of {} without a calibrated camera", path.string(), format->name);
  if (!view.empty()) std::erase_if(cameras, [&](const CameraFacts& camera) { return camera.name != view; });
  if (cameras.size() != 1)
    throw Fail("{}: holds the cameras {} of {}; choose one: lake convert {} camera.yaml --view {}", path.string(),
               fmt::join(names, ", "), format->name, path.filename().string(), names.front());
  CameraProfile profile;
  profile.camera = CameraOf(cameras.front(), fmt::format("{}: camera {}", path.string(), cameras.front().name));
  profile.warnings = cameras.front().warnings;
  return profile;
}

}  // namespace lake::camera
