// Kinovea (kinovea.org): its CSV of trajectories as it is written, and its text, which does not say its unit of length.
#include <utility>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/exchange/formats.h"
#include "readers.h"

namespace lake::exchange {
void ToSeconds(PointRecording& recording, const std::filesystem::path& path) {
  const double step = recording.time_s.size() < 2 ? 0 : MedianInterval(recording.time_s);
  if (step == 1)
    recording.warnings.push_back(
        fmt::format("{}: times that step by 1 are taken for ms (1000 Hz); of frames export ms", path.string()));
  for (double& time : recording.time_s) time /= step < 1 ? 1 : step < 1000 ? 1000 : 1e6;
}

void WriteKinovea(const std::filesystem::path& path, const PointRecording& points) {
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
  std::vector<PointRecording> tracks;
  std::vector<std::size_t> rows;
  std::string name;
  for (std::size_t line = 0; line <= lines.Count(); ++line) {
    const bool is_end = line == lines.Count();
    if (!is_end && !lines[line].empty() && !lines[line].starts_with('#')) {
      rows.push_back(line);
      continue;
    }
    if (!rows.empty()) {
      if (name.empty()) name = fmt::format("track{}", tracks.size() + 1);
      tracks.push_back(ReadPointTable(lines,
                                      {.separator = ' ',
                                       .time = 0,
                                       .points = {{std::exchange(name, ""), {1, 2}}},
                                       .mm_per_unit = options.mm_per_unit,
                                       .rows = std::exchange(rows, {})},
                                      path));
    }
    if (!is_end && lines[line].starts_with("# ")) name = lines[line].substr(2);
  }
  if (tracks.empty()) throw Fail("{}: Kinovea's text without a trajectory", path.string());
  PointRecording recording = JoinMarkers(tracks, path);
  ToSeconds(recording, path);
  return recording;
}

}  // namespace lake::exchange
