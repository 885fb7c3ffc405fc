// A home folder for tests of what may not be named.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace lake {

// While it lives, this is the home folder of the user.
class HomeFolder {
 public:
  explicit HomeFolder(const std::filesystem::path& folder) { setenv("HOME", folder.c_str(), 1); }
  ~HomeFolder() { before_ ? setenv("HOME", before_->c_str(), 1) : unsetenv("HOME"); }

 private:
  std::optional<std::string> before_ =
      std::getenv("HOME") ? std::optional<std::string>(std::getenv("HOME")) : std::nullopt;
};

}  // namespace lake
