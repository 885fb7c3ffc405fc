#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "readers.h"

namespace lake::exchange {
namespace {

class TableReader {
 public:
  TableReader(const TextLines& lines, const PointTable& table, const std::filesystem::path& path)
      : lines_(lines), table_(table), path_(path) {}

  PointRecording Read() {
    recording_.space = table_.space;
    std::vector<std::string> names;
    for (const PointColumns& point : table_.points) {
      names.push_back(point.name);
      width_ = std::max(width_, point.axes.back() + 1);
    }
    AddPoints(std::move(names), path_.string(), recording_);
    if (table_.rows)
      for (const std::size_t line : *table_.rows) ReadRow(line);
    else
      for (std::size_t line = table_.first_row; line < lines_.Count(); ++line)
        if (lines_[line].find_first_not_of(" \t") != std::string::npos) ReadRow(line);
    if (recording_.time_s.empty())
      throw Fail("{}: no row with a time and positions{}", path_.string(), left_out_.InBrackets());
    if (recording_.frame.front() < 0)  // a writer that counts from another number
      for (std::int64_t shift = recording_.frame.front(); std::int64_t & frame : recording_.frame) frame -= shift;
    JudgeSharedTimes();
    left_out_.AppendTo(recording_.warnings);
    return std::move(recording_);
  }

 private:
  static constexpr const char* kDoesNotFollow = "a row whose time does not follow the one before";

  std::optional<double> Number(std::optional<std::size_t> column) {
    if (!column || *column >= cells_.size()) return std::nullopt;
    bool is_unreadable = false;
    std::optional<double> number = NumberIn(cells_[*column], is_unreadable);
    if (const std::vector<std::string> parts = SplitText(cells_[*column], ':'); is_unreadable && parts.size() == 4) {
      number = 0;
      for (const auto& [part, seconds] : {std::pair{0, 3600.0}, {1, 60.0}, {2, 1.0}, {3, 0.01}})
        *number += seconds * NumberIn(parts[static_cast<std::size_t>(part)], is_unreadable).value_or(0);
    }
    if (is_unreadable)
      left_out_.Add("a cell that is not a finite number", fmt::format("{}: '{}'", where_, cells_[*column]));
    return number;
  }

  static std::size_t Decimals(const std::string& cell) {
    const std::size_t point = cell.find_last_of(".,");
    return point == std::string::npos ? 0 : cell.size() - point - 1;
  }

  // The time of a frame's number by the first row and the rate; NaN without a rate.
  double TimeOf(double number) const {
    return table_.rate_hz > 0 ? first_s_ + (number - first_number_) / table_.rate_hz : std::nan("");
  }

  // Whether the time is not before that of the row before. Notes whether frames count on at the rate, as far as digits
  // go.
  bool Follows(double number, double time_s) {
    if (recording_.time_s.empty()) {
      first_s_ = time_s;
      first_number_ = number;
    }
    const bool is_written = table_.time && *table_.time < cells_.size();
    const double digit_s = is_written ? std::pow(10, -static_cast<double>(Decimals(cells_[*table_.time]))) : 0;
    is_as_counted_ = is_as_counted_ && std::abs(time_s - TimeOf(number)) <= digit_s &&
                     (numbers_.empty() || number > numbers_.back());
    return recording_.time_s.empty() || time_s >= recording_.time_s.back();
  }

  // Of rows that share a time: the times of the frames' numbers where all count on at the rate, else the first row.
  void JudgeSharedTimes() {
    std::vector<double>& time_s = recording_.time_s;
    if (std::ranges::adjacent_find(time_s) == time_s.end()) return;
    if (is_as_counted_) {
      std::ranges::transform(numbers_, time_s.begin(), [&](double number) { return TimeOf(number); });
      recording_.warnings.push_back(
          fmt::format("{}: rows share a rounded time: taken are those of the frames' numbers "
                      "at {:g} Hz",
                      path_.string(), table_.rate_hz));
      return;
    }
    std::vector<std::size_t> kept;
    for (std::size_t row = 0; row < time_s.size(); ++row)
      if (row == 0 || time_s[row] != time_s[row - 1])
        kept.push_back(row);
      else
        left_out_.Add(kDoesNotFollow, lines_.Where(line_of_row_[row]));
    const auto keep = [&](auto& values) {
      for (std::size_t i = 0; i < kept.size(); ++i) values[i] = values[kept[i]];
      values.resize(kept.size());
    };
    keep(time_s);
    keep(recording_.frame);
    for (PointTrack& point : recording_.points) keep(point.positions);
  }

