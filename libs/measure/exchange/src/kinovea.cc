// Kinovea (kinovea.org): its CSV export of trajectories, of quoted cells with separators after the writer's locale, and
// its text. Neither says its unit of length; times of the CSV are in ms or s, as a frame lasts between 1 ms and 1 s.
#include "frame_points.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/exchange/formats.h"
#include "marker_files.h"
#include "point_table.h"

namespace lake::exchange {
namespace {

std::vector<PointColumns> FindColumns(const std::vector<std::string>& header, const std::string& where) {
  std::vector<PointColumns> columns;
  for (std::size_t i = 1; i < header.size(); ++i) {
    if (!header[i].ends_with("/0/X")) continue;
    const std::string name = header[i].substr(0, header[i].size() - 4);
    if (i + 1 == header.size() || header[i + 1] != name + "/0/Y")
      throw Fail("{}: no column '{}/0/Y' follows '{}'", where, name, header[i]);
    columns.push_back({name, {i, i + 1}});
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

PointRecording ReadKinovea(const std::filesystem::path& path, const ReadOptions& options) {
  const TextLines lines(path);
  if (lines.Count() == 0) throw Fail("{}: empty", path.string());
  const char separator = SeparatorOf(lines[0]);
  PointRecording recording = ReadPointTable(lines,
                                            {.separator = separator,
                                             .time = 0,
                                             .points = FindColumns(SplitCells(lines[0], separator), lines.Where(0)),
                                             .mm_per_unit = options.mm_per_unit},
                                            path);
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
  const PointRecording drawn = AsDrawn(points);
  for (std::size_t i = 0; i < points.time_s.size(); ++i) {
    text += fmt::format("\"{}\"", FormatNumber(1000 * points.time_s[i]));
    for (const PointTrack& point : drawn.points)
      for (int axis = 0; axis < 2; ++axis)
        text += point.positions[i].allFinite() ? fmt::format(",\"{}\"", FormatNumber(point.positions[i][axis])) : ",";
    text += "\n";
  }
  WriteTextFile(path, text);
}

// Its text: "# NAME" above the rows "time x y" of each trajectory, with decimal points or commas.
PointRecording ReadKinoveaText(const std::filesystem::path& path, const ReadOptions& options) {
  const TextLines lines(path);
  const auto is_row = [&](std::size_t line) { return !lines[line].empty() && !lines[line].starts_with('#'); };
  std::vector<PointRecording> tracks;
  std::string name;
  for (std::size_t line = 0, end = 0; line < lines.Count(); line = end) {
    for (end = line; end < lines.Count() && is_row(end);) ++end;
    if (end == line) {
      if (lines[end++].starts_with("# ")) name = lines[line].substr(2);
      continue;
    }
    const PointColumns point{name.empty() ? fmt::format("track{}", tracks.size() + 1) : name, {1, 2}};
    tracks.push_back(ReadPointTable(lines,
                                    {.first_row = line,
                                     .end_row = end,
                                     .separator = ' ',
                                     .time = 0,
                                     .points = {point},
                                     .mm_per_unit = options.mm_per_unit},
                                    path));
    name.clear();
  }
  if (tracks.empty()) throw Fail("{}: Kinovea's text without a trajectory", path.string());
  return JoinMarkers(tracks, path);
}

}  // namespace lake::exchange
