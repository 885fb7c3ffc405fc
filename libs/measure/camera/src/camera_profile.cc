#include <Eigen/LU>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <set>
#include <sstream>
#include <stdexcept>

#include "camera_formats.h"
#include "lake/camera/camera.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::camera {
namespace {

// One file being read, for messages.
struct Source {
  const cv::FileStorage& file;
  std::string name;

  // Old samples of OpenCV begin the words of their keys with capitals.
  cv::FileNode Node(const std::string& key) const {
    for (const cv::FileNode& node : file.root())
      if (cv::toLowerCase(node.name()) == key) return node;
    return {};
  }
  bool Has(const char* key) const { return !Node(key).empty(); }
};

// A matrix, or a plain list, of finite numbers.
cv::Mat1d ReadMatrix(const Source& source, const char* key) {
  const cv::FileNode node = source.Node(key);
  if (node.empty()) throw Fail("{}: no key '{}'", source.name, key);
  cv::Mat matrix;
  try {
    if (node.isSeq()) {
      std::vector<double> values;
      node >> values;
      matrix = cv::Mat(values, true);
    } else {
      node >> matrix;
    }
    if (matrix.empty() || matrix.dims != 2 || matrix.channels() != 1) throw Fail("");
    matrix.convertTo(matrix, CV_64F);
  } catch (const std::exception&) {
    throw Fail("{}: '{}' is not a matrix of numbers", source.name, key);
  }
  if (!cv::checkRange(matrix)) throw Fail("{}: '{}' holds a value that is not finite", source.name, key);
  return matrix;
}

template <int N>
Eigen::Matrix<double, N, 1> ReadVector(const Source& source, const char* key) {
  const cv::Mat1d matrix = ReadMatrix(source, key);
  if (matrix.total() != N || std::min(matrix.rows, matrix.cols) != 1)
    throw Fail("{}: '{}' is {}x{}, not {} numbers", source.name, key, matrix.rows, matrix.cols, N);
  return Eigen::Map<const Eigen::Matrix<double, N, 1>>(matrix.ptr<double>());
}

double ReadNumber(const Source& source, const char* key) {
  const cv::FileNode node = source.Node(key);
  if (!node.isReal() && !node.isInt()) throw Fail("{}: no number '{}'", source.name, key);
  const double value = static_cast<double>(node);
  if (!std::isfinite(value)) throw Fail("{}: '{}' is not finite", source.name, key);
  return value;
}

int ReadSize(const Source& source, const char* key) {
  if (!source.Node(key).isInt()) throw Fail("{}: no whole number '{}'", source.name, key);
  const int size = static_cast<int>(source.Node(key));
  if (size <= 0 || size > 1 << 16) throw Fail("{}: '{}' is {}, not the size of a picture", source.name, key, size);
  return size;
}

Camera ReadCamera(const Source& source) {
  CameraFacts facts;
  facts.width_px = ReadSize(source, "image_width");
  facts.height_px = ReadSize(source, "image_height");
  const cv::Mat1d k = ReadMatrix(source, "camera_matrix");
  if (k.rows != 3 || k.cols != 3) throw Fail("{}: 'camera_matrix' is {}x{}, not 3x3", source.name, k.rows, k.cols);
  if (k(1, 0) != 0 || k(2, 0) != 0 || k(2, 1) != 0 || k(2, 2) != 1)
    throw Fail("{}: 'camera_matrix' must be [fx 0 cx; 0 fy cy; 0 0 1]", source.name);
  facts.matrix << k(0, 0), k(0, 1), k(0, 2), 0, k(1, 1), k(1, 2), 0, 0, 1;
  const cv::Mat1d d = ReadMatrix(source, "distortion_coefficients");
  if (std::min(d.rows, d.cols) != 1)
    throw Fail("{}: 'distortion_coefficients' is {}x{}, not a list", source.name, d.rows, d.cols);
  facts.coefficients.assign(d.begin(), d.end());
  const cv::FileNode model = source.Node("distortion_model"), flag = source.Node("fisheye_model");
  facts.model = flag.isInt() && static_cast<int>(flag) != 0 ? "fisheye" : "";
  if (!model.empty()) facts.model = model.isString() ? static_cast<std::string>(model) : "?";
  return CameraOf(facts, source.name);
}

PlanePose ReadPlane(const Source& source) {
  const Eigen::Vector3d rotation = ReadVector<3>(source, "plane_rvec");
  PlanePose pose = PlanePose::Identity();
  if (rotation.norm() > 0) pose.linear() = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
  pose.translation() = ReadVector<3>(source, "plane_tvec");
  if (!(pose.inverse().translation().z() > 0))
    throw Fail("{}: 'plane_rvec' and 'plane_tvec' put the camera behind the plane; its z must point towards the camera",
               source.name);
  constexpr double kNearest_mm = 50;  // in m, farther than any camera of a person
  if (const double distance_mm = pose.translation().norm(); distance_mm < kNearest_mm)
    throw Fail("{}: 'plane_tvec' puts the plane {} mm from the camera, where no person fits: is it in m, not mm?",
               source.name, SignificantText(distance_mm, 3));
  return pose;
}

CameraProfile ReadProfile(const Source& source) {
  CameraProfile profile;
  profile.camera = ReadCamera(source);
  if (source.Has("rms_px")) {
    CameraUncertainty& uncertainty = profile.uncertainty.emplace();
    uncertainty.rms_px = ReadNumber(source, "rms_px");
    uncertainty.intrinsics_sd = ReadVector<4>(source, "intrinsics_sd");
    Eigen::Map<Eigen::Matrix<double, 5, 1>>(uncertainty.distortion_sd.data()) = ReadVector<5>(source, "distortion_sd");
  }
  if (source.Has("readout_s")) {
    profile.readout_s = ReadNumber(source, "readout_s");
    constexpr double kLongest_s = 0.2;  // longer than any frame in which a motion could be followed
    if (std::abs(profile.readout_s) > kLongest_s)
      throw Fail("{}: 'readout_s' is {} s, not the time in which a picture is read ({} s at most)", source.name,
                 profile.readout_s, kLongest_s);
  }
  if (source.Has("plane_rvec") || source.Has("plane_tvec")) profile.camera_from_plane = ReadPlane(source);
  if (source.Has("plane_rms_px"))
    profile.plane_uncertainty = {ReadNumber(source, "plane_rms_px"), ReadVector<3>(source, "plane_rotation_sd_rad"),
                                 ReadVector<3>(source, "plane_translation_sd_mm")};
  return profile;
}

cv::Mat Row(std::initializer_list<double> values) {
  return cv::Mat(std::vector<double>(values), true).t();
}
cv::Mat Row(const Eigen::Vector3d& v) {
  return Row({v.x(), v.y(), v.z()});
}
cv::Mat Row(const std::array<double, 5>& v) {
  return Row({v[0], v[1], v[2], v[3], v[4]});
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

// OpenCV reads what stands inside another thing by recursion without a bound, in YAML, JSON and XML alike. No camera
// file holds more than some hundred keys, lists, maps or elements, or begins a line far to the right.
void CheckDepth(const std::string& text, const std::filesystem::path& path) {
  constexpr int kMostOpened = 1000;
  constexpr std::size_t kFarthestColumn = 200;
  int opened = 0;
  std::size_t column = 0;  // of the first character that is no blank
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i], next = i + 1 < text.size() ? text[i + 1] : '\n';
    const bool opens_block = (c == '-' || c == ':' || c == '?') && std::isspace(static_cast<unsigned char>(next));
    opened += c == '[' || c == '{' || c == '<' || opens_block;
    column = c == '\n' ? 0 : column + (c == ' ' || c == '\t' ? 1 : text.size());
    if (opened > kMostOpened)
      throw Fail("{}: not a camera file: more than {} keys, lists, maps or elements", path.string(), kMostOpened);
    if (column < text.size() && column > kFarthestColumn)
      throw Fail("{}: not a camera file: a line begins more than {} columns to the right", path.string(),
                 kFarthestColumn);
  }
}

