// C3D files with the output of a model, which lake itself does not write.
#pragma once

#include <string>

namespace lake {

// The bytes of a C3D written by lake whose point `name` is stated to be an output: POINT:GROUP and its unit stand in
// the place of zeros behind the parameters.
inline std::string WithModelOutput(std::string bytes, const std::string& group, const std::string& name,
                                   const std::string& unit) {
  const auto entry = [](const std::string& key, const std::string& text) {
    const int next = 2 + 1 + 1 + 2 + static_cast<int>(text.size()) + 1;
    return std::string{static_cast<char>(key.size()), 1} + key + static_cast<char>(next) + '\0' + '\xFF' + '\2' +
           static_cast<char>(text.size()) + '\1' + text + '\0';
  };
  const std::string added = entry(group, name) + entry(group.substr(0, group.size() - 1) + "_UNITS", unit);
  const std::size_t at = bytes.find("DATA_START") - 2;
  bytes.insert(at, added);
  bytes.erase(bytes.find(std::string(added.size(), '\0'), at + added.size() + 30), added.size());
  return bytes;
}

}  // namespace lake
