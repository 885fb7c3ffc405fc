// The numbered pictures behind a printf pattern.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace lake::video {

class ImageSequence {
 public:
  // Nothing if the path is no pattern, or is the name of a file that exists. Throws Error: more than one or another
  // conversion than %d or %0Nd, no such folder, no file that fits, a gap in the numbers.
  static std::optional<ImageSequence> Find(const std::filesystem::path& path);

  std::int64_t FirstNumber() const { return first_number_; }
  std::int64_t Files() const { return files_; }
  std::filesystem::path File(std::int64_t index) const { return folder_ / Name(first_number_ + index); }

  // The pattern for libav, in which a % of the folder's name is doubled.
  std::string Url() const;

 private:
  std::string Name(std::int64_t number) const;
  std::optional<std::int64_t> Number(const std::string& name) const;
  void ParsePattern(const std::string& pattern, const std::string& path);

  std::filesystem::path folder_;
  std::string before_, after_;  // of the number
  int digits_ = 0;
  std::int64_t first_number_ = 0;
  std::int64_t files_ = 0;
};

}  // namespace lake::video
