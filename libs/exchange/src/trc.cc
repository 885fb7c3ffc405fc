#include "lake/exchange/trc.h"

#include <array>
#include <cmath>
#include <map>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "text_lines.h"

namespace lake {
namespace {

constexpr std::array kKeys = {"DataRate", "CameraRate",   "NumFrames",          "NumMarkers",
                              "Units",    "OrigDataRate", "OrigDataStartFrame", "OrigNumFrames"};
constexpr std::size_t kMostMarkers = 10000, kMostFrames = 10'000'000;

struct TrcHeader {
  std::size_t frames = 0, markers = 0;
  double mm_per_unit = 1;
  std::vector<std::string> names;
  std::size_t first_row = 0;  // index of the line
};

double MmPerUnit(const std::string& unit, const std::string& where) {
  static const std::map<std::string, double> kUnits = {{"mm", 1.0}, {"cm", 10.0}, {"m", 1000.0}};
  const auto found = kUnits.find(unit);
  if (found == kUnits.end()) throw Fail("{}: the unit '{}' is not mm, cm or m", where, unit);
  return found->second;
}

TrcHeader ReadHeader(const TextLines& lines, const std::filesystem::path& path) {
  if (lines.Count() < 5 || !lines[0].starts_with("PathFileType"))
    throw Fail("{}: not a TRC file: its first line must begin with PathFileType", path.string());
  const std::vector<std::string> keys = SplitCells(lines[1], '\t'), values = SplitCells(lines[2], '\t');
  std::map<std::string, std::string> header;
  for (std::size_t i = 0; i < keys.size() && i < values.size(); ++i) header[keys[i]] = values[i];
  for (const char* key : {"NumFrames", "NumMarkers", "Units"})
    if (!header.contains(key)) throw Fail("{}: the header has no {}", lines.Where(1), key);

  TrcHeader trc;
  trc.frames = ParseCount(header["NumFrames"], "NumFrames", lines.Where(2), kMostFrames);
  trc.markers = ParseCount(header["NumMarkers"], "NumMarkers", lines.Where(2), kMostMarkers);
  trc.mm_per_unit = MmPerUnit(header["Units"], lines.Where(2));
  const std::vector<std::string> names = SplitCells(lines[3], '\t');
  for (std::size_t i = 2; i < names.size(); ++i)
    if (!names[i].empty()) trc.names.push_back(names[i]);
  if (trc.names.size() != trc.markers)
    throw Fail("{}: {} names, but NumMarkers is {}", lines.Where(3), trc.names.size(), trc.markers);
  trc.first_row = 5;
  return trc;
}

bool IsBlank(const std::string& line) {
  return line.find_first_not_of(" \t") == std::string::npos;
}

void ReadRow(const TextLines& lines, std::size_t line, const TrcHeader& header, PointRecording& recording) {
  const std::string where = lines.Where(line);
  const std::vector<std::string> cells = SplitCells(lines[line], '\t');
  const std::size_t width = 2 + 3 * header.markers;
  for (std::size_t i = width; i < cells.size(); ++i)
    if (!cells[i].empty())
      throw Fail("{}: {} cells, but {} markers need {}", where, cells.size(), header.markers, width);
  if (cells.size() < 2) throw Fail("{}: a frame number and a time are needed", where);
  recording.frame.push_back(std::llround(RequiredNumber(cells[0], where)) - 1);
  recording.time_s.push_back(RequiredNumber(cells[1], where));
  const std::size_t n = recording.time_s.size();
  if (n > 1 && recording.time_s[n - 1] <= recording.time_s[n - 2]) throw Fail("{}: the time does not increase", where);
  for (std::size_t m = 0; m < header.markers; ++m) {
    Eigen::Vector3d position = PointTrack::Missing();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t cell = 2 + 3 * m + axis;
      if (cell >= cells.size())
        continue;  // OpenSim leaves out the cells of markers that are missing at the end of a row
      if (const auto value = NumberOrMissing(cells[cell], where))
        position[static_cast<int>(axis)] = *value * header.mm_per_unit;
    }
    recording.points[m].positions.push_back(position.allFinite() ? position : PointTrack::Missing());
  }
}

}  // namespace

PointRecording ReadTrc(const std::filesystem::path& path) {
  const TextLines lines(path);
  const TrcHeader header = ReadHeader(lines, path);
  PointRecording recording;
  for (const std::string& name : header.names) {
    if (recording.Find(name)) throw Fail("{}: the name '{}' stands twice", lines.Where(3), name);
    recording.points.push_back({name, {}});
  }
  for (std::size_t line = header.first_row; line < lines.Count(); ++line)
    if (!IsBlank(lines[line])) ReadRow(lines, line, header, recording);
  if (recording.time_s.size() != header.frames)
    throw Fail("{}: {} rows, but the header says {} frames: is the file cut off?", path.string(),
               recording.time_s.size(), header.frames);
  return recording;
}

void WriteTrc(const std::filesystem::path& path, const PointRecording& points) {
  if (points.space == PointSpace::kImage)
    throw Fail("{}: TRC is in mm; px need a scale or a calibrated plane first", path.string());
  const std::string rate = FormatNumber(FrameRate(points.time_s));
  const std::size_t frames = points.time_s.size();
  std::string text = fmt::format("PathFileType\t4\t(X/Y/Z)\t{}\n", path.filename().string());
  for (std::size_t i = 0; i < kKeys.size(); ++i) text.append(i ? "\t" : "").append(kKeys[i]);
  text += fmt::format("\n{}\t{}\t{}\t{}\tmm\t{}\t{}\t{}\nFrame#\tTime", rate, rate, frames, points.points.size(), rate,
                      points.frame.empty() ? 1 : points.frame.front() + 1, frames);
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
        text.append("\t").append(last_missing ? "" : FormatNumber(point.positions[i][axis]));
    }
    text += last_missing ? "\t\n" : "\n";  // OpenSim counts the last missing cell only when a tab follows it
  }
  WriteTextFile(path, text);
}

}  // namespace lake
