// Text files line by line, with places for messages. Not part of the interface.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/exchange/point_recording.h"

namespace lake::exchange {

class TextLines {
 public:
  // CR, a byte order mark and trailing blanks (not tabs) are taken off. Throws Error if the file cannot be read.
  explicit TextLines(const std::filesystem::path& path);

  std::size_t Count() const { return lines_.size(); }
  const std::string& operator[](std::size_t i) const { return lines_[i]; }
  std::string Where(std::size_t i) const;  // "file:line"

 private:
  std::filesystem::path path_;
  std::vector<std::string> lines_;
};

// All cells, empty ones too, trimmed.
std::vector<std::string> SplitCells(std::string_view line, char separator);

std::string Lower(std::string_view text);

// Empty cells and NaN in any spelling are missing; a decimal comma is understood. Throws Error naming the place.
std::optional<double> NumberOrMissing(std::string_view cell, const std::string& where);
double RequiredNumber(std::string_view cell, const std::string& where);

// A time that must come after the last of those before. Throws Error naming the place.
void AppendTime(std::optional<double> time_s, const std::string& where, std::vector<double>& times_s);

// Of points to be written between tabs: throws Error for an empty name, or one with a tab or a line end.
void CheckNames(const PointRecording& points, const std::filesystem::path& path);

// More frames than any trial has; a count or number above it is damage.
inline constexpr std::size_t kMostFrames = 10'000'000;

// A count from a header. Throws Error unless 0 ≤ count ≤ `most`.
std::size_t ParseCount(std::string_view cell, const std::string& what, const std::string& where, std::size_t most);

}  // namespace lake::exchange
