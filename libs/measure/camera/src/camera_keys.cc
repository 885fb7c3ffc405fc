#include <fmt/format.h>

#include <array>

#include "lake/camera/camera.h"
#include "lake/core/option_template.h"

namespace lake::camera {
namespace {

constexpr std::array kKeys = {
    CameraKey{"image_width", "1280", "Width of the pictures with which the camera was calibrated, px", true},
    CameraKey{"image_height", "720", "Their height, px. A video of the same aspect is scaled, others are refused",
              true},
    CameraKey{
        "camera_matrix",
        "!!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
        "   data: [ 1100., 0., 639.5, 0., 1100., 359.5, 0., 0., 1. ]",
        "fx 0 cx, 0 fy cy, 0 0 1: focal lengths and principal point, px; the centre of the top left pixel is 0, 0",
        true},
    CameraKey{"distortion_coefficients", "[ 0., 0., 0., 0., 0. ]",
              "k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]] as OpenCV has them; k1 k2 k3 k4 of a fisheye", true},
    CameraKey{"distortion_model", "fisheye", "fisheye or brown_conrady, which holds without this key"},
    CameraKey{
        "readout_s", "0.012",
        "Rolling shutter: time from the first row's exposure to the last one's, s; negative from below; 0: global"},
    CameraKey{"rms_px", "0.15", "Of the calibration: error of the corners, RMS, px; the next two go with it"},
    CameraKey{"intrinsics_sd", "[ 1.2, 1.2, 0.8, 0.9 ]", "Standard deviations of fx fy cx cy, px"},
    CameraKey{"distortion_sd", "[ 0.002, 0.01, 0.0002, 0.0002, 0. ]", "Standard deviations of k1 k2 p1 p2 k3"},
    CameraKey{
        "plane_rvec", "[ 3.1, 0.05, 0. ]",
        "The sagittal plane (x right in the picture, y up, z towards the camera): its turn into the camera's axes, "
        "axis times angle, rad"},
    CameraKey{"plane_tvec", "[ -100., 650., 3000. ]", "Where the plane's origin is in the camera's axes, mm"},
    CameraKey{"plane_rms_px", "0.2", "Of the plane's points: error, RMS, px; the next two go with it"},
    CameraKey{"plane_rotation_sd_rad", "[ 0.001, 0.001, 0.0005 ]", "Standard deviations of the plane's turn, rad"},
    CameraKey{"plane_translation_sd_mm", "[ 0.5, 0.5, 3. ]", "Standard deviations of its place, mm"}};

}  // namespace

std::span<const CameraKey> CameraKeys() {
  return kKeys;
}

std::string CameraTemplate() {
  std::string text = "%YAML:1.0\n---\n# A camera, in OpenCV's FileStorage, as lake calibrate writes it.\n";
  for (const CameraKey& key : kKeys) {
    const std::string line = fmt::format("{}: {}\n", key.name, key.value);
    text += fmt::format("\n# {}\n{}", key.meaning, key.is_needed ? line : AsComment(line));
  }
  return text;
}

}  // namespace lake::camera
