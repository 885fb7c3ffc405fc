#include "camera_formats.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::camera {
namespace {

// One camera as its file describes it.
struct CameraFacts {
  std::vector<double> size, matrix;  // px; of the matrix fx, fy, cx, cy, or its nine elements by rows
  std::string model;                 // of the lens, as the program calls it; empty: OpenCV's
  std::vector<double> coefficients;
  std::vector<std::string> warnings = {};
};

std::string TextOf(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

// Vicon's lens: ideal = d (1 + k1 r² + k2 r⁴ + k3 r⁶) of the distance d from the principal point in the picture, r its
// length in px: the way back of OpenCV's polynomial, which is fitted to it over the picture. Throws Error where that
// does not describe it.
std::vector<double> FitViconLens(const std::vector<double>& k, double focal_px, double corner_px,
                                 const std::string& where) {
  constexpr int kRadii = 200;
  constexpr double kWorst_px = 0.1;
  Eigen::MatrixXd powers(kRadii, 3);
  Eigen::VectorXd missing(kRadii);
  for (int i = 0; i < kRadii; ++i) {
    const double seen = corner_px * (i + 1) / kRadii, r2 = seen * seen;
    const double ideal = seen * (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]))) / focal_px;
    powers.row(i) << std::pow(ideal, 3), std::pow(ideal, 5), std::pow(ideal, 7);
    missing[i] = seen / focal_px - ideal;
  }
  const Eigen::VectorXd c = powers.colPivHouseholderQr().solve(missing);
  const double worst_px = focal_px * (powers * c - missing).cwiseAbs().maxCoeff();
  if (!(worst_px < kWorst_px))
    throw Fail("{}: its lens model ViconRadial has no counterpart here within {} px", where,
               SignificantText(worst_px, 2));
  return {c[0], c[1], 0, 0, c[2]};
}

// k1 k2 of VICON_RADIAL, or k1 k2 k3 of VICON_RADIAL2 ("ViconRadial2 x y k1 k2 k3"), which Nexus writes for video
// cameras. Coefficients that make no sense per px² are of distances in focal lengths, and OpenCV's, as Pose2Sim and
// OpenCap read them.
void ReadVicon(const Json& camera, const std::string& where, CameraFacts& facts) {
  const Json* found = FindKey(*FindKey(camera, "KeyFrames"), "KeyFrame");
  if (!found) throw Fail("{}: was never calibrated (no KeyFrame)", where);
  const Json& frame = found->is_array() ? found->front() : *found;
  const double focal_px = NumberAt(frame, "FOCAL_LENGTH", where),
               aspect = FindKey(camera, "PIXEL_ASPECT_RATIO") ? NumberAt(camera, "PIXEL_ASPECT_RATIO", where) : 1;
  const std::vector<double> centre = NumbersAt(frame, "PRINCIPAL_POINT", where, 2);
  facts.matrix = {focal_px, focal_px / aspect, centre[0], centre[1]};
  std::vector<double> k = {0, 0};
  if (const Json* second = FindKey(frame, "VICON_RADIAL2")) {
    const std::string text = TextOf(*second);
    k = NumbersAt({{"k", text.substr(std::min(text.size(), text.find_first_of(" \t")))}}, "k", where, 5);
    k.erase(k.begin(), k.begin() + 2);
  } else if (FindKey(frame, "VICON_RADIAL")) {
    k = NumbersAt(frame, "VICON_RADIAL", where, 2);
  }
  k.resize(3);
  const double corner_px =
      std::hypot(std::max(centre[0], facts.size[0] - centre[0]), std::max(centre[1], facts.size[1] - centre[1]));
  const double r2 = corner_px * corner_px, scale = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]));
  constexpr double kLeast = 0.5, kMost = 2;  // of a lens that a picture was taken with
  if (scale > kLeast && scale < kMost) {
    facts.coefficients = FitViconLens(k, focal_px, corner_px, where);
    return;
  }
  facts.coefficients = {k[0], k[1], 0, 0, k[2]};
  facts.warnings.push_back(
      fmt::format("{}: the lens' coefficients {}, {}, {} are not per px², as Vicon has them; they are taken for "
                  "OpenCV's k1, k2, k3",
                  where, k[0], k[1], k[2]));
}

