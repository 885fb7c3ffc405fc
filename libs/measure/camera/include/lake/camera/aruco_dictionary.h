// The dictionaries of ArUco codes that OpenCV knows, by name.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace lake::camera {

struct ArucoDictionary {
  std::string_view name;  // OpenCV's without DICT_, e.g. 4X4_50
  int id = 0;             // a cv::aruco::PREDEFINED_DICTIONARY_NAME
};

// With or without DICT_, in upper or lower case. nullopt if unknown.
std::optional<ArucoDictionary> FindArucoDictionary(std::string_view name);

// All names, for messages.
std::string ArucoDictionaryNames();

}  // namespace lake::camera