// The line that says it for the second time, as YAML, JSON and XML begin one; 0 where it stands elsewhere.
int SecondLineOf(const std::string& text, const std::string& key) {
  std::istringstream lines(text);
  int number = 0, found = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    line.erase(0, line.find_first_not_of(" \t\"<{"));
    const char next = line.size() > key.size() ? line[key.size()] : '\0';
    const bool begins = line.starts_with(key) && std::strchr(":\"> ", next) && next != '\0';
    if (begins && ++found == 2) return number;
  }
  return 0;
}

// OpenCV would take the first of two.
void CheckKeys(const cv::FileNode& node, const std::string& text, const std::filesystem::path& path) {
  std::set<std::string> seen;
  for (const cv::FileNode& child : node) {
    if (node.isMap() && !seen.insert(child.name()).second) {
      const int line = SecondLineOf(text, child.name());
      throw Fail("{}{}: key '{}' stands twice; keep one", path.string(), line > 0 ? fmt::format(":{}", line) : "",
                 child.name());
    }
    if (child.isMap() || child.isSeq()) CheckKeys(child, text, path);
  }
}

// OpenCV 4 tells line and reason, "(4): Incorrect indentation", as the function's name.
Error NotAFile(const cv::Exception& error, const std::filesystem::path& path) {
  constexpr const char* kWhat = "not an OpenCV FileStorage file";
  constexpr const char* kOthers = "read are also files of ROS, kalibr, Pose2Sim, caliscope, Vicon and Qualisys";
  for (const std::string& told : {error.func, error.err})
    if (const std::size_t end = told.find("): "); told.starts_with('(') && end != std::string::npos)
      return Fail("{}:{}: {}: {}; {}", path.string(), told.substr(1, end - 1), kWhat, told.substr(end + 3), kOthers);
  return Fail("{}: {}: {}; {}", path.string(), kWhat, error.err, kOthers);
}

}  // namespace

