// Camera files of OpenCV, of lake and of other programs. Not part of the interface.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "lake/camera/camera.h"
#include "lake/core/json.h"

namespace lake::camera {

// A file as a tree of maps, lists, numbers and texts, whether it is YAML, JSON, TOML or XML, whose attributes are keys.
// Throws Error, with the line where the library gives it.
Json ReadTree(const std::filesystem::path& path);

// What stands under a key of a map, whatever the case of its letters; nullptr if nothing does.
const Json* FindKey(const Json& map, std::string_view key);

// The numbers under a key: of a value, a text "1 2.5 3", a list, lists in it, or a matrix, which is a map with `data`;
// nothing for an empty key. Throws Error, naming `where`: no such key, other than numbers, or not `count` of them.
std::vector<double> NumbersAt(const Json& map, std::string_view key, const std::string& where, std::size_t count = 0);
inline double NumberAt(const Json& map, std::string_view key, const std::string& where) {
  return NumbersAt(map, key, where, 1)[0];
}

// The only camera of a tree, or the one called `view`, with what had to be assumed of it as warnings. Throws Error: no
// camera of a program that is known, several and no `view` among them, a lens that no model here describes.
CameraProfile CameraOf(const Json& tree, const std::filesystem::path& path, const std::string& view);

}  // namespace lake::camera
