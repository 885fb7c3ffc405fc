#include <csv.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <pugixml.hpp>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/utf8.h"
#include "readers.h"

namespace lake::exchange {

std::string TextFromBytes(std::string bytes) {
  const bool has_mark = bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF");
  if (bytes.size() > 1 && (has_mark || !bytes[0] != !bytes[1])) {  // UTF-16, whose letters of ASCII have a zero byte
    const std::size_t high = bytes[0] == '\xFF' || !bytes[1] ? 1 : 0;
    std::wstring wide;
    for (std::size_t i = has_mark ? 2 : 0; i + 1 < bytes.size(); i += 2)
      wide += static_cast<wchar_t>(static_cast<unsigned char>(bytes[i + high]) << 8 |
                                   static_cast<unsigned char>(bytes[i + 1 - high]));
    bytes = pugi::as_utf8(wide);
  }
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.erase(0, 3);
  bytes.erase(bytes.find_last_not_of('\0') + 1);
  return Utf8FromText(std::move(bytes));
}

TextLines::TextLines(const std::filesystem::path& path) : path_(path) {
  std::string text = TextFromBytes(ReadTextFile(path));
  if (text.find('\0') != std::string::npos)
    throw Fail("{}: not a text file, as it holds zero bytes; save it as text in UTF-8", path.string());
  ends_within_line_ = !text.empty() && text.back() != '\n' && text.back() != '\r';
  if (text.empty()) throw Fail("{}: is empty", path.string());
  const char line_end = text.find('\n') == std::string::npos ? '\r' : '\n';
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(line_end, begin), text.size());
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
  if (separator == ' ') {
    cells = SplitText(line, separator);
    std::erase(cells, "");
    return cells.empty() ? std::vector<std::string>(1) : cells;
  }
  if (line.find('"') != std::string::npos) {
    csv_parser parser;
    if (csv_init(&parser, 0) != 0) throw Fail("cannot set up the CSV parser");
    csv_set_delim(&parser, static_cast<unsigned char>(separator));
    const auto add = [](void* field, std::size_t length, void* list) {
      static_cast<std::vector<std::string>*>(list)->emplace_back(Trim({static_cast<const char*>(field), length}));
    };
    csv_parse(&parser, line.data(), line.size(), add, nullptr, &cells);
    csv_fini(&parser, add, nullptr, &cells);
    csv_free(&parser);
    return cells;
  }
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    cells.emplace_back(Trim(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

char SeparatorOf(std::string_view line) {
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (!quoted && (c == '\t' || c == ';' || c == ',')) return c;
  }
  return ',';
}

std::string Lower(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

std::optional<double> NumberIn(std::string_view cell, bool& is_unreadable) {
  const std::string_view text = Trim(cell);
  if (text.empty()) return std::nullopt;
  const std::string lower = Lower(text);
  if (lower.find("nan") != lower.npos || lower.find("#ind") != lower.npos) return std::nullopt;
  std::string number(text);
  if (number.find('.') == std::string::npos) std::replace(number.begin(), number.end(), ',', '.');
  const std::optional<double> value = ParseNumber(number);
  is_unreadable = !value;
  return value;
}

void CheckNames(const PointRecording& points, const std::filesystem::path& path) {
  for (const PointTrack& point : points.points)
    if (point.name.empty() || point.name.find_first_of("\t\r\n") != std::string::npos)
      throw Fail("{}: the name '{}' cannot stand in this format: give another with --map", path.string(), point.name);
}

std::optional<std::size_t> CountIn(std::string_view cell, std::size_t most) {
  bool is_unreadable = false;
  const double value = NumberIn(cell, is_unreadable).value_or(-1);
  if (!(value >= 0 && value <= static_cast<double>(most)) || value != std::floor(value)) return std::nullopt;
  return static_cast<std::size_t>(value);
}

void LeftOut::Add(const std::string& kind, const std::string& where) {
  const auto found = std::ranges::find(kinds_, kind, &Kind::name);
  Kind& known = found == kinds_.end() ? kinds_.emplace_back(Kind{kind, where}) : *found;
  ++known.count;
}

std::string LeftOut::InBrackets() const {
  std::vector<std::string> warnings;
  AppendTo(warnings);
  return warnings.empty() ? "" : fmt::format(" ({})", warnings.front());
}

void LeftOut::AppendTo(std::vector<std::string>& warnings) const {
  for (const Kind& kind : kinds_)
    warnings.push_back(kind.count == 1 ? fmt::format("{}: {} is left out", kind.first, kind.name)
                                       : fmt::format("{}: {} is left out, the first of {} such places", kind.first,
                                                     kind.name, kind.count));
}

}  // namespace lake::exchange
