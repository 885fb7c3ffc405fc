#include "lake/exchange/mot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "readers.h"

namespace lake::exchange {
namespace {

// Cells of a row; trailing tabs do not count.
std::vector<std::string> RowCells(const std::string& line) {
  std::vector<std::string> cells = SplitCells(line, '\t');
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  return cells;
}

struct MotHeader {
  std::optional<std::size_t> rows, columns;
  std::optional<bool> in_degrees;
  bool is_simm = false;    // the form that OpenSim took over from SIMM, whose angles are in degrees
  std::size_t labels = 0;  // index of the line after endheader
};

// What a line of the header, in small letters, says of the unit of angles: "indegrees=yes", or a sentence such as
// "angles are in degrees." nullopt if it says nothing, or names both units, as OpenSim's explanation of the key does.
std::optional<bool> UnitOfAngles(const std::string& line, const std::string& where) {
  constexpr std::string_view kKey = "indegrees";
  if (line.starts_with(kKey)) {
    const std::size_t begin = line.find_first_not_of("=: \t", kKey.size());
    const std::string value = begin == std::string::npos ? "" : line.substr(begin), word = fmt::format(" {} ", value);
    const bool is_yes = std::string_view(" yes y true t 1 ").find(word) != std::string_view::npos;
    if (!is_yes && std::string_view(" no n false f 0 ").find(word) == std::string_view::npos)
      throw Fail("{}: inDegrees is '{}'; write inDegrees=yes or inDegrees=no", where, value);
    return is_yes;
  }
  const bool degrees = line.find("degree") != std::string::npos, radians = line.find("radian") != std::string::npos;
  return degrees == radians ? std::nullopt : std::optional(degrees);
}

// "nRows=73", and the older "datarows 73" beside it.
MotHeader ReadHeader(const TextLines& lines, const std::filesystem::path& path, MotTable& table) {
  MotHeader header;
  for (std::size_t i = 0; i < lines.Count(); ++i) {
    std::string line = lines[i].substr(0, lines[i].find_last_not_of("\t ") + 1);
    if (i == 0) table.name = line;
    const std::string lower = Lower(line);
    if (lower == "endheader") {
      header.labels = i + 1;
      table.in_degrees = header.in_degrees.value_or(header.is_simm);
      if (!header.in_degrees && !header.is_simm)
        table.warnings.push_back(fmt::format(
            "{}: does not say the unit of angles; radians are assumed, as OpenSim does; if they are degrees, write "
            "inDegrees=yes above endheader",
            path.string()));
      return header;
    }
    if (lower.find("simm motion file") != std::string::npos || lower.starts_with("datacolumns ")) header.is_simm = true;
    const auto value = [&] { return line.substr(line.find_first_of("= ") + 1); };
    if (lower.starts_with("nrows=") || lower.starts_with("datarows ")) header.rows = CountIn(value());
    if (lower.starts_with("ncolumns=") || lower.starts_with("datacolumns ")) header.columns = CountIn(value());
    if (i == 0 || lower.starts_with("name ")) continue;
    const std::optional<bool> in_degrees = UnitOfAngles(lower, lines.Where(i));
    if (in_degrees && header.in_degrees.value_or(*in_degrees) != *in_degrees)
      throw Fail("{}: says that angles are in {}, and a line above the opposite; write inDegrees=yes or inDegrees=no",
                 lines.Where(i), *in_degrees ? "degrees" : "radians");
    if (in_degrees) header.in_degrees = in_degrees;
  }
  throw Fail("{}: not a MOT or STO file of OpenSim: no line 'endheader' above its row of labels", path.string());
}

}  // namespace

std::size_t MotTable::Column(const std::string& column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) throw Fail("{}: no column '{}'", name, column);
  return static_cast<std::size_t>(found - columns.begin());
}

bool IsMot(const std::filesystem::path& path) {
  const std::string ending = Lower(path.extension().string());
  return ending == ".mot" || ending == ".sto";
}

MotTable ReadMot(const std::filesystem::path& path) {
  const TextLines lines(path);
  MotTable table;
  const MotHeader header = ReadHeader(lines, path, table);
  std::size_t line = header.labels;
  while (line < lines.Count() && RowCells(lines[line]).empty()) ++line;
  if (line == lines.Count()) throw Fail("{}: no row of labels after endheader", path.string());
  table.columns = RowCells(lines[line]);
  if (Lower(table.columns.front()) != "time")
    throw Fail("{}: the first column is '{}', not time", lines.Where(line), table.columns.front());
  const auto check = [&](const char* what, std::optional<std::size_t> stated, std::size_t count) {
    if (stated && *stated != count)
      table.warnings.push_back(
          fmt::format("{}: {} {}, but the header says {}: all are read", path.string(), count, what, *stated));
  };
  check("columns", header.columns, table.columns.size());
  table.columns.erase(table.columns.begin());
  PointTable values{
      .space = PointSpace::kSpace, .first_row = line + 1, .separator = '\t', .time = 0, .names_all = true};
  for (std::size_t c = 1; c <= table.columns.size(); ++c) values.points.push_back({std::to_string(c), {c}});
  const PointRecording read = ReadPointTable(lines, values, path);
  table.time_s = read.time_s;
  for (std::size_t i = 0; i < read.time_s.size(); ++i) {
    std::vector<double>& row = table.rows.emplace_back();
    for (const PointTrack& column : read.points) row.push_back(column.positions[i].x());
  }
  check("rows", header.rows, table.rows.size());
  std::ranges::copy(read.warnings, std::back_inserter(table.warnings));
  return table;
}

void WriteMot(const std::filesystem::path& path, const MotTable& table) {
  std::string text = fmt::format("{}\nversion=1\nnRows={}\nnColumns={}\ninDegrees={}\nendheader\ntime", table.name,
                                 table.rows.size(), table.columns.size() + 1, table.in_degrees ? "yes" : "no");
  for (const std::string& column : table.columns) text.append("\t").append(column);
  text += "\n";
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    text += FormatNumber(table.time_s[i]);
    for (const double value : table.rows[i])
      text.append("\t").append(std::isfinite(value) ? FormatNumber(value) : "NaN");
    text += "\n";
  }
  WriteTextFile(path, text);
}

MotTable MotFromLegMotion(const motion::LegMotion& motion, motion::Side leg, bool flexion_negative) {
  MotTable table;
  table.name = "knee angle";
  table.columns = {leg == motion::Side::kLeft ? "knee_angle_l" : "knee_angle_r",
                   "shank_tilt",
                   "thigh_tilt",
                   "trunk_tilt",
                   "repetition",
                   "percent"};
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    const motion::LegSample& sample = motion.samples[i];
    if (!std::isfinite(sample.knee_deg)) continue;
    table.time_s.push_back(motion.time_s[i]);
    table.rows.push_back({flexion_negative ? -sample.knee_deg : sample.knee_deg, sample.shank_deg, sample.thigh_deg,
                          sample.trunk_deg, static_cast<double>(sample.repetition.value_or(0)),
                          sample.repetition ? sample.percent : 0});
  }
  return table;
}

}  // namespace lake::exchange
