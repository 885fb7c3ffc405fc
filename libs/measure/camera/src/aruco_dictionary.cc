#include "lake/camera/aruco_dictionary.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "lake/camera/aruco_opencv.h"

namespace lake::camera {
namespace {

constexpr std::array kDictionaries = {
    ArucoDictionary{"4X4_50", cv::aruco::DICT_4X4_50},
    ArucoDictionary{"4X4_100", cv::aruco::DICT_4X4_100},
    ArucoDictionary{"4X4_250", cv::aruco::DICT_4X4_250},
    ArucoDictionary{"4X4_1000", cv::aruco::DICT_4X4_1000},
    ArucoDictionary{"5X5_50", cv::aruco::DICT_5X5_50},
    ArucoDictionary{"5X5_100", cv::aruco::DICT_5X5_100},
    ArucoDictionary{"5X5_250", cv::aruco::DICT_5X5_250},
    ArucoDictionary{"5X5_1000", cv::aruco::DICT_5X5_1000},
    ArucoDictionary{"6X6_50", cv::aruco::DICT_6X6_50},
    ArucoDictionary{"6X6_100", cv::aruco::DICT_6X6_100},
    ArucoDictionary{"6X6_250", cv::aruco::DICT_6X6_250},
    ArucoDictionary{"6X6_1000", cv::aruco::DICT_6X6_1000},
    ArucoDictionary{"7X7_50", cv::aruco::DICT_7X7_50},
    ArucoDictionary{"7X7_100", cv::aruco::DICT_7X7_100},
    ArucoDictionary{"7X7_250", cv::aruco::DICT_7X7_250},
    ArucoDictionary{"7X7_1000", cv::aruco::DICT_7X7_1000},
    ArucoDictionary{"ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL},
    ArucoDictionary{"APRILTAG_16h5", cv::aruco::DICT_APRILTAG_16h5},
    ArucoDictionary{"APRILTAG_25h9", cv::aruco::DICT_APRILTAG_25h9},
    ArucoDictionary{"APRILTAG_36h10", cv::aruco::DICT_APRILTAG_36h10},
    ArucoDictionary{"APRILTAG_36h11", cv::aruco::DICT_APRILTAG_36h11},
};

bool SameLetters(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::toupper(x) == std::toupper(y); });
}

}  // namespace

std::optional<ArucoDictionary> FindArucoDictionary(std::string_view name) {
  constexpr std::string_view kPrefix = "DICT_";
  if (SameLetters(name.substr(0, kPrefix.size()), kPrefix)) name.remove_prefix(kPrefix.size());
  const auto found = std::find_if(kDictionaries.begin(), kDictionaries.end(), [&](const ArucoDictionary& dictionary) {
    return SameLetters(dictionary.name, name);
  });
  return found == kDictionaries.end() ? std::nullopt : std::optional(*found);
}

std::string ArucoDictionaryNames() {
  std::string names;
  for (const ArucoDictionary& dictionary : kDictionaries)
    names += fmt::format("{}{}", names.empty() ? "" : ", ", dictionary.name);
  return names;
}

}  // namespace lake::camera
