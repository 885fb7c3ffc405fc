#include "lake/exchange/trc.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "text_lines.h"

namespace lake::exchange {
namespace {

constexpr std::array kKeys = {"DataRate", "CameraRate",   "NumFrames",          "NumMarkers",
                              "Units",    "OrigDataRate", "OrigDataStartFrame", "OrigNumFrames"};
constexpr std::size_t kMostMarkers = 10000;
constexpr std::size_t kFirstRow = 5;  // index of the line after the head

struct TrcHeader {
  std::size_t frames = 0, markers = 0;
  double mm_per_unit = 1;
  std::optional<double> rate_hz;
  std::vector<std::string> names;
  std::vector<std::string> warnings;
};

bool IsBlank(const std::string& line) {
  return line.find_first_not_of(" \t") == std::string::npos;
}

// Each key with the value below it; some writers put two tabs after a value where one follows a key.
std::map<std::string, std::string> HeaderValues(const TextLines& lines) {
  std::vector<std::string> keys = SplitCells(lines[1], '\t'), values = SplitCells(lines[2], '\t');
  const auto filled = [](std::vector<std::string> cells) {
    std::erase(cells, "");
    return cells;
  };
  if (filled(keys).size() == filled(values).size()) {
    keys = filled(keys);
    values = filled(values);
  }
  std::map<std::string, std::string> header;
  for (std::size_t i = 0; i < keys.size() && i < values.size(); ++i) header[keys[i]] = values[i];
  return header;
}

// The markers that the widest row of numbers has cells for; 0 where it ends within a marker.
std::size_t MarkersInRows(const TextLines& lines) {
  std::size_t width = 0;
  for (std::size_t line = kFirstRow; line < lines.Count(); ++line) {
    const std::vector<std::string> cells = SplitCells(lines[line], '\t');
    const auto last = std::find_if(cells.rbegin(), cells.rend(), [](const std::string& cell) { return !cell.empty(); });
    width = std::max(width, static_cast<std::size_t>(cells.rend() - last));
  }
  return width > 2 && (width - 2) % 3 == 0 ? (width - 2) / 3 : 0;
}

TrcHeader ReadHeader(const TextLines& lines, const std::filesystem::path& path) {
  if (lines.Count() < kFirstRow || !lines[0].starts_with("PathFileType"))
    throw Fail("{}: not a TRC file: its first line must begin with PathFileType", path.string());
  std::map<std::string, std::string> header = HeaderValues(lines);
  for (const char* key : {"NumFrames", "NumMarkers", "Units"})
    if (!header.contains(key)) throw Fail("{}: the header has no {}", lines.Where(1), key);

  TrcHeader trc;
  trc.frames = ParseCount(header["NumFrames"], "NumFrames", lines.Where(2), kMostFrames);
  trc.markers = ParseCount(header["NumMarkers"], "NumMarkers", lines.Where(2), kMostMarkers);
  const std::optional<double> mm_per_unit = FindMmPerUnit(header["Units"]);
  if (!mm_per_unit) throw Fail("{}: the unit '{}' is not mm, cm or m", lines.Where(2), header["Units"]);
  trc.mm_per_unit = *mm_per_unit;
  if (header.contains("DataRate")) trc.rate_hz = NumberOrMissing(header["DataRate"], lines.Where(2));
  const std::vector<std::string> names = SplitCells(lines[3], '\t');
  for (std::size_t i = 2; i < names.size(); ++i)
    if (!names[i].empty()) trc.names.push_back(names[i]);
  if (trc.names.size() != trc.markers) {
    // Cortex counts (and labels, in some versions) the markers of its template only, and writes names and columns of
    // all.
    if (trc.names.size() < trc.markers || trc.names.size() != MarkersInRows(lines))
      throw Fail("{}: {} names, but NumMarkers is {}", lines.Where(3), trc.names.size(), trc.markers);
    trc.warnings.push_back(
        fmt::format("{}: the header says {} markers, but there are names and columns of {}: all are read",
                    path.string(), trc.markers, trc.names.size()));
    trc.markers = trc.names.size();
  }
  return trc;
}

void ReadRow(const TextLines& lines, std::size_t line, const TrcHeader& header, PointRecording& recording) {
  const std::string where = lines.Where(line);
  const std::vector<std::string> cells = SplitCells(lines[line], '\t');
  const std::size_t width = 2 + 3 * header.markers;
  for (std::size_t i = width; i < cells.size(); ++i)
    if (!cells[i].empty())
      throw Fail("{}: {} cells, but {} markers need {}", where, cells.size(), header.markers, width);
  if (cells.size() < 2) throw Fail("{}: a frame number and a time are needed", where);
  recording.frame.push_back(static_cast<std::int64_t>(ParseCount(cells[0], "the frame", where, kMostFrames)) - 1);
  AppendTime(NumberOrMissing(cells[1], where), where, recording.time_s);
  for (std::size_t m = 0; m < header.markers; ++m) {
    Eigen::Vector3d position = PointTrack::Missing();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t cell = 2 + 3 * m + axis;
      if (cell >= cells.size())
        continue;  // OpenSim leaves out the cells of markers that are missing at the end of a row
      if (const auto value = NumberOrMissing(cells[cell], where))
        position[static_cast<int>(axis)] = *value * header.mm_per_unit;
    }
    // Some writers mark a missing marker by zeros, as in C3D.
    recording.points[m].positions.push_back(position.allFinite() && !position.isZero(0) ? position
                                                                                        : PointTrack::Missing());
  }
}

// Exporters that thin a recording out leave its old rate in the header.
void CheckRate(const std::filesystem::path& path, const TrcHeader& header, PointRecording& recording) {
  constexpr double kTolerance = 0.02;
  if (recording.time_s.size() < 3 || !header.rate_hz) return;
  // Steps rounded to a millisecond spoil the median, a gap in the recording the mean: both must contradict the header.
  const double step_s = MedianInterval(recording.time_s), rate_hz = FrameRate(recording.time_s);
  if (std::abs(*header.rate_hz * step_s - 1) > kTolerance && std::abs(*header.rate_hz / rate_hz - 1) > kTolerance)
    recording.warnings.push_back(
        fmt::format("{}: the header says {:g} Hz, but the rows are {} s apart ({} Hz); the time column is believed",
                    path.string(), *header.rate_hz, SignificantText(step_s, 4), SignificantText(1 / step_s, 4)));
}

}  // namespace

