#include "lake/camera/aruco_dictionary.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "lake/camera/aruco_opencv.h"

namespace lake::camera {
namespace {

// In the order of OpenCV's enumeration, so that a place in this list is the number there.
constexpr std::array<std::string_view, 21> kNames = {
    "4X4_50",   "4X4_100",  "4X4_250",        "4X4_1000",      "5X5_50",        "5X5_100",        "5X5_250",
    "5X5_1000", "6X6_50",   "6X6_100",        "6X6_250",       "6X6_1000",      "7X7_50",         "7X7_100",
    "7X7_250",  "7X7_1000", "ARUCO_ORIGINAL", "APRILTAG_16h5", "APRILTAG_25h9", "APRILTAG_36h10", "APRILTAG_36h11"};
static_assert(kNames[cv::aruco::DICT_APRILTAG_36h11] == kNames.back());

bool SameLetters(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::toupper(x) == std::toupper(y); });
}

}  // namespace

std::optional<ArucoDictionary> FindArucoDictionary(std::string_view name) {
  constexpr std::string_view kPrefix = "DICT_";
  if (SameLetters(name.substr(0, kPrefix.size()), kPrefix)) name.remove_prefix(kPrefix.size());
  for (std::size_t id = 0; id < kNames.size(); ++id)
    if (SameLetters(kNames[id], name)) return ArucoDictionary{kNames[id], static_cast<int>(id)};
  return std::nullopt;
}

std::string ArucoDictionaryNames() {
  return fmt::format("{}", fmt::join(kNames, ", "));
}

}  // namespace lake::camera