// Lengths are in 64ths of a px, of Theia in px, of the sensor, whose part `fov_video` is the picture.
void ReadQualisys(const Json& camera, const std::string& where, CameraFacts& facts) {
  constexpr double kWidest_px = 1 << 14;
  const Json &lens = *FindKey(camera, "intrinsic"), *picture = FindKey(camera, "fov_video");
  const auto number = [&](const char* name) { return NumberAt(lens, name, where); };
  const double per_px = number("sensorMaxU") > kWidest_px ? 64 : 1;
  // The px of the picture's edges; of the whole sensor the last 64th of its last px is stated, or the next px' first.
  const auto edge = [&](const char* name, const char* of_sensor) {
    return picture ? NumberAt(*picture, name, where) : std::max(std::ceil(number(of_sensor) / per_px) - 1, 0.0);
  };
  const double left = edge("left", "sensorMinU"), top = edge("top", "sensorMinV");
  facts.size = {edge("right", "sensorMaxU") - left + 1, edge("bottom", "sensorMaxV") - top + 1};
  facts.matrix = {number("focalLengthU") / per_px, number("focalLengthV") / per_px,
                  number("centerPointU") / per_px - left, number("centerPointV") / per_px - top};
  facts.coefficients = {number("radialDistortion1"), number("radialDistortion2"), number("tangentalDistortion1"),
                        number("tangentalDistortion2"),
                        FindKey(lens, "radialDistortion3") ? number("radialDistortion3") : 0};
  if (const Json* turn = FindKey(camera, "viewrotation"); turn && TextOf(*turn) != "0")
    facts.warnings.push_back(
        fmt::format("{}: QTM shows its view turned by {}°; the camera is that of the picture as it was taken", where,
                    TextOf(*turn)));
}

// A program's camera is a map with the key `matrix`, at whatever depth; its name stands under `name`, or is its own
// key.
struct Dialect {
  const char *program, *matrix;
  std::vector<const char*> size;
  const char *coefficients, *name, *model = "distortion_model";
  void (*read)(const Json& camera, const std::string& where, CameraFacts& facts) = nullptr;  // what the keys do not say
};
const Dialect kDialects[] = {
    {"OpenCV or ROS", "camera_matrix", {"image_width", "image_height"}, "distortion_coefficients", "camera_name"},
    {"ROS (a message)", "K", {"width", "height"}, "D", ""},
    {"kalibr", "intrinsics", {"resolution"}, "distortion_coeffs", ""},
    {"Pose2Sim or caliscope", "matrix", {"size"}, "distortions", "", "fisheye"},
    {"Vicon", "KeyFrames", {"SENSOR_SIZE"}, "", "DEVICEID", "", ReadVicon},
    {"Qualisys", "intrinsic", {}, "", "serial", "", ReadQualisys}};

// What other programs call OpenCV's models.
constexpr std::pair<std::string_view, LensModel> kLensNames[] = {{"", LensModel::kBrownConrady},
                                                                 {"brown_conrady", LensModel::kBrownConrady},
                                                                 {"plumb_bob", LensModel::kBrownConrady},
                                                                 {"rational_polynomial", LensModel::kBrownConrady},
                                                                 {"radtan", LensModel::kBrownConrady},
                                                                 {"none", LensModel::kBrownConrady},
                                                                 {"fisheye", LensModel::kFisheye},
                                                                 {"equidistant", LensModel::kFisheye},
                                                                 {"equi", LensModel::kFisheye}};

LensModel ModelOf(const std::string& name, const std::string& where) {
  std::string key = name;  // "Plumb Bob"
  for (char& c : key) c = c == ' ' || c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto* known = std::ranges::find(kLensNames, key, [](const auto& known) { return known.first; });
  if (known == std::end(kLensNames))
    throw Fail(
        "{}: its lens model '{}' has no counterpart here; plumb_bob (radtan), rational_polynomial and equidistant "
        "(fisheye) are read",
        where, name);
  return known->second;
}

void SetCoefficients(const std::vector<double>& coefficients, const std::string& where, Camera& camera) {
  std::size_t count = coefficients.size();
  if (camera.model == LensModel::kFisheye) {
    while (count > 4 && coefficients[count - 1] == 0) --count;
    if (count > 4 || coefficients.size() < 4)
      throw Fail("{}: a fisheye has four distortion coefficients, not {}", where, coefficients.size());
  } else if (count != 0 && count != 2 && count != 4 && count != 5 && count != 8 && count != 12 && count != 14) {
    throw Fail("{}: {} distortion coefficients; k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [τx τy]]]] are needed", where,
               count);
  }
  for (std::size_t i = 0; i < count; ++i) (i < 5 ? camera.distortion[i] : camera.more[i - 5]) = coefficients[i];
}

