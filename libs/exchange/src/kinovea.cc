#include "lake/exchange/kinovea.h"

#include <algorithm>
#include <cmath>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "text_lines.h"

namespace lake {
namespace {

constexpr std::size_t kMostColumns = 10'000;

// Cells between separators; a quoted cell may hold the separator, and a quote as two.
std::vector<std::string> SplitQuoted(const std::string& line, char separator, const std::string& where) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      cells.back() += c, ++i;
    else if (c == '"')
      quoted = !quoted;
    else if (c == separator && !quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  if (quoted) throw Fail("{}: a quote is not closed", where);
  return cells;
}

// Comma; semicolon where the comma is the decimal point.
char FindSeparator(const std::string& header) {
  bool quoted = false;
  for (const char c : header) {
    if (c == '"') quoted = !quoted;
    if (c == ';' && !quoted) return ';';
  }
  return ',';
}

struct Column {
  std::string name;
  std::size_t x, y;
};

std::vector<Column> FindColumns(const std::vector<std::string>& header, const std::string& where) {
  std::vector<Column> columns;
  if (header.size() > kMostColumns) throw Fail("{}: {} columns, more than {}", where, header.size(), kMostColumns);
  for (std::size_t i = 1; i < header.size(); ++i) {
    if (!header[i].ends_with("/0/X")) continue;
    const std::string name = header[i].substr(0, header[i].size() - 4);
    const auto y = std::find(header.begin(), header.end(), name + "/0/Y");
    if (y == header.end()) throw Fail("{}: no column '{}/0/Y'", where, name);
    for (const Column& column : columns)
      if (column.name == name) throw Fail("{}: the name '{}' stands twice", where, name);
    columns.push_back({name, i, static_cast<std::size_t>(y - header.begin())});
  }
  if (columns.empty()) throw Fail("{}: no column NAME/0/X of Kinovea", where);
  return columns;
}

double SecondsPerUnit(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  return !steps.empty() && Median(steps) >= 1 ? 1e-3 : 1;
}

}  // namespace

bool IsKinovea(const std::filesystem::path& path) {
  const TextLines lines(path);
  return lines.Count() > 0 && lines[0].find("/0/X") != std::string::npos;
}

PointRecording ReadKinovea(const std::filesystem::path& path, double mm_per_unit) {
  const TextLines lines(path);
  if (lines.Count() == 0) throw Fail("{}: empty", path.string());
  const char separator = FindSeparator(lines[0]);
  const std::vector<std::string> header = SplitQuoted(lines[0], separator, lines.Where(0));
  const std::vector<Column> columns = FindColumns(header, lines.Where(0));
  PointRecording recording;
  recording.space = PointSpace::kPlane;
  for (const Column& column : columns) recording.points.push_back({column.name, {}});
  for (std::size_t i = 1; i < lines.Count(); ++i) {
    if (lines[i].empty()) continue;
    const std::vector<std::string> cells = SplitQuoted(lines[i], separator, lines.Where(i));
    if (cells.size() != header.size())
      throw Fail("{}: {} cells, but the header has {}", lines.Where(i), cells.size(), header.size());
    AppendTime(NumberOrMissing(cells[0], lines.Where(i)), lines.Where(i), recording.time_s);
    recording.frame.push_back(static_cast<std::int64_t>(recording.frame.size()));
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto x = NumberOrMissing(cells[columns[k].x], lines.Where(i)),
                 y = NumberOrMissing(cells[columns[k].y], lines.Where(i));
      recording.points[k].positions.push_back(x && y ? Eigen::Vector3d(*x * mm_per_unit, *y * mm_per_unit, 0)
                                                     : PointTrack::Missing());
    }
  }
  const double seconds = SecondsPerUnit(recording.time_s);
  for (double& time : recording.time_s) time *= seconds;
  return recording;
}

void WriteKinovea(const std::filesystem::path& path, const PointRecording& points) {
  if (points.space == PointSpace::kSpace) throw Fail("{}: Kinovea's table holds points of a plane only", path.string());
  std::string text = "\"Time\"";
  for (const PointTrack& point : points.points) {
    std::string name;
    for (const char c : point.name) name.append(c == '"' ? 2 : 1, c);
    text += fmt::format(",\"{}/0/X\",\"{}/0/Y\"", name, name);
  }
  text += "\n";
  for (std::size_t i = 0; i < points.time_s.size(); ++i) {
    text += fmt::format("\"{}\"", FormatNumber(1000 * points.time_s[i]));
    for (const PointTrack& point : points.points)
      for (int axis = 0; axis < 2; ++axis)
        text += point.positions[i].allFinite() ? fmt::format(",\"{}\"", FormatNumber(point.positions[i][axis])) : ",";
    text += "\n";
  }
  WriteTextFile(path, text);
}

}  // namespace lake
