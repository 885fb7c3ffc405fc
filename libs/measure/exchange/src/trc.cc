// TRC, the marker format of OpenSim and Motion Analysis: tab-separated text, positions in three dimensions, y up as is
// the custom. Frames of the file count from 1.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/formats.h"
#include "readers.h"

namespace lake::exchange {
namespace {

constexpr std::array kKeys = {"DataRate", "CameraRate",   "NumFrames",          "NumMarkers",
                              "Units",    "OrigDataRate", "OrigDataStartFrame", "OrigNumFrames"};
// Where the parts of a file are (lines from 0), whose order all writers share; blank lines stand between them in some.
struct TrcLines {
  std::size_t labels = 0, first_row = 0;
  char separator = ' ';                       // of lines without tabs
  std::string keys_and_values;                // of the header
  std::map<std::string, std::string> header;  // each key, in small letters, with the value below it

  // Empty where the header has no such key.
  std::string Value(const std::string& key) const {
    const auto stated = header.find(Lower(key));
    return stated == header.end() ? "" : stated->second;
  }
};

// Of the lines without tabs, by the row of names, in which names may have commas where there are tabs.
char SeparatorBesideTabs(const std::string& names) {
  const std::size_t found = names.find('\t') == names.npos ? names.find_first_of(";,") : names.npos;
  return found == names.npos ? ' ' : names[found];
}

std::vector<std::string> CellsOf(const std::string& line, char separator) {
  return SplitCells(line, line.find('\t') == line.npos ? separator : '\t');
}

std::vector<std::string> Filled(std::vector<std::string> cells) {
  std::erase(cells, "");
  return cells;
}

// Some writers put two tabs after a value where one follows a key; some have blanks for tabs.
std::map<std::string, std::string> HeaderValues(std::vector<std::string> keys, std::vector<std::string> values) {
  if (Filled(keys).size() == Filled(values).size()) {
    keys = Filled(keys);
    values = Filled(values);
  }
  std::map<std::string, std::string> header;
  for (std::size_t i = 0; i < keys.size() && i < values.size(); ++i) header[keys[i]] = values[i];
  return header;
}

TrcLines FindLines(const TextLines& lines, const std::filesystem::path& path) {
  constexpr std::size_t kMostHeadLines = 50;
  TrcLines found;
  const std::size_t end = std::min(lines.Count(), kMostHeadLines);
  const auto are_labels = [&](std::size_t line) {  // "Frame#", "Field #"
    const std::string text = Lower(Trim(lines[line]));
    return text.starts_with("frame") || text.starts_with("field");
  };
  while (found.labels < end && !are_labels(found.labels)) ++found.labels;
  if (found.labels >= end)
    throw Fail(
        "{}: not a TRC file, the markers' text of Cortex, OpenSim and others: no row of names that begins with Frame#",
        path.string());
  found.separator = SeparatorBesideTabs(lines[found.labels]);
  std::size_t keys = found.labels;  // above the values
  for (std::size_t line = 0; line < found.labels; ++line) {
    const std::string text = Lower(lines[line]);
    if (text.find("nummarkers") != text.npos || text.find("units") != text.npos) {
      keys = line;
      found.keys_and_values = text;
    } else if (keys < line && found.header.empty() && !text.empty()) {
      found.header = HeaderValues(CellsOf(Lower(lines[keys]), found.separator), CellsOf(lines[line], found.separator));
      found.keys_and_values += '\t' + text;
    }
  }
  found.first_row = found.labels + 1;
  const auto is_row = [&](std::size_t line) { return CountIn(CellsOf(lines[line], found.separator)[0]).has_value(); };
  while (found.first_row < lines.Count() && !is_row(found.first_row)) ++found.first_row;
  return found;
}

// Of KNEE_x, KNEE_y, KNEE_z it is KNEE, and so of KNEE three times; empty for names of three markers.
std::string NameOfAxes(const std::string& x, const std::string& y, const std::string& z) {
  if (x == y && y == z) return x;
  const std::string stem = x.substr(0, x.size() - 1);
  const bool are_axes = Lower(x).back() == 'x' && Lower(y) == Lower(stem) + "y" && Lower(z) == Lower(stem) + "z";
  return are_axes ? stem.substr(0, stem.find_last_not_of(" _.:-") + 1) : "";
}

// Names stand over the first of their three columns, or, with fewer tabs between them, in the columns' order; or over
// each of the three.
std::vector<PointColumns> FindColumns(const std::vector<std::string>& labels, std::size_t width) {
  std::vector<PointColumns> columns;
  bool over_columns = true;
  for (std::size_t i = 2; i < labels.size(); ++i)
    if (!labels[i].empty()) over_columns = over_columns && (i - 2) % 3 == 0;
  for (std::size_t i = 2; i < labels.size(); ++i)
    if (!labels[i].empty()) {
      const std::size_t first = over_columns ? i : 2 + 3 * columns.size();
      columns.push_back({labels[i], {first, first + 1, first + 2}});
    }
  std::vector<PointColumns> of_axes;
  for (std::size_t i = 0; i + 2 < columns.size() && columns.size() % 3 == 0; i += 3)
    if (const std::string name = NameOfAxes(columns[i].name, columns[i + 1].name, columns[i + 2].name); !name.empty())
      of_axes.push_back({name, {2 + i, 3 + i, 4 + i}});
  return 3 * of_axes.size() == columns.size() && width < 3 * columns.size() ? of_axes : columns;
}

// What stands below its key, or else the word of the header that is a unit, as keys and values do not stand above each
// other in the files of all writers.
double UnitOf(const TrcLines& found, const TextLines& lines, std::vector<std::string>& warnings) {
  const std::string unit = found.Value("Units");
  if (const auto mm_per_unit = FindMmPerUnit(unit)) return *mm_per_unit;
  std::string words = found.keys_and_values;
  std::ranges::replace_if(
      words, [](char c) { return c == '\t' || c == ',' || c == ';'; }, ' ');
  for (const std::string& word : SplitCells(words, ' '))
    if (const auto mm_per_unit = FindMmPerUnit(word)) return *mm_per_unit;
  const std::string where = lines.Where(found.labels > 0 ? found.labels - 1 : 0);
  if (!unit.empty() && !ParseNumber(unit))
    throw Fail("{}: the unit '{}' is not a unit of length: write mm, cm or m there", where, unit);
  warnings.push_back(fmt::format("{}: the header says no unit (Units); mm is assumed, as is the custom", where));
  return 1;
}

// What the header counts otherwise than it is.
void CheckCount(const TrcLines& found, const char* key, const char* what, std::size_t count,
                const std::filesystem::path& path, std::vector<std::string>& warnings) {
  const std::optional<std::size_t> value = CountIn(found.Value(key));
  if (value != count)
    warnings.push_back(fmt::format("{}: the header {}, but there are {} {}: all are read", path.string(),
                                   value ? fmt::format("says {} {}", *value, what) : fmt::format("has no {}", key),
                                   count, what));
}

// Exporters that thin a recording out leave its old rate in the header; some write ms.
void CheckRate(const std::filesystem::path& path, double rate_hz, PointRecording& recording) {
  constexpr double kTolerance = 0.02;
  if (recording.time_s.size() < 3 || !(rate_hz > 0)) return;
  // Steps rounded to a millisecond spoil the median, a gap in the recording the mean: both must contradict the header.
  const double step_s = MedianInterval(recording.time_s), mean_hz = FrameRate(recording.time_s);
  if (std::abs(rate_hz * step_s / 1000 - 1) <= kTolerance) {
    for (double& time_s : recording.time_s) time_s /= 1000;
    recording.warnings.push_back(
        fmt::format("{}: its times are taken to be in ms, as the header says {:g} Hz", path.string(), rate_hz));
    return;
  }
  if (std::abs(rate_hz * step_s - 1) > kTolerance && std::abs(rate_hz / mean_hz - 1) > kTolerance)
    recording.warnings.push_back(
        fmt::format("{}: the header says {:g} Hz, but the rows are {} s apart ({} Hz); the time column is believed",
                    path.string(), rate_hz, SignificantText(step_s, 4), SignificantText(1 / step_s, 4)));
}

}  // namespace

PointRecording ReadTrc(const std::filesystem::path& path, const ReadOptions& /*options*/) {
  const TextLines lines(path);
  const TrcLines found = FindLines(lines, path);
  std::vector<std::string> warnings;
  const std::string first_row = found.first_row < lines.Count() ? lines[found.first_row] : "";
  bool is_unreadable = false;
  PointTable table{.space = PointSpace::kSpace,
                   .first_row = found.first_row,
                   .separator = first_row.find('\t') != std::string::npos ? '\t' : found.separator,
                   .time = 1,
                   .frame = 0,
                   .rate_hz = NumberIn(found.Value("DataRate"), is_unreadable).value_or(0),
                   .first_frame = 1,
                   .mm_per_unit = UnitOf(found, lines, warnings),
                   .zero_is_missing = true,
                   .names_all = true,
                   .stated_rows = CountIn(found.Value("NumFrames"))};
  table.points =
      FindColumns(CellsOf(lines[found.labels], found.separator), SplitCells(first_row, table.separator).size());
  if (table.points.empty()) throw Fail("{}: the row of labels names no marker", lines.Where(found.labels));
  PointRecording recording = ReadPointTable(lines, table, path);
  CheckCount(found, "NumMarkers", "markers", table.points.size(), path, warnings);
  CheckCount(found, "NumFrames", "frames", recording.time_s.size(), path, warnings);
  recording.warnings.insert(recording.warnings.begin(), warnings.begin(), warnings.end());
  CheckRate(path, table.rate_hz, recording);
  return recording;
}

void WriteTrc(const std::filesystem::path& path, const PointRecording& recording, const std::string& unit) {
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
