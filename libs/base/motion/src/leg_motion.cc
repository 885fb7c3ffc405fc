#include "lake/motion/leg_motion.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/motion/event_corrections.h"

namespace lake::motion {
namespace {

// A column of kinematics.csv; those that are not required are there where some frame has a value.
struct Column {
  std::string name;
  bool is_required;
  std::function<double&(LegSample&)> value;

  double Of(LegSample sample) const { return value(sample); }
};

Column ScalarColumn(std::string name, double LegSample::*value, bool is_required = true) {
  return {std::move(name), is_required, [value](LegSample& sample) -> double& { return sample.*value; }};
}

void AddVector(const Segment& segment, LengthUnit unit, std::vector<Column>& columns) {
  for (const int axis : {0, 1})
    columns.push_back(
        {fmt::format("{}_{}_{}", segment.vector_name, axis == 0 ? "x" : "y", ToString(unit)), !segment.Lies(),
         [vector = segment.vector, axis](LegSample& sample) -> double& { return (sample.*vector)[axis]; }});
}

// In the order of the file: the leg's, then their standard deviations and what further markers show.
std::vector<Column> ColumnsOf(LengthUnit unit) {
  std::vector<Column> columns, further;
  for (const Segment& segment : kSegments) AddVector(segment, unit, segment.Lies() ? further : columns);
  columns.push_back(ScalarColumn("knee_deg", &LegSample::knee_deg));
  columns.push_back(ScalarColumn("knee_sigma_deg", &LegSample::knee_sigma_deg));
  columns.push_back(ScalarColumn("knee_raw_deg", &LegSample::knee_raw_deg));
  for (const Angle& angle : Angles().subspan(1)) {
    const bool is_of_leg = std::ranges::any_of(
        kSegments, [&](const Segment& segment) { return !segment.Lies() && segment.angle.deg == angle.deg; });
    (is_of_leg ? columns : further).push_back(ScalarColumn(fmt::format("{}_deg", angle.name), angle.deg, is_of_leg));
    further.push_back(ScalarColumn(fmt::format("{}_sigma_deg", angle.name), angle.sigma_deg, false));
  }
  columns.push_back(ScalarColumn("knee_deg_s", &LegSample::knee_deg_s));
  std::ranges::move(further, std::back_inserter(columns));
  return columns;
}

// A column that follows from others: written where it is known in some frame, and not read back.
struct DerivedColumn {
  const char* name;
  double (*value)(const LegSample& sample);
};
constexpr DerivedColumn kDerivedColumns[] = {
    {"hip_deg", [](const LegSample& sample) { return sample.trunk_deg - sample.thigh_deg; }}};

bool IsLetter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

bool IsUpper(char c) {
  return std::isupper(static_cast<unsigned char>(c)) != 0;
}

// "lateral_ankle_r", "AnkleLeft" and "r.ASIS" in their words, in their own case; a run of capitals is one word.
std::vector<std::string> WordsOf(std::string_view marker) {
  std::vector<std::string> words;
  char before = ' ';
  for (const char c : marker) {
    const bool continues = IsLetter(before) && (IsUpper(before) || !IsUpper(c));
    if (IsLetter(c) && !continues) words.emplace_back();
    if (IsLetter(c)) words.back() += c;
    before = c;
  }
  return words;
}

std::string LowerCase(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// "l", "Left", "r"; nullopt for any other word.
std::optional<Side> SideOfWord(const std::string& word) {
  const std::string lower = LowerCase(word);
  for (const Side side : {Side::kLeft, Side::kRight})
    if (lower == ToString(side) || lower == ToString(side).substr(0, 1)) return side;
  return std::nullopt;
}

// Of a name that stands behind its side without a break: "LKNE", "rightknee"; not "LATERAL" or "lateral".
std::optional<Side> SideOfAbbreviation(const std::string& word) {
  const std::string lower = LowerCase(word);
  if (lower == "lat" || lower == "lateral") return std::nullopt;
  for (const Side side : {Side::kLeft, Side::kRight})
    if (lower.starts_with(ToString(side)) || (lower[0] == ToString(side)[0] && IsUpper(word[1]))) return side;
  return std::nullopt;
}

}  // namespace

double MedianLength(const LegMotion& motion, Eigen::Vector2d LegSample::*vector) {
  std::vector<double> lengths;
  for (const LegSample& sample : motion.samples)
    if (const double length = (sample.*vector).norm(); std::isfinite(length)) lengths.push_back(length);
  return lengths.empty() ? kNaN : Median(std::move(lengths));
}

std::string_view ToString(Side side) {
  return side == Side::kLeft ? "left" : "right";
}

Side NearLeg(Facing facing) {
  return facing == Facing::kLeft ? Side::kLeft : Side::kRight;
}

std::optional<Side> SideOfName(std::string_view marker) {
  const std::vector<std::string> words = WordsOf(marker);
  std::optional<Side> side;
  for (const std::string& word : words) {
    const std::optional<Side> of_word = SideOfWord(word);
    if (of_word && side && side != of_word) return std::nullopt;
    if (of_word) side = of_word;
  }
  return side || words.empty() ? side : SideOfAbbreviation(words.front());
}

std::string_view ToString(StsEventKind kind) {
  constexpr std::array<std::string_view, kEventKinds> kNames = {
      "onset",  "seat_off",    "standing", "descent",           "seated",
      "bottom", "heel_strike", "toe_off",  "heel_strike_other", "toe_off_other"};
  return kNames.at(static_cast<std::size_t>(kind));
}

std::span<const Angle> Angles() {
  static const std::vector<Angle> angles = [] {
    std::vector<Angle> all = {{"knee", &LegSample::knee_deg, &LegSample::knee_sigma_deg}};
    for (const Segment& segment : kSegments) {
      all.push_back(segment.angle);
      if (segment.Lies()) all.push_back(segment.joint);
    }
    return all;
  }();
  return angles;
}

void WriteKinematicsCsv(const std::filesystem::path& path, const LegMotion& motion) {
  std::vector<Column> columns = ColumnsOf(motion.unit);
  std::erase_if(columns, [&](const Column& column) {
    return !column.is_required && std::ranges::none_of(motion.samples, [&](const LegSample& sample) {
      return std::isfinite(column.Of(sample));
    });
  });
  std::vector<std::string> header = {"frame", "time_s", "repetition", "percent"};
  for (const Column& column : columns) header.push_back(column.name);
  std::vector<DerivedColumn> derived;
  for (const DerivedColumn& column : kDerivedColumns)
    if (std::ranges::any_of(motion.samples, [&](const LegSample& of) { return std::isfinite(column.value(of)); }))
      header.emplace_back(derived.emplace_back(column).name);
  if (!motion.knee_rebuilt.empty()) header.emplace_back("knee_rebuilt");
  std::vector<Angle> neutral;
  if (motion.neutral)
    std::ranges::copy_if(Angles(), std::back_inserter(neutral),
                         [&](const Angle& angle) { return std::isfinite((*motion.neutral).*angle.deg); });
  for (const Angle& angle : neutral) header.push_back(fmt::format("{}_neutral_deg", angle.name));
  CsvWriter csv(header);
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    const LegSample& sample = motion.samples[i];
    csv.Add(motion.frame[i]).Add(motion.time_s[i]).Add(sample.repetition).Add(sample.percent);
    for (const Column& column : columns) csv.Add(column.Of(sample));
    for (const DerivedColumn& column : derived) csv.Add(column.value(sample));
    if (!motion.knee_rebuilt.empty()) csv.Add(static_cast<int>(motion.knee_rebuilt[i]));
    for (const Angle& angle : neutral) csv.Add(sample.*angle.deg - (*motion.neutral).*angle.deg);
    csv.EndRow();
  }
  csv.Write(path);
}

LegMotion ReadKinematicsCsv(const std::filesystem::path& path) {
  const CsvTable table = CsvTable::Read(path);
  LegMotion motion;
  motion.unit = table.Has("ak_x_mm") ? LengthUnit::kMm : LengthUnit::kPx;
  std::vector<Column> columns = ColumnsOf(motion.unit);
  std::erase_if(columns, [&](const Column& column) { return !column.is_required && !table.Has(column.name); });
  const std::size_t frame = table.Column("frame"), time = table.Column("time_s");
  const std::size_t repetition = table.Column("repetition"), percent = table.Column("percent");
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const auto number = [&](std::size_t column) { return table.Number(row, column).value_or(LegSample::kUnknown); };
    motion.frame.push_back(static_cast<std::int64_t>(table.RequiredNumber(row, frame)));
    motion.time_s.push_back(table.RequiredNumber(row, time));
    if (row > 0 && motion.time_s[row] <= motion.time_s[row - 1])
      throw Fail("{}: time_s does not increase", table.Where(row));
    LegSample sample;
    if (const auto value = table.Number(row, repetition)) sample.repetition = static_cast<int>(*value);
    sample.percent = number(percent);
    for (const Column& column : columns) column.value(sample) = number(table.Column(column.name));
    motion.samples.push_back(sample);
    if (table.Has("knee_rebuilt"))
      motion.knee_rebuilt.push_back(table.RequiredNumber(row, table.Column("knee_rebuilt")) != 0);
  }
  return motion;
}

