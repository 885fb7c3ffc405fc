#include "text_lines.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/utf8.h"

namespace lake::exchange {
TextLines::TextLines(const std::filesystem::path& path) : path_(path) {
  std::string text = ReadTextFile(path);
  if (text.find('\0') != std::string::npos) throw Fail("{}: not a text file", path.string());
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  text = Utf8FromText(std::move(text), path.string());
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    line.erase(line.find_last_not_of(" \r") + 1);
    lines_.push_back(std::move(line));
    begin = end + 1;
  }
}

std::string TextLines::Where(std::size_t i) const {
  return fmt::format("{}:{}", path_.string(), i + 1);
}

std::vector<std::string> SplitCells(std::string_view line, char separator) {
  std::vector<std::string> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    cells.emplace_back(Trim(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

std::string Lower(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

std::optional<double> NumberOrMissing(std::string_view cell, const std::string& where) {
  const std::string_view text = Trim(cell);
  if (text.empty()) return std::nullopt;
  const std::string lower = Lower(text);
  if (lower == "nan" || lower == "-nan" || lower == "-1.#ind" || lower == "1.#qnan") return std::nullopt;
  std::string number(text);
  if (number.find('.') == std::string::npos) std::replace(number.begin(), number.end(), ',', '.');
  const std::optional<double> value = ParseNumber(number);
  if (!value) throw Fail("{}: '{}' is not a finite number", where, text);
  return value;
}

double RequiredNumber(std::string_view cell, const std::string& where) {
  const std::optional<double> value = NumberOrMissing(cell, where);
  if (!value) throw Fail("{}: a number is missing", where);
  return *value;
}

void AppendTime(std::optional<double> time_s, const std::string& where, std::vector<double>& times_s) {
  if (!time_s) throw Fail("{}: the time is missing", where);
  if (!times_s.empty() && *time_s <= times_s.back()) throw Fail("{}: the time does not increase", where);
  times_s.push_back(*time_s);
}

void CheckNames(const PointRecording& points, const std::filesystem::path& path) {
  for (const PointTrack& point : points.points)
    if (point.name.empty() || point.name.find_first_of("\t\r\n") != std::string::npos)
      throw Fail("{}: the name '{}' cannot stand in this format: give another with --map", path.string(), point.name);
}

std::size_t ParseCount(std::string_view cell, const std::string& what, const std::string& where, std::size_t most) {
  const double value = RequiredNumber(cell, where);
  if (!(value >= 0 && value <= static_cast<double>(most)) || value != std::floor(value))
    throw Fail("{}: {} is {}, not a count up to {}", where, what, cell, most);
  return static_cast<std::size_t>(value);
}

}  // namespace lake::exchange