// A text, or whether it is a fisheye.
std::string ModelText(const Json& camera, const Dialect& dialect, const std::string& where) {
  const Json *model = FindKey(camera, dialect.model), *projection = FindKey(camera, "camera_model");
  if (projection && TextOf(*projection) != "pinhole") return TextOf(*projection);
  if (FindKey(camera, "fisheye_model") && NumberAt(camera, "fisheye_model", where) != 0) return "fisheye";
  if (!model || *model == false) return "";
  return *model == true ? "fisheye" : TextOf(*model);
}

Camera ReadCamera(const Json& node, const Dialect& dialect, const std::string& where,
                  std::vector<std::string>& warnings) {
  Camera camera;
  CameraFacts facts;
  facts.model = ModelText(node, dialect, where);
  camera.model = ModelOf(facts.model, where);
  for (const char* key : dialect.size)
    for (const double number : NumbersAt(node, key, where)) facts.size.push_back(number);
  if (dialect.read)
    dialect.read(node, where, facts);
  else
    facts.matrix = NumbersAt(node, dialect.matrix, where);
  if (facts.model != "none" && facts.coefficients.empty())
    facts.coefficients = NumbersAt(node, dialect.coefficients, where);
  constexpr double kLargest_px = 1 << 16;
  const auto is_size = [&](double px) { return px >= 1 && px <= kLargest_px && px == std::floor(px); };
  if (facts.size.size() != 2 || !std::ranges::all_of(facts.size, is_size))
    throw Fail("{}: the size of its picture is {}, not two whole numbers of px", where, fmt::join(facts.size, " x "));
  camera.image_width = static_cast<int>(facts.size[0]);
  camera.image_height = static_cast<int>(facts.size[1]);
  std::vector<double>& k = facts.matrix;
  if (k.size() == 9) {
    if (k[1] != 0) throw Fail("{}: a skew of {} px, which no model here has", where, k[1]);
    if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
      throw Fail("{}: '{}' must be [fx 0 cx; 0 fy cy; 0 0 1]", where, dialect.matrix);
    k = {k[0], k[4], k[2], k[5]};
  }
  if (k.size() != 4) throw Fail("{}: '{}' has {} numbers, not 9 or 4", where, dialect.matrix, k.size());
  if (!(k[0] > 0) || !(k[1] > 0)) throw Fail("{}: a focal length is not positive: {} and {} px", where, k[0], k[1]);
  camera.fx = k[0];
  camera.fy = k[1];
  camera.cx = k[2];
  camera.cy = k[3];
  SetCoefficients(facts.coefficients, where, camera);
  warnings = facts.warnings;
  return camera;
}

struct FoundCamera {
  std::string name;
  const Json* node;
  const Dialect* dialect;
};

void FindCameras(const Json& tree, const std::string& key, std::vector<FoundCamera>& found) {
  for (const Dialect& dialect : kDialects)
    if (FindKey(tree, dialect.matrix)) {
      const Json* name = FindKey(tree, dialect.name);
      found.push_back({name ? TextOf(*name) : key, &tree, &dialect});
      return;
    }
  if (tree.is_structured())
    for (const auto& [inner, child] : tree.items()) FindCameras(child, tree.is_array() ? key : inner, found);
}

}  // namespace

CameraProfile CameraOf(const Json& tree, const std::filesystem::path& path, const std::string& view) {
  std::vector<FoundCamera> cameras;
  FindCameras(tree, "", cameras);
  if (cameras.empty()) {
    std::vector<std::string> known;
    for (const Dialect& dialect : kDialects)
      known.push_back(fmt::format("'{}' of {}", dialect.matrix, dialect.program));
    throw Fail("{}: no camera: there is no key {}; lake calibrate makes a file from pictures of a board", path.string(),
               fmt::join(known, ", nor "));
  }
  std::vector<std::string> names;
  names.reserve(cameras.size());
  for (const FoundCamera& camera : cameras) names.push_back(camera.name);
  if (!view.empty()) std::erase_if(cameras, [&](const FoundCamera& camera) { return camera.name != view; });
  if (cameras.size() != 1)
    throw Fail("{}: holds the cameras {}; choose one by --view: lake convert {} camera.yaml --view {}", path.string(),
               fmt::join(names, ", "), path.filename().string(), names.front());
  const auto& [name, node, dialect] = cameras.front();
  CameraProfile profile;
  const std::string where = name.empty() ? path.string() : fmt::format("{}: camera {}", path.string(), name);
  try {
    profile.camera = ReadCamera(*node, *dialect, where, profile.warnings);
  } catch (const Error& error) {
    throw Fail(
        "{}; it is read as a camera of {}: mend it there, write a camera.yaml (lake calibrate --template), or run "
        "lake calibrate",
        error.what(), dialect->program);
  }
  return profile;
}

}  // namespace lake::camera
