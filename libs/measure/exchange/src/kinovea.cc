#include "lake/exchange/kinovea.h"

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/exchange/formats.h"
#include "left_out.h"
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

// A number, or hours, minutes, seconds and hundredths: 0:00:01:25.
std::optional<double> TimeIn(const std::string& text, bool& is_unreadable) {
  const std::vector<std::string> parts = SplitText(text, ':');
  if (parts.size() != 4) return NumberIn(text, is_unreadable);
  double time_s = 0;
  for (const auto& [part, seconds] : {std::pair{0, 3600.0}, {1, 60.0}, {2, 1.0}, {3, 0.01}})
    time_s += seconds * NumberIn(parts[static_cast<std::size_t>(part)], is_unreadable).value_or(0);
  return time_s;
}

double SecondsPerUnit(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  return !steps.empty() && Median(steps) >= 1 ? 1e-3 : 1;
}

}  // namespace

PointRecording ReadKinovea(const std::filesystem::path& path, double mm_per_unit) {
  const TextLines lines(path);
  if (lines.Count() == 0) throw Fail("{}: empty", path.string());
  const char separator = SeparatorOf(lines[0]);
  PointRecording recording = ReadPointTable(lines,
                                            {.separator = separator,
                                             .time = 0,
                                             .points = FindColumns(SplitCells(lines[0], separator), lines.Where(0)),
                                             .mm_per_unit = mm_per_unit},
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
  for (std::size_t i = 0; i < points.time_s.size(); ++i) {
    text += fmt::format("\"{}\"", FormatNumber(1000 * points.time_s[i]));
    for (const PointTrack& point : points.points)
      for (int axis = 0; axis < 2; ++axis)
        text += point.positions[i].allFinite() ? fmt::format(",\"{}\"", FormatNumber(point.positions[i][axis])) : ",";
    text += "\n";
  }
  WriteTextFile(path, text);
}

// Its text: "# NAME" above the rows "time x y" of each trajectory, with decimal points or commas.
PointRecording ReadKinoveaText(const std::filesystem::path& path, const ReadOptions& options) {
  const TextLines lines(path);
  std::vector<PointRecording> tracks;
  LeftOut left_out;
  bool is_new = true;
  std::string name;
  for (std::size_t line = 0; line < lines.Count(); ++line) {
    const std::string& text = lines[line];
    std::vector<std::string> cells = SplitText(text, ' ');
    std::erase(cells, "");
    if (text.starts_with('#') || cells.empty()) {
      is_new = true;
      if (text.starts_with("# ")) name = text.substr(2);
      continue;
    }
    bool is_unreadable = cells.size() != 3;
    const auto time_s = is_unreadable ? std::nullopt : TimeIn(cells[0], is_unreadable);
    const auto x = is_unreadable ? std::nullopt : NumberIn(cells[1], is_unreadable),
               y = is_unreadable ? std::nullopt : NumberIn(cells[2], is_unreadable);
    if (is_new) {
      PointRecording& track = tracks.emplace_back();
      track.space = PointSpace::kPlane;
      track.points.push_back({name.empty() ? fmt::format("track{}", tracks.size()) : name, {}});
      name.clear();
      is_new = false;
    }
    PointRecording& track = tracks.back();
    if (is_unreadable || !time_s || !x || !y)
      left_out.Add("a row that is not 'time x y'", lines.Where(line));
    else if (!track.time_s.empty() && *time_s <= track.time_s.back())
      left_out.Add("a row whose time does not follow the one before", lines.Where(line));
    else {
      track.time_s.push_back(*time_s);
      track.points[0].positions.emplace_back(*x * options.mm_per_unit, *y * options.mm_per_unit, 0);
    }
  }
  std::erase_if(tracks, [](const PointRecording& track) { return track.time_s.empty(); });
  if (tracks.empty()) throw Fail("{}: Kinovea's text without a trajectory", path.string());
  PointRecording recording = JoinMarkers(tracks, path);
  left_out.AppendTo(recording.warnings);
  return recording;
}

}  // namespace lake::exchange
