// TOML of Pose2Sim and anipose ([cam_01] with name, size, matrix, distortions, fisheye) and of caliscope ([cameras.0]):
// each table, at whatever depth, that has a matrix and a size is a camera; coefficients are OpenCV's.
#include <toml++/toml.h>

#include "camera_formats.h"
#include "lake/core/error.h"

namespace lake::camera {
namespace {

// The numbers of a list, lists within it included.
void AppendNumbers(const toml::node* node, std::vector<double>& numbers) {
  if (!node) return;
  if (const toml::array* list = node->as_array())
    for (const toml::node& element : *list) AppendNumbers(&element, numbers);
  else if (const auto number = node->value<double>())
    numbers.push_back(*number);
}

std::vector<double> NumbersIn(const toml::table& table, std::string_view key) {
  std::vector<double> numbers;
  AppendNumbers(table.get(key), numbers);
  return numbers;
}

void AppendCameras(const toml::table& table, const std::string& name, std::vector<CameraFacts>& cameras) {
  const std::vector<double> matrix = NumbersIn(table, "matrix"), size = NumbersIn(table, "size");
  if (matrix.size() == 9 && size.size() == 2) {
    CameraFacts& camera = cameras.emplace_back();
    camera.name = name;
    camera.width_px = size[0];
    camera.height_px = size[1];
    camera.matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.data());
    camera.model = table["fisheye"].value_or(false) ? "fisheye" : "";
    camera.coefficients = NumbersIn(table, "distortions");
    return;
  }
  for (const auto& [key, child] : table)
    if (const toml::table* inner = child.as_table()) AppendCameras(*inner, std::string(key.str()), cameras);
}

}  // namespace

std::vector<CameraFacts> ReadTomlCameras(const std::string& text, const std::filesystem::path& path) {
  std::vector<CameraFacts> cameras;
  try {
    AppendCameras(toml::parse(text), "", cameras);
  } catch (const toml::parse_error& error) {
    throw Fail("{}:{}: not TOML: {}", path.string(), error.source().begin.line, error.description());
  }
  return cameras;
}

}  // namespace lake::camera
