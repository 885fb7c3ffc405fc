#include <cmath>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "lake/actuator/duty_video.h"
#include "lake/actuator/serial_frame.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::actuator {
namespace {

// Columns of interest of a log's header.
struct Columns {
  std::size_t time = 0, duty = 0, stroke = 0, width = 0;
};

std::size_t Find(const std::vector<std::string>& header, std::string_view name) {
  std::size_t i = 0;
  while (i < header.size() && header[i] != name) ++i;
  return i;
}

Columns FindColumns(const std::vector<std::string>& header, const char* stroke, const std::string& where) {
  Columns columns{
      .time = Find(header, "time_s"), .duty = Find(header, "duty"), .stroke = header.size(), .width = header.size()};
  if (columns.time == header.size() || columns.duty == header.size())
    throw Fail("{}: no header with the columns time_s and duty", where);
  if (!stroke) return columns;
  columns.stroke = Find(header, stroke);
  if (columns.stroke == header.size())
    throw Fail(
        "{}: no column '{}'; the log must hold measured strokes: stroke_mm, or adc with --pot C0=MM0,C1=MM1, or a "
        "video with --video",
        where, stroke);
  return columns;
}

double Number(const std::string& cell, const char* column, const std::string& where) {
  const auto value = ParseNumber(cell);
  if (!value) throw Fail("{}: {} '{}' is not a number", where, column, cell);
  return *value;
}

// One row; `stroke` names the column of the stroke, 0: none is read.
void AddRow(DutyLog& log, const std::vector<std::string>& cells, const Columns& columns, const char* stroke,
            const std::string& where) {
  if (cells.size() != columns.width)
    throw Fail("{}: {} cells under a header of {}", where, cells.size(), columns.width);
  if (stroke && cells[columns.stroke].empty()) return;
  const double time = Number(cells[columns.time], "time_s", where);
  const double duty = Number(cells[columns.duty], "duty", where);
  if (!log.time_s.empty() && !(time > log.time_s.back()))
    throw Fail("{}: the times must ascend; {} s after {} s does not", where, time, log.time_s.back());
  if (!(std::abs(duty) <= 1)) throw Fail("{}: duty {} is not within -1..1", where, duty);
  log.time_s.push_back(time);
  log.duty.push_back(duty);
  if (stroke) log.stroke_mm.push_back(Number(cells[columns.stroke], stroke, where));
}

// SplitText gives no last part for a trailing empty cell of a text that is empty altogether; a row is never that.
std::vector<std::string> Cells(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return SplitText(line, ',');
}

// What stands between the firmware's rows: replies, alarms, messages and status; and comments.
bool IsRemark(const std::string& line) {
  if (const std::string_view word = Trim(line); word.empty() || word == "ok") return true;
  return std::string_view("#<[").find(line.front()) != std::string_view::npos || line.starts_with("error:") ||
         line.starts_with("ALARM:");
}

// As a terminal logged it: `…*HHHH`.
bool HasCheckSum(const std::string& line) {
  static const std::regex at_the_end("\\*[0-9A-F]{4}\\r?$");
  return line.find('*') != std::string::npos && std::regex_search(line, at_the_end);
}

std::string WithoutCheckSum(std::string line, const std::string& where) {
  if (line.back() == '\r') line.pop_back();
  const std::optional<std::string> text = Unframed(line);
  if (!text) throw Fail("{}: the line's check sum is wrong: it was damaged on its way; take it out", where);
  return *text;
}

DutyLog ReadRows(const std::filesystem::path& path, const char* stroke) {
  const std::string text = ReadTextFile(path, std::size_t{1} << 28);
  DutyLog log{.name = path.string(), .time_s = {}, .stroke_mm = {}, .duty = {}};
  std::optional<Columns> columns;
  std::size_t number = 0, begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    const std::string where = fmt::format("{}:{}", path.string(), ++number);
    if (HasCheckSum(line)) line = WithoutCheckSum(line, where);
    if (IsRemark(line)) continue;
    const std::vector<std::string> cells = Cells(line);
    if (!columns || cells.front() == "time_s")
      columns = FindColumns(cells, stroke, where);
    else
      AddRow(log, cells, *columns, stroke, where);
  }
  if (!columns) throw Fail("{}: empty; a log has the columns time_s,stroke_mm,duty", path.string());
  return log;
}

}  // namespace

PotentiometerScale ParsePotentiometerScale(const std::string& text) {
  const std::vector<std::string> points = SplitText(text, ',');
  std::vector<double> numbers;
  for (const std::string& point : points)
    for (const std::string& part : SplitText(point, '='))
      if (const auto number = ParseNumber(part)) numbers.push_back(*number);
  if (points.size() != 2 || numbers.size() != 4 || numbers[0] == numbers[2] || numbers[1] == numbers[3])
    throw UsageError("--pot '{}': give two different points COUNTS=MM,COUNTS=MM, e.g. 102=242,921=372", text);
  return {.counts_a = numbers[0], .mm_a = numbers[1], .counts_b = numbers[2], .mm_b = numbers[3]};
}

DutyLog ReadDutyLog(const std::filesystem::path& path, const std::optional<PotentiometerScale>& scale) {
  DutyLog log = ReadRows(path, scale ? "adc" : "stroke_mm");
  if (scale)
    for (double& stroke : log.stroke_mm)
      stroke =
          scale->mm_a + (stroke - scale->counts_a) * (scale->mm_b - scale->mm_a) / (scale->counts_b - scale->counts_a);
  return log;
}

DutyCommands ReadDutyCommands(const std::filesystem::path& path) {
  DutyLog log = ReadRows(path, nullptr);
  return {std::move(log.name), std::move(log.time_s), std::move(log.duty)};
}

}  // namespace lake::actuator
