#include "lake/exchange/kinovea.h"

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "text_lines.h"

namespace lake::exchange {
namespace {

struct Column {
  std::string name;
  std::size_t x, y;
};

std::vector<Column> FindColumns(const CsvTable& table, const std::filesystem::path& path) {
  std::vector<Column> columns;
  for (std::size_t i = 1; i < table.Header().size(); ++i) {
    const std::string& title = table.Header()[i];
    if (!title.ends_with("/0/X")) continue;
    const std::string name = title.substr(0, title.size() - 4);
    if (i + 1 == table.Header().size() || table.Header()[i + 1] != name + "/0/Y")
      throw Fail("{}:1: no column '{}/0/Y' follows '{}'", path.string(), name, title);
    columns.push_back({name, i, i + 1});
  }
  if (columns.empty()) throw Fail("{}:1: no column NAME/0/X of Kinovea", path.string());
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
  const CsvTable table = CsvTable::Read(path, ',', CsvTable::Twice::kAllowed);
  const std::vector<Column> columns = FindColumns(table, path);
  PointRecording recording;
  recording.space = PointSpace::kPlane;
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  AddPoints(std::move(names), lines.Where(0), recording);
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const std::string where = table.Where(row);
    AppendTime(NumberOrMissing(table.Text(row, 0), where), where, recording.time_s);
    recording.frame.push_back(static_cast<std::int64_t>(recording.frame.size()));
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto x = NumberOrMissing(table.Text(row, columns[k].x), where),
                 y = NumberOrMissing(table.Text(row, columns[k].y), where);
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

}  // namespace lake::exchange