  // Whether the file ends within its last row: there are fewer cells than in the row before, or fewer rows than stated,
  // and fewer decimals in the last cell.
  bool IsCutOff(std::size_t line) const {
    if (line + 1 < lines_.Count() || !lines_.EndsWithinLine() || before_.empty()) return false;
    return cells_.size() < before_.size() ||
           (table_.stated_rows && recording_.time_s.size() + 1 < *table_.stated_rows &&
            Decimals(cells_.back()) < Decimals(before_.back()));
  }

  void ReadRow(std::size_t line) {
    before_ = std::exchange(cells_, SplitCells(lines_[line], table_.separator));
    where_ = lines_.Where(line);
    if (table_.separator == ' ' && cells_.size() < width_)  // nothing says which are missing
      return left_out_.Add("a row with fewer numbers than columns", where_);
    if (IsCutOff(line)) return left_out_.Add("the last row, which is cut off,", where_);
    const std::optional<double> stated = Number(table_.frame);
    const double index = static_cast<double>(line - table_.first_row),
                 number = stated.value_or(index + table_.first_frame) - table_.first_frame;
    std::optional<double> time_s = Number(table_.time);
    if (!time_s && table_.rate_hz > 0 && (stated || !table_.frame)) time_s = number / table_.rate_hz;
    if (!time_s) return left_out_.Add("a row without a time", where_);
    if (!Follows(number, *time_s)) return left_out_.Add(kDoesNotFollow, where_);
    recording_.time_s.push_back(*time_s);
    numbers_.push_back(number);
    line_of_row_.push_back(line);
    const std::int64_t next = recording_.frame.empty() ? 0 : recording_.frame.back() + 1;
    const bool is_frame = std::abs(number) <= static_cast<double>(kMostFrames) && number == std::floor(number) &&
                          (recording_.frame.empty() || number >= static_cast<double>(next));
    recording_.frame.push_back(is_frame ? static_cast<std::int64_t>(number) : next);
    for (std::size_t p = 0; p < table_.points.size(); ++p)
      recording_.points[p].positions.push_back(Position(table_.points[p]));
    if (table_.names_all) CountUnnamed();
  }

  Eigen::Vector3d Position(const PointColumns& columns) {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    for (std::size_t axis = 0; axis < columns.axes.size(); ++axis) {
      const std::optional<double> value = Number(columns.axes[axis]);
      constexpr double kMissing = 9'999'999;  // as Cortex writes it
      if (!value || *value == kMissing) return PointTrack::Missing();
      position[static_cast<Eigen::Index>(axis)] = (*value - table_.first_pixel) * table_.mm_per_unit;
    }
    if (table_.zero_is_missing && position.isZero(0)) return PointTrack::Missing();
    if (columns.likelihood && !(Number(columns.likelihood).value_or(1) >= table_.least_likelihood)) {
      left_out_.Add(fmt::format("a point whose likelihood is below {:g}", table_.least_likelihood), where_);
      return PointTrack::Missing();
    }
    return position;
  }

  void CountUnnamed() {
    if (known_.empty()) {
      for (const auto column : {table_.time, table_.frame})
        if (column) known_.insert(*column);
      for (const PointColumns& point : table_.points) known_.insert(point.axes.begin(), point.axes.end());
    }
    for (std::size_t column = 0; column < cells_.size(); ++column)
      if (!cells_[column].empty() && known_.insert(column).second)
        left_out_.Add("a column of values without a name", where_);
  }

  const TextLines& lines_;
  const PointTable& table_;
  const std::filesystem::path& path_;
  PointRecording recording_;
  LeftOut left_out_;
  std::vector<std::string> cells_, before_;  // of the row that is read, and of the one before
  std::string where_;
  std::vector<double> numbers_;  // of the frames
  std::vector<std::size_t> line_of_row_;
  double first_s_ = 0, first_number_ = 0;
  bool is_as_counted_ = true;    // so far, times are those of the numbers
  std::size_t width_ = 0;        // columns that have a meaning
  std::set<std::size_t> known_;  // columns that have a meaning, or were said to have none
};

}  // namespace

PointRecording ReadPointTable(const TextLines& lines, const PointTable& table, const std::filesystem::path& path) {
  return TableReader(lines, table, path).Read();
}

}  // namespace lake::exchange
