// Camera files of other programs. Not part of the interface.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/camera/camera.h"

namespace lake::camera {

// One camera as its file describes it.
struct CameraFacts {
  std::string name;                                  // in the file
  double width_px = 0, height_px = 0;                // of its pictures
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();  // fx skew cx, 0 fy cy, 0 0 1; px
  std::string model;                                 // of the lens, as the program calls it; empty: OpenCV's
  std::vector<double> coefficients;
  std::vector<std::string> warnings = {};
};

// The only camera of a file of another program, or the one called `view`; nullopt if it is of none that is known.
// Throws Error: several cameras and no `view` among them, a lens that no model here describes, by its name.
std::optional<CameraProfile> ReadForeignCamera(const std::filesystem::path& path, const std::string& text,
                                               const std::string& view);

// Throws Error, naming `where`: no picture's size, a focal length that is not positive, skew, a lens model that has no
// counterpart here, a number of coefficients that the model does not have.
Camera CameraOf(const CameraFacts& facts, const std::string& where);

// "1 2.5 3" as numbers. Throws Error, naming `where`, for another text or fewer than `least`.
std::vector<double> NumbersOf(const std::string& text, std::size_t least, const std::string& where);

}  // namespace lake::camera
