// XML of Vicon (.xcp) and of Qualisys QTM (calibration, .qca.txt).
#include <Eigen/QR>
#include <cmath>
#include <pugixml.hpp>

#include "camera_formats.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::camera {
namespace {

void Load(const std::string& text, const std::filesystem::path& path, pugi::xml_document& document) {
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
  if (!parsed) throw Fail("{}: not XML: {} at byte {}", path.string(), parsed.description(), parsed.offset);
}

double NumberOf(const pugi::xml_node& node, const char* name, const std::string& where) {
  const std::optional<double> number = ParseNumber(node.attribute(name).as_string());
  if (!number) throw Fail("{}: '{}' is '{}', not a number", where, name, node.attribute(name).as_string());
  return *number;
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
    throw Fail("{}: its lens model ViconRadial has no counterpart here within {} px: calibrate by lake calibrate",
               where, SignificantText(worst_px, 2));
  return {c[0], c[1], 0, 0, c[2]};
}

// k1 k2 of VICON_RADIAL, or k1 k2 k3 of VICON_RADIAL2 ("ViconRadial2 x y k1 k2 k3"), which Nexus writes for video
// cameras. Coefficients that make no sense per px² are of distances in focal lengths, and OpenCV's, as Pose2Sim and
// OpenCap read them.
void SetViconLens(const pugi::xml_node& frame, const std::string& where, CameraFacts& camera) {
  std::string text = frame.attribute("VICON_RADIAL2").as_string();
  const bool is_second = !text.empty();
  if (is_second) text.erase(0, std::min(text.size(), text.find_first_of(" \t")));
  std::vector<double> k = NumbersOf(is_second ? text : frame.attribute("VICON_RADIAL").as_string("0 0"), 2, where);
  if (is_second) k.erase(k.begin(), k.begin() + 2);
  k.resize(3);
  const double corner_px = std::hypot(std::max(camera.matrix(0, 2), camera.width_px - camera.matrix(0, 2)),
                                      std::max(camera.matrix(1, 2), camera.height_px - camera.matrix(1, 2)));
  const double r2 = corner_px * corner_px, scale = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]));
  constexpr double kLeast = 0.5, kMost = 2;  // of a lens that a picture was taken with
  if (scale > kLeast && scale < kMost) {
    camera.coefficients = FitViconLens(k, camera.matrix(0, 0), corner_px, where);
    return;
  }
  camera.coefficients = {k[0], k[1], 0, 0, k[2]};
  camera.warnings.push_back(
      fmt::format("{}: the lens' coefficients {}, {}, {} are not per px², as Vicon has them; they are taken for "
                  "OpenCV's k1, k2, k3",
                  where, k[0], k[1], k[2]));
}

}  // namespace

std::vector<CameraFacts> ReadViconCameras(const std::string& text, const std::filesystem::path& path) {
  pugi::xml_document document;
  Load(text, path, document);
  std::vector<CameraFacts> cameras;
  for (const pugi::xml_node node : document.child("Cameras").children("Camera")) {
    const pugi::xml_node frame = node.child("KeyFrames").child("KeyFrame");
    if (!frame) continue;  // never calibrated
    CameraFacts& camera = cameras.emplace_back();
    camera.name = node.attribute("DEVICEID").as_string();
    const std::string where = fmt::format("{}: camera {}", path.string(), camera.name);
    const std::vector<double> size = NumbersOf(node.attribute("SENSOR_SIZE").as_string(), 2, where),
                              centre = NumbersOf(frame.attribute("PRINCIPAL_POINT").as_string(), 2, where);
    camera.width_px = size[0];
    camera.height_px = size[1];
    const double focal_px = NumberOf(frame, "FOCAL_LENGTH", where),
                 aspect = node.attribute("PIXEL_ASPECT_RATIO") ? NumberOf(node, "PIXEL_ASPECT_RATIO", where) : 1;
    camera.matrix << focal_px, node.attribute("SKEW").as_double(0), centre[0], 0, focal_px / aspect, centre[1], 0, 0, 1;
    SetViconLens(frame, where, camera);
  }
  return cameras;
}

// Lengths are in 64ths of a px of the whole sensor, whose part `fov_video` is the picture; coefficients are OpenCV's.
std::vector<CameraFacts> ReadQualisysCameras(const std::string& text, const std::filesystem::path& path) {
  constexpr double kPerPixel = 64;
  pugi::xml_document document;
  Load(text, path, document);
  std::vector<CameraFacts> cameras;
  for (const pugi::xpath_node found : document.select_nodes("//camera[intrinsic]")) {
    const pugi::xml_node node = found.node(), lens = node.child("intrinsic"), picture = node.child("fov_video");
    CameraFacts& camera = cameras.emplace_back();
    camera.name = node.attribute("serial").as_string();
    const std::string where = fmt::format("{}: camera {}", path.string(), camera.name);
    const auto number = [&](const char* name) { return NumberOf(lens, name, where); };
    const double left = picture ? NumberOf(picture, "left", where) : 0,
                 top = picture ? NumberOf(picture, "top", where) : 0;
    camera.width_px = picture ? NumberOf(picture, "right", where) - left + 1
                              : (number("sensorMaxU") - number("sensorMinU") + 1) / kPerPixel;
    camera.height_px = picture ? NumberOf(picture, "bottom", where) - top + 1
                               : (number("sensorMaxV") - number("sensorMinV") + 1) / kPerPixel;
    camera.matrix << number("focalLengthU") / kPerPixel, lens.attribute("skew").as_double(0),
        number("centerPointU") / kPerPixel - left, 0, number("focalLengthV") / kPerPixel,
        number("centerPointV") / kPerPixel - top, 0, 0, 1;
    camera.coefficients = {number("radialDistortion1"), number("radialDistortion2"), number("tangentalDistortion1"),
                           number("tangentalDistortion2"), lens.attribute("radialDistortion3").as_double(0)};
    if (const int turn = node.attribute("viewrotation").as_int(0))
      camera.warnings.push_back(fmt::format(
          "{}: QTM shows its view turned by {}°; the camera is that of the picture as it was taken", where, turn));
  }
  return cameras;
}

}  // namespace lake::camera