CameraProfile ReadCameraProfile(const std::filesystem::path& path, const std::string& view) {
  const std::string text = ReadTextFile(path, 1 << 24);
  if (text.empty()) throw Fail("{}: is empty", path.string());
  if (const auto foreign = ReadForeignCamera(path, text, view)) return *foreign;
  CheckDepth(text, path);
  try {
    const cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (!file.isOpened()) throw Fail("{}: not an OpenCV FileStorage file", path.string());
    CheckKeys(file.root(), text, path);
    return ReadProfile({file, path.string()});
  } catch (const cv::Exception& error) {
    throw NotAFile(error, path);
  } catch (const std::logic_error& error) {  // as std::length_error, of its reader
    throw Fail("{}: not an OpenCV FileStorage file: {}", path.string(), error.what());
  }
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
    const Eigen::Vector4d& sd = u->intrinsics_sd;
    file << "rms_px" << u->rms_px << "intrinsics_sd" << Row({sd[0], sd[1], sd[2], sd[3]});
    file << "distortion_sd" << Row(u->distortion_sd);
  }
  if (profile.camera_from_plane) {
    const Eigen::AngleAxisd rotation(profile.camera_from_plane->linear());
    file << "plane_rvec" << Row(rotation.angle() * rotation.axis());
    file << "plane_tvec" << Row(profile.camera_from_plane->translation());
  }
  if (const auto& u = profile.plane_uncertainty) {
    file << "plane_rms_px" << u->rms_px << "plane_rotation_sd_rad" << Row(u->rotation_sd_rad);
    file << "plane_translation_sd_mm" << Row(u->translation_sd_mm);
  }
  WriteTextFile(path, file.releaseAndGetString());
}

}  // namespace lake::camera