PointRecording ReadTrc(const std::filesystem::path& path) {
  const TextLines lines(path);
  const TrcHeader header = ReadHeader(lines, path);
  PointRecording recording;
  recording.warnings = header.warnings;
  AddPoints(header.names, lines.Where(3), recording);
  for (std::size_t line = kFirstRow; line < lines.Count(); ++line)
    if (!IsBlank(lines[line])) ReadRow(lines, line, header, recording);
  if (recording.time_s.size() != header.frames)
    throw Fail("{}: {} rows, but the header says {} frames: is the file cut off?", path.string(),
               recording.time_s.size(), header.frames);
  if (!recording.frame.empty() && recording.frame.front() < 0)  // a writer that counts from 0
    for (std::int64_t& frame : recording.frame) ++frame;
  CheckRate(path, header, recording);
  return recording;
}

void WriteTrc(const std::filesystem::path& path, const PointRecording& recording, const std::string& unit) {
  if (recording.space == PointSpace::kImage)
    throw Fail("{}: TRC is in mm, and these positions in px: give --scale, or a --camera with the sagittal plane",
               path.string());
  CheckNames(recording, path);
  const std::optional<double> mm_per_unit = FindMmPerUnit(unit);
  if (!mm_per_unit) throw UsageError("unit '{}': mm, cm or m", unit);
  const PointRecording points = PointsTurnedUp(recording, 'y');
  const std::string rate = FormatNumber(FrameRate(points.time_s));
  const std::size_t frames = points.time_s.size();
  std::string text = fmt::format("PathFileType\t4\t(X/Y/Z)\t{}\n", path.filename().string());
  for (std::size_t i = 0; i < kKeys.size(); ++i) text.append(i ? "\t" : "").append(kKeys[i]);
  text += fmt::format("\n{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\nFrame#\tTime", rate, rate, frames, points.points.size(), unit,
                      rate, points.frame.empty() ? 1 : points.frame.front() + 1, frames);
  for (std::size_t m = 0; m < points.points.size(); ++m) text.append(m ? "\t\t\t" : "\t").append(points.points[m].name);
  text += "\n\t";
  for (std::size_t m = 1; m <= points.points.size(); ++m) text += fmt::format("\tX{}\tY{}\tZ{}", m, m, m);
  text += "\n";
  for (std::size_t i = 0; i < frames; ++i) {
    text += fmt::format("{}\t{}", points.frame[i] + 1, FormatNumber(points.time_s[i]));
    bool last_missing = false;
    for (const PointTrack& point : points.points) {
      last_missing = !point.positions[i].allFinite();
      for (int axis = 0; axis < 3; ++axis)
        text.append("\t").append(last_missing ? "" : FormatNumber(point.positions[i][axis] / *mm_per_unit));
    }
    text += last_missing ? "\t\n" : "\n";  // OpenSim counts the last missing cell only when a tab follows it
  }
  WriteTextFile(path, text);
}

}  // namespace lake::exchange