void WriteEventsCsv(const std::filesystem::path& path, const std::vector<StsEvent>& events) {
  std::vector<std::string> header = {"repetition", "event", "frame", "time_s"};
  const bool has_sd =
      std::ranges::any_of(events, [](const StsEvent& event) { return event.kind >= StsEventKind::kBottom; });
  if (has_sd) header.emplace_back("sd_s");
  CsvWriter csv(header);
  for (const StsEvent& event : events) {
    csv.Add(event.repetition).Add(ToString(event.kind)).Add(event.frame).Add(event.time_s);
    if (has_sd) csv.Add(event.sd_s);
    csv.EndRow();
  }
  csv.Write(path);
}

std::vector<StsEvent> ReadEventsCsv(const std::filesystem::path& path) {
  const CsvTable table = CsvTable::Read(path);
  const std::size_t repetition = table.Column("repetition"), event = table.Column("event");
  const std::size_t frame = table.Column("frame"), time = table.Column("time_s");
  std::vector<StsEvent> events;
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    StsEvent read;
    read.repetition = static_cast<int>(table.RequiredNumber(row, repetition));
    const std::optional<StsEventKind> kind = FindEventKind(table.Text(row, event));
    if (!kind) throw Fail("{}: '{}' is not an event", table.Where(row), table.Text(row, event));
    read.kind = *kind;
    read.frame = static_cast<std::int64_t>(table.RequiredNumber(row, frame));
    read.time_s = table.RequiredNumber(row, time);
    if (table.Has("sd_s")) read.sd_s = table.Number(row, table.Column("sd_s")).value_or(LegSample::kUnknown);
    // Of one repetition: the next may begin in the frame in which this one is seated.
    const StsEvent* last = events.empty() ? nullptr : &events.back();
    if (last && read.repetition == last->repetition && read.time_s < last->time_s)
      throw Fail("{}: time_s decreases within repetition {}", table.Where(row), read.repetition);
    if (last && read.repetition < last->repetition)
      throw Fail("{}: repetition {} after repetition {}", table.Where(row), read.repetition, last->repetition);
    events.push_back(read);
  }
  return events;
}

}  // namespace lake::motion
