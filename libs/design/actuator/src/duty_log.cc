// Logs of duties, and the video that has their strokes.
#include <algorithm>
#include <cmath>
#include <optional>
#include <regex>

#include "lake/actuator/duty_calibration.h"
#include "lake/actuator/stroke_session.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/numbers.h"

namespace lake::actuator {
namespace {

// What stands between the firmware's rows: replies, alarms, messages and status; and comments.
bool IsRemark(const std::string& line) {
  if (const std::string_view word = Trim(line); word.empty() || word == "ok") return true;
  return std::string_view("#<[").find(line.front()) != std::string_view::npos || line.starts_with("error:") ||
         line.starts_with("ALARM:");
}

// A line as a terminal logged it, `…*HHHH`, without its check sum.
std::string WithoutCheckSum(std::string line, const std::string& where) {
  static const std::regex check_sum("\\*[0-9A-F]{4}$");
  if (line.ends_with('\r')) line.pop_back();
  if (line.find('*') == std::string::npos || !std::regex_search(line, check_sum)) return line;
  const std::optional<std::string> text = Unframed(line);
  if (!text) throw Fail("{}: the line's check sum is wrong: it was damaged on its way; take it out", where);
  return *text;
}

// The header and the rows alone; other lines are left empty, so that messages name the right one.
CsvTable ReadTable(const std::filesystem::path& path) {
  const std::string text = ReadTextFile(path, std::size_t{1} << 28);
  std::string rows, header;
  std::size_t number = 0;
  for (std::size_t begin = 0, end = 0; begin < text.size(); begin = end + 1) {
    end = std::min(text.find('\n', begin), text.size());
    const std::string where = fmt::format("{}:{}", path.string(), ++number);
    const std::string line = WithoutCheckSum(text.substr(begin, end - begin), where);
    const bool is_row = !IsRemark(line), is_header = is_row && header.empty();
    if (is_header && (line.find("time_s") == std::string::npos || line.find("duty") == std::string::npos))
      throw Fail("{}: no header with the columns time_s and duty", where);
    if (is_row && line != header) rows += line;
    if (is_header) header = line;
    rows += '\n';
  }
  if (header.empty()) throw Fail("{}: empty; a log has the columns time_s,stroke_mm,duty", path.string());
  return CsvTable::Parse(rows, path);
}

// `stroke` names the column of the stroke, whose empty cells leave their rows out; null: none is read.
DutyLog ReadRows(const std::filesystem::path& path, const char* stroke) {
  const CsvTable table = ReadTable(path);
  const std::size_t time_s = table.Column("time_s"), duty = table.Column("duty");
  if (stroke && !table.Has(stroke))
    throw Fail(
        "{}: no column '{}'; the log must hold measured strokes: stroke_mm, or adc with --pot C0=MM0,C1=MM1, or a "
        "video with --video",
        path.string(), stroke);
  DutyLog log{.name = path.string(), .time_s = {}, .stroke_mm = {}, .duty = {}};
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const std::optional<double> stroke_mm = stroke ? table.Number(row, table.Column(stroke)) : 0;
    if (!stroke_mm) continue;
    const double now_s = table.RequiredNumber(row, time_s), driven = table.RequiredNumber(row, duty);
    if (!log.time_s.empty() && !(now_s > log.time_s.back()))
      throw Fail("{}: the times must ascend; {} s after {} s does not", table.Where(row), now_s, log.time_s.back());
    if (!(std::abs(driven) <= 1)) throw Fail("{}: duty {} is not within -1..1", table.Where(row), driven);
    log.time_s.push_back(now_s);
    log.duty.push_back(driven);
    if (stroke) log.stroke_mm.push_back(*stroke_mm);
  }
  return log;
}

constexpr std::size_t kFewest = 20;  // rows of the log, frames of the film
constexpr double kShiftStep_s = 0.005;
constexpr double kSpeedWindow_s = 0.1;  // to either side, for the film's speed
constexpr double kLeastCorrelation = 0.7;
constexpr double kLongestGap_s = 1;  // between rows of the log, across which a duty is taken to last

// The duty that rows before and after a time share; NaN where they do not, or there is none.
double DutyAt(const DutyLog& commands, double time_s) {
  const auto after = std::upper_bound(commands.time_s.begin(), commands.time_s.end(), time_s);
  if (after == commands.time_s.begin() || after == commands.time_s.end()) return kNaN;
  const auto i = static_cast<std::size_t>(after - commands.time_s.begin());
  if (commands.time_s[i] - commands.time_s[i - 1] > kLongestGap_s) return kNaN;
  return commands.duty[i] == commands.duty[i - 1] ? commands.duty[i] : kNaN;
}

struct SpeedSample {
  double time_s, speed_mm_s;
};

std::vector<SpeedSample> SpeedsOf(const StrokeSeries& film) {
  std::vector<SpeedSample> speeds;
  auto before = film.knots.begin(), after = before;
  for (const linkage::StrokeProgram::Knot& knot : film.knots) {
    while (before->time_s < knot.time_s - kSpeedWindow_s) ++before;
    while (after + 1 < film.knots.end() && (after + 1)->time_s <= knot.time_s + kSpeedWindow_s) ++after;
    if (after->time_s - before->time_s >= kSpeedWindow_s) speeds.push_back({knot.time_s, SpeedOf(*before, *after)});
  }
  return speeds;
}

struct Agreement {
  double product = 0, correlation = 0;
};

Agreement AgreementAt(const DutyLog& commands, const std::vector<SpeedSample>& speeds, double shift_s) {
  double product = 0, duties = 0, squares = 0;
  for (const SpeedSample& sample : speeds) {
    const double duty = DutyAt(commands, sample.time_s + shift_s);
    if (std::isnan(duty)) continue;
    product += duty * sample.speed_mm_s;
    duties += duty * duty;
    squares += sample.speed_mm_s * sample.speed_mm_s;
  }
  return {product, duties > 0 && squares > 0 ? product / std::sqrt(duties * squares) : 0};
}

void Check(const DutyLog& commands, const StrokeSeries& film, const std::vector<SpeedSample>& speeds) {
  if (commands.time_s.size() < kFewest)
    throw Fail("{}: {} rows are too few to be aligned with a video", commands.name, commands.time_s.size());
  if (film.knots.size() < kFewest || speeds.size() < kFewest)
    throw Fail("{} frames with the actuator's two markers are too few to be aligned with a log", film.knots.size());
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

DutyLog ReadDutyCommands(const std::filesystem::path& path) {
  return ReadRows(path, nullptr);
}

AlignedLog AlignWithFilm(const DutyLog& commands, const StrokeSeries& film) {
  const std::vector<SpeedSample> speeds = SpeedsOf(film);
  Check(commands, film, speeds);
  AlignedLog aligned;
  double most = -1;
  const double low = commands.time_s.front() - film.knots.back().time_s,
               high = commands.time_s.back() - film.knots.front().time_s;
  for (int i = 0; low + i * kShiftStep_s <= high; ++i) {
    ThrowIfInterrupted();
    const double shift = low + i * kShiftStep_s;
    const Agreement agreement = AgreementAt(commands, speeds, shift);
    if (std::abs(agreement.product) <= most) continue;
    most = std::abs(agreement.product);
    aligned.shift_s = shift;
    aligned.correlation = agreement.correlation;
  }
  if (std::abs(aligned.correlation) < kLeastCorrelation)
    throw Fail("{}: its duties and the speeds of the video agree nowhere (correlation {:.2f}); are they of one run?",
               commands.name, aligned.correlation);
  aligned.log.name = commands.name;
  for (const linkage::StrokeProgram::Knot& knot : film.knots) {
    const double time = knot.time_s + aligned.shift_s, duty = DutyAt(commands, time);
    if (std::isnan(duty)) continue;
    aligned.log.time_s.push_back(time);
    aligned.log.duty.push_back(duty);
    aligned.log.stroke_mm.push_back(knot.stroke_mm);
  }
  return aligned;
}

}  // namespace lake::actuator
