#include "lake/actuator/duty_calibration.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <vector>

#include "lake/core/counted.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"

namespace lake::actuator {

namespace {

constexpr double kSameDuty = 1e-6;
constexpr std::size_t kFewestOfPlateau = 6;  // of a plateau: three in each half

// Speed at one duty in one direction, from all its plateaus; speeds positive in the duty's direction.
struct DutySpeed {
  double duty = 0, speed = 0, error = 0;
};

std::span<const double> Part(const std::vector<double>& values, std::size_t first, std::size_t last) {
  return std::span(values).subspan(first, last - first);
}

// Whether the stroke goes on at one speed: its halves have the same, within noise and within what is asked for.
bool IsSteady(const DutyLog& log, std::size_t first, std::size_t last, const CalibrateOptions& options) {
  const std::size_t middle = first + (last - first) / 2;
  const RobustSlope a = FitRobustSlope(Part(log.time_s, first, middle), Part(log.stroke_mm, first, middle));
  const RobustSlope b = FitRobustSlope(Part(log.time_s, middle, last), Part(log.stroke_mm, middle, last));
  const double difference = std::abs(a.slope - b.slope), speed = std::max(std::abs(a.slope), std::abs(b.slope));
  return !(difference > std::max(options.steady_fraction * speed, options.still_mm_s) &&
           difference > 5 * std::hypot(a.standard_error, b.standard_error));
}

// The plateau of samples first..last, its settling left out.
Plateau MeasurePlateau(const DutyLog& log, std::size_t first, std::size_t last, const CalibrateOptions& options,
                       std::vector<std::string>& warnings) {
  Plateau plateau{
      .log = log.name, .begin_s = log.time_s[first], .end_s = log.time_s[last - 1], .duty = log.duty[first]};
  if (plateau.end_s - plateau.begin_s < options.min_plateau_s) return plateau;
  while (first < last && log.time_s[first] < plateau.begin_s + options.settle_s) ++first;
  if (last - first < kFewestOfPlateau) {
    warnings.push_back(fmt::format("{}: the plateau of duty {} at {:.3f} s has {} samples after settling; left out",
                                   log.name, SignificantText(plateau.duty, 4), plateau.begin_s, last - first));
    return plateau;
  }
  const RobustSlope fit = FitRobustSlope(Part(log.time_s, first, last), Part(log.stroke_mm, first, last));
  plateau.speed_mm_s = fit.slope;
  plateau.standard_error_mm_s = fit.standard_error;
  plateau.used = IsSteady(log, first, last, options);
  if (!plateau.used)
    warnings.push_back(
        fmt::format("{}: the plateau of duty {} at {:.3f}..{:.3f} s is not steady (an end of travel? a changing "
                    "load?); left out",
                    log.name, SignificantText(plateau.duty, 4), plateau.begin_s, plateau.end_s));
  return plateau;
}

std::vector<Plateau> FindPlateaus(const std::vector<DutyLog>& logs, const CalibrateOptions& options,
                                  std::vector<std::string>& warnings) {
  std::vector<Plateau> plateaus;
  for (const DutyLog& log : logs) {
    for (std::size_t first = 0, last; first < log.duty.size(); first = last) {
      last = first + 1;
      while (last < log.duty.size() && std::abs(log.duty[last] - log.duty[first]) < kSameDuty) ++last;
      if (std::abs(log.duty[first]) < kSameDuty) continue;
      const Plateau plateau = MeasurePlateau(log, first, last, options, warnings);
      if (plateau.end_s - plateau.begin_s >= options.min_plateau_s) plateaus.push_back(plateau);
    }
  }
  return plateaus;
}

// The mean of plateaus at one duty, and its error: theirs, or what their scatter says if that is more.
DutySpeed Combine(double duty, const std::vector<const Plateau*>& plateaus, double direction) {
  std::vector<double> speeds;
  double own = 0;
  for (const Plateau* plateau : plateaus) {
    speeds.push_back(direction * plateau->speed_mm_s);
    own += plateau->standard_error_mm_s * plateau->standard_error_mm_s;
  }
  const double n = static_cast<double>(speeds.size());
  const double scatter = speeds.size() > 1 ? StandardDeviation(speeds) / std::sqrt(n) : 0;
  return {duty, Mean(speeds), std::max(std::sqrt(own) / n, scatter)};
}

std::vector<DutySpeed> SpeedsOf(const std::vector<Plateau>& plateaus, int direction, const CalibrateOptions& options) {
  std::map<long, std::vector<const Plateau*>> by_duty;
  for (const Plateau& plateau : plateaus)
    if (plateau.used && plateau.duty * direction > 0)
      by_duty[std::lround(std::abs(plateau.duty) / kSameDuty)].push_back(&plateau);
  std::vector<DutySpeed> speeds;
  for (const auto& [key, group] : by_duty) {
    speeds.push_back(Combine(std::abs(group.front()->duty), group, direction));
    DutySpeed& last = speeds.back();
    if (last.speed < -std::max(options.still_mm_s, 3 * last.error))
      throw Fail(
          "{}: duty {:+.2f} moves the stroke at {:+.2f} mm/s, the wrong way; swap the motor's two wires or the sign of "
          "the duty",
          group.front()->log, group.front()->duty, direction * last.speed);
    if (last.speed < std::max(options.still_mm_s, 3 * last.error)) last.speed = 0;
  }
  return speeds;
}

// Weighted pool-adjacent-violators; returns the largest change.
double MakeMonotone(std::vector<DutySpeed>& speeds) {
  struct Block {
    double speed, weight;
    std::size_t count;
  };
  std::vector<Block> blocks;
  constexpr double kLeastError = 1e-6;  // mm/s
  for (const DutySpeed& s : speeds) {
    blocks.push_back({s.speed, 1 / std::pow(std::max(s.error, kLeastError), 2), 1});
    while (blocks.size() > 1 && blocks[blocks.size() - 2].speed > blocks.back().speed) {
      const Block top = blocks.back();
      blocks.pop_back();
      Block& below = blocks.back();
      below.speed = (below.speed * below.weight + top.speed * top.weight) / (below.weight + top.weight);
      below.weight += top.weight;
      below.count += top.count;
    }
  }
  double largest = 0;
  std::size_t i = 0;
  for (const Block& block : blocks)
    for (std::size_t k = 0; k < block.count; ++k, ++i) {
      largest = std::max(largest, std::abs(speeds[i].speed - block.speed));
      speeds[i].speed = block.speed;
    }
  return largest;
}

DeadBand DeadBandOf(const std::vector<DutySpeed>& speeds, const char* name) {
  std::vector<DutySpeed> moving;
  DeadBand band;
  for (const DutySpeed& s : speeds) {
    if (s.speed == 0)
      band.low = s.duty;
    else if (moving.empty() || s.speed > moving.back().speed)
      moving.push_back(s);
  }
  if (moving.size() < 2)
    throw Fail("{} {} duties that move the actuator at different speeds; a table needs at least two: log more plateaus",
               moving.size(), name);
  band.high = moving[0].duty;
  const double duty_per_speed = (moving[1].duty - moving[0].duty) / (moving[1].speed - moving[0].speed);
  constexpr double kLeastGap = 1e-6;  // so that the edge is a duty of its own
  band.duty = std::clamp(moving[0].duty - moving[0].speed * duty_per_speed, band.low, band.high - kLeastGap);
  return band;
}

std::vector<DutyRow> RowsOf(const std::vector<DutySpeed>& extend, const DeadBand& extend_band,
                            const std::vector<DutySpeed>& retract, const DeadBand& retract_band) {
  std::map<long, DutyRow> rows;
  const auto row = [&](double duty) -> DutyRow& {
    return rows
        .try_emplace(std::lround(duty / kSameDuty), DutyRow{.duty = duty,
                                                            .extend_mm_s = kNaN,
                                                            .retract_mm_s = kNaN,
                                                            .extend_se_mm_s = kNaN,
                                                            .retract_se_mm_s = kNaN})
        .first->second;
  };
  row(extend_band.duty).extend_mm_s = 0;
  row(retract_band.duty).retract_mm_s = 0;
  for (const DutySpeed& s : extend) {
    row(s.duty).extend_mm_s = s.speed;
    row(s.duty).extend_se_mm_s = s.error;
  }
  for (const DutySpeed& s : retract) {
    row(s.duty).retract_mm_s = s.speed;
    row(s.duty).retract_se_mm_s = s.error;
  }
  std::vector<DutyRow> list;
  for (const auto& [key, value] : rows) list.push_back(value);
  return list;
}

// The tolerance of one direction of a row: NaN if it stands still or was tried only once.
double TolerancePercent(const DutyRow& row, int direction, const std::vector<Plateau>& plateaus) {
  const double speed = direction > 0 ? row.extend_mm_s : row.retract_mm_s;
  if (!(speed > 0)) return kNaN;
  int count = 0;
  double largest = 0;
  for (const Plateau& p : plateaus) {
    if (!p.used || std::abs(direction * p.duty - row.duty) >= kSameDuty) continue;
    ++count;
    largest = std::max(largest, std::abs(direction * p.speed_mm_s - speed) + 2 * p.standard_error_mm_s);
  }
  return count > 1 ? std::min(100 * largest / speed, 100.0) : kNaN;
}

// Fills in the rows' tolerances; returns the largest.
std::optional<double> MeasureTolerance(std::vector<DutyRow>& rows, const std::vector<Plateau>& plateaus) {
  std::optional<double> largest;
  for (DutyRow& row : rows) {
    row.tolerance_percent = std::fmax(TolerancePercent(row, 1, plateaus), TolerancePercent(row, -1, plateaus));
    if (!std::isnan(row.tolerance_percent)) largest = std::max(largest.value_or(0), row.tolerance_percent);
  }
  return largest;
}

}  // namespace

void CalibrateOptions::Check() const {
  if (!(min_plateau_s > settle_s))
    throw UsageError("--min-plateau {} s must exceed --settle {} s", min_plateau_s, settle_s);
}

DutyCalibration CalibrateDuty(const std::vector<DutyLog>& logs, const CalibrateOptions& options) {
  options.Check();
  DutyCalibration calibration;
  calibration.plateaus = FindPlateaus(logs, options, calibration.warnings);
  if (calibration.plateaus.empty())
    throw Fail("no plateau of constant duty of at least {} s in {}", options.min_plateau_s,
               Counted(logs.size(), "log"));
  std::vector<DutySpeed> extend = SpeedsOf(calibration.plateaus, 1, options);
  std::vector<DutySpeed> retract = SpeedsOf(calibration.plateaus, -1, options);
  calibration.largest_adjustment_mm_s = std::max(MakeMonotone(extend), MakeMonotone(retract));
  calibration.extend = DeadBandOf(extend, "extending");
  calibration.retract = DeadBandOf(retract, "retracting");
  calibration.rows = RowsOf(extend, calibration.extend, retract, calibration.retract);
  calibration.tolerance_percent = MeasureTolerance(calibration.rows, calibration.plateaus);
  double largest_error = 0;
  for (const auto* speeds : {&extend, &retract})
    for (const DutySpeed& s : *speeds) largest_error = std::max(largest_error, s.error);
  if (calibration.largest_adjustment_mm_s > std::max(3 * largest_error, options.still_mm_s))
    calibration.warnings.push_back(
        fmt::format("a speed falls as the duty rises and was changed by {} mm/s to stop that: was the supply or "
                    "the load another?",
                    SignificantText(calibration.largest_adjustment_mm_s, 3)));
  return calibration;
}

// The slope of a plateau.

namespace {

// Means of consecutive groups, at most `most` of them.
std::vector<double> Thinned(std::span<const double> values, std::size_t most) {
  const std::size_t group = (values.size() + most - 1) / most;
  std::vector<double> means;
  for (std::size_t i = 0; i + group <= values.size(); i += group) means.push_back(Mean(values.subspan(i, group)));
  return means;
}

// The median of the slopes of all pairs; NaN if all x are one.
double MedianOfPairs(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = i + 1; j < x.size(); ++j)
      if (x[j] != x[i]) slopes.push_back((y[j] - y[i]) / (x[j] - x[i]));
  return Median(std::move(slopes));
}

// The step of the readings, as far as their changes show it: the least change, or the least difference of two changes.
double StepOf(const std::vector<double>& y) {
  std::vector<double> changes = {0};
  for (std::size_t i = 1; i < y.size(); ++i) changes.push_back(std::abs(y[i] - y[i - 1]));
  std::sort(changes.begin(), changes.end());
  const double rounding = 1e-9 * (std::abs(y.front()) + changes.back());  // of a step computed from its neighbours
  double step = changes.back();
  for (std::size_t i = 1; i < changes.size(); ++i)
    if (const double gap = changes[i] - changes[i - 1]; gap > rounding) step = std::min(step, gap);
  return step;
}

// The error is at least that of readings rounded to the step: where a speed is a whole number of steps per reading, the
// residuals say nothing of it.
RobustSlope LeastSquares(const std::vector<double>& x, const std::vector<double>& y, double step) {
  const double mean_x = Mean(x), mean_y = Mean(y);
  double xx = 0, xy = 0, residual = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  const double slope = xy / xx;
  for (std::size_t i = 0; i < x.size(); ++i) residual += std::pow(y[i] - mean_y - slope * (x[i] - mean_x), 2);
  const double variance = std::max(residual / static_cast<double>(x.size() - 2), step * step / 12);
  return {slope, std::sqrt(variance / xx)};
}

}  // namespace

RobustSlope FitRobustSlope(std::span<const double> all_x, std::span<const double> all_y) {
  constexpr double kDeviations = 4;
  if (all_x.size() < 3) return {kNaN, kNaN};
  const std::vector<double> x = Thinned(all_x, kMostSlopePoints), y = Thinned(all_y, kMostSlopePoints);
  const double slope = MedianOfPairs(x, y);
  if (std::isnan(slope)) return {kNaN, kNaN};
  std::vector<double> rest, good_x, good_y;
  for (std::size_t i = 0; i < x.size(); ++i) rest.push_back(y[i] - slope * x[i]);
  const double step = StepOf(y), middle = Median(rest), limit = std::max(kDeviations * RobustDeviation(rest), step);
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::abs(rest[i] - middle) <= limit) {
      good_x.push_back(x[i]);
      good_y.push_back(y[i]);
    }
  return good_x.size() < 3 ? RobustSlope{slope, kNaN} : LeastSquares(good_x, good_y, step);
}

}  // namespace lake::actuator
