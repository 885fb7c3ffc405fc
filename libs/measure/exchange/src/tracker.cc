#include "lake/exchange/tracker.h"

#include <algorithm>

#include "frame_points.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "text_lines.h"

namespace lake::exchange {
namespace {

constexpr std::size_t kMostTracks = 10'000;

// The columns of one track.
struct TrackColumns {
  std::string name;
  std::size_t x, y;
};

// Names stand above their columns; a writer that leaves out empty cells is understood if there are as many names as
// tracks.
std::vector<TrackColumns> FindColumns(const std::vector<std::string>& labels, const std::vector<std::string>& names) {
  std::vector<TrackColumns> columns;
  for (std::size_t i = 1; i + 1 < labels.size(); ++i)
    if (labels[i] == "x" && labels[i + 1] == "y") columns.push_back({"", i, i + 1});
  std::vector<std::string> given;
  for (const std::string& name : names)
    if (!name.empty() && !name.starts_with('#')) given.push_back(name);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (given.size() == columns.size())
      columns[k].name = given[k];
    else if (columns[k].x < names.size())
      columns[k].name = names[columns[k].x];
    if (columns[k].name.empty()) columns[k].name = fmt::format("track{}", k + 1);
  }
  return columns;
}

// Tracker's own notation, 1.234567890E2: the digits that a double of this size needs at 1e-9 of itself.
std::string FormatForTracker(double value) {
  std::string text = fmt::format("{:.12E}", value);
  const std::size_t exponent = text.find('E');
  return text.substr(0, exponent + 1) + std::to_string(std::stoi(text.substr(exponent + 1)));
}

}  // namespace

PointRecording ReadTrackerText(const std::filesystem::path& path, double mm_per_unit) {
  const TextLines lines(path);
  std::size_t label_line = 0;
  const auto is_label_row = [&](std::size_t i) {
    const std::vector<std::string> cells = SplitCells(lines[i], '\t');
    return cells.size() >= 3 && cells[0] == "t" && std::find(cells.begin(), cells.end(), "x") != cells.end();
  };
  while (label_line < lines.Count() && !is_label_row(label_line)) ++label_line;
  if (label_line == lines.Count()) throw Fail("{}: not a table of Tracker: no row of labels 't, x, y'", path.string());
  const std::vector<TrackColumns> columns =
      FindColumns(SplitCells(lines[label_line], '\t'),
                  label_line > 0 ? SplitCells(lines[label_line - 1], '\t') : std::vector<std::string>{});
  if (columns.empty() || columns.size() > kMostTracks)
    throw Fail("{}: {} columns 'x' followed by 'y', not 1 to {}", lines.Where(label_line), columns.size(), kMostTracks);

  PointRecording recording;
  recording.space = PointSpace::kPlane;
  std::vector<std::string> names;
  for (const TrackColumns& column : columns) names.push_back(column.name);
  AddPoints(std::move(names), lines.Where(label_line), recording);
  for (std::size_t i = label_line + 1; i < lines.Count(); ++i) {
    const std::vector<std::string> cells = SplitCells(lines[i], '\t');
    if (cells.size() == 1 && cells[0].empty()) continue;
    const auto cell = [&](std::size_t c) {
      return c < cells.size() ? NumberOrMissing(cells[c], lines.Where(i)) : std::nullopt;
    };
    AppendTime(cell(0), lines.Where(i), recording.time_s);
    recording.frame.push_back(static_cast<std::int64_t>(recording.frame.size()));
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto x = cell(columns[k].x), y = cell(columns[k].y);
      recording.points[k].positions.push_back(x && y ? Eigen::Vector3d(*x * mm_per_unit, *y * mm_per_unit, 0)
                                                     : PointTrack::Missing());
    }
  }
  return recording;
}

void WriteTrackerText(const std::filesystem::path& path, const PointRecording& points) {
  if (points.space == PointSpace::kSpace)
    throw Fail("{}: a table of Tracker holds points of a plane only", path.string());
  CheckNames(points, path);
  const double offset = points.space == PointSpace::kImage ? kPixelCentre : 0;
  std::string text = points.points.size() > 1 ? "#multi:\n" : "", labels = "t";
  for (const PointTrack& point : points.points) {
    text.append("\t").append(point.name).append("\t");
    labels += "\tx\ty";
  }
  text.append("\n").append(labels).append("\n");
  for (std::size_t i = 0; i < points.time_s.size(); ++i) {
    text += FormatForTracker(points.time_s[i]);
    for (const PointTrack& point : points.points)
      for (int axis = 0; axis < 2; ++axis)
        text.append("\t").append(point.positions[i].allFinite() ? FormatForTracker(point.positions[i][axis] + offset)
                                                                : "");
    text += "\n";
  }
  WriteTextFile(path, text);
}

}  // namespace lake::exchange
