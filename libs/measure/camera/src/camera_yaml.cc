// YAML of ROS (sensor_msgs/CameraInfo, camera_calibration_parsers) and of kalibr (camchain.yaml).
#include "camera_formats.h"
#include "lake/core/error.h"
#include "lake/core/yaml.h"

namespace lake::camera {
namespace {

Eigen::Matrix3d MatrixOf(double fx, double fy, double cx, double cy, double skew = 0) {
  Eigen::Matrix3d matrix;
  matrix << fx, skew, cx, 0, fy, cy, 0, 0, 1;
  return matrix;
}

// A list, or the `data` of a matrix; empty where the key is absent.
std::vector<double> DataOf(YamlNode& node, const char* key) {
  std::optional<YamlNode> child = node.Child(key);
  if (!child) return {};
  if (child->IsMap()) return child->Numbers("data").value_or(std::vector<double>{});
  return node.Numbers(key).value_or(std::vector<double>{});
}

double NumberOf(YamlNode& node, const char* key, const std::filesystem::path& path) {
  const std::optional<double> number = node.Number(key);
  if (!number) throw Fail("{}: no key '{}'", path.string(), key);
  return *number;
}

}  // namespace

std::vector<CameraFacts> ReadRosCamera(const std::string& /*text*/, const std::filesystem::path& path) {
  YamlNode file = YamlNode::ReadFile(path);
  const std::vector<double> k = DataOf(file, "camera_matrix");
  if (k.size() != 9) throw Fail("{}: 'camera_matrix' has {} numbers, not 9", path.string(), k.size());
  return {{.name = file.Text("camera_name").value_or("camera"),
           .width_px = NumberOf(file, "image_width", path),
           .height_px = NumberOf(file, "image_height", path),
           .matrix = MatrixOf(k[0], k[4], k[2], k[5], k[1]),
           .model = file.Text("distortion_model").value_or(""),
           .coefficients = DataOf(file, "distortion_coefficients")}};
}

// Each camera is a map under its own name: cam0, cam1, …
std::vector<CameraFacts> ReadKalibrCameras(const std::string& /*text*/, const std::filesystem::path& path) {
  std::vector<CameraFacts> cameras;
  YamlNode file = YamlNode::ReadFile(path);
  for (auto& [name, camera] : file.Pairs()) {
    if (!camera.IsMap() || !camera.Has("intrinsics")) continue;
    const std::string where = fmt::format("{}: camera {}", path.string(), name);
    const std::string model = camera.Text("camera_model").value_or("pinhole");
    const std::vector<double> k = DataOf(camera, "intrinsics"), size = DataOf(camera, "resolution");
    if (size.size() != 2) throw Fail("{}: 'resolution' has {} numbers, not 2", where, size.size());
    const bool is_pinhole = model == "pinhole";
    if (is_pinhole && k.size() != 4) throw Fail("{}: 'intrinsics' has {} numbers, not 4", where, k.size());
    cameras.push_back({.name = name,
                       .width_px = size[0],
                       .height_px = size[1],
                       .matrix = is_pinhole ? MatrixOf(k[0], k[1], k[2], k[3]) : MatrixOf(1, 1, 0, 0),
                       .model = is_pinhole ? camera.Text("distortion_model").value_or("none") : model,
                       .coefficients = DataOf(camera, "distortion_coeffs")});
  }
  return cameras;
}

}  // namespace lake::camera
