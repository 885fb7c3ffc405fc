#include "balance.h"

#include <fmt/format.h>

#include <algorithm>

#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"

namespace lake::loads {
namespace {

constexpr double kSlow_s = 1000;  // no acceleration is left

// The same points at a pace by a factor faster.
LegPoints Faster(LegPoints points, double factor) {
  for (PointMotion& point : points) point.velocity_m_s *= factor, point.acceleration_m_s2 *= factor * factor;
  return points;
}

// Of the rises' mean, in a time; `trunk`: where its centre is at the person's own pace.
PaceLoads AtPace(const Model& model, const TrunkFit& trunk, const std::vector<Rise>& rises, double rise_s,
                 const LoadsOptions& options) {
  const auto row_of = [&](const Rise& rise, int percent) -> std::optional<PaceRow> {
    const double at_s = TimeOf(rise, percent), factor = (rise.standing_s - rise.onset_s) / rise_s;
    const std::size_t frame = Locate(model.path.time_s, at_s).before;
    if (!SeatIsLeft(rise, at_s, options) || !model.path.known[frame]) return std::nullopt;
    Displacement beside = trunk.At(model.path, frame);
    beside.acceleration_m_s2 *= factor * factor;
    const LegLoads loads = LoadsFromTrunk(Faster(model.path.frames[frame], factor), model.body, beside);
    return PaceRow{static_cast<double>(percent), rise_s * percent / 100, loads.moments.knee_nm, kMmPerM * loads.zmp_m,
                   0};
  };
  PaceLoads pace{.rise_s = rise_s, .rows = {}, .margin_mm = LoadsRow::kUnknown, .at_percent = LoadsRow::kUnknown};
  for (int percent = 0; percent < kPercents; ++percent) {
    PaceRow mean{.percent = static_cast<double>(percent), .time_s = rise_s * percent / 100};
    double count = 0;
    for (const Rise& rise : rises)
      if (const auto row = row_of(rise, percent)) ++count, mean.knee_nm += row->knee_nm, mean.zmp_mm += row->zmp_mm;
    if (count < static_cast<double>(rises.size())) continue;
    mean.knee_nm /= count, mean.zmp_mm /= count;
    mean.margin_mm =
        std::min(mean.zmp_mm + kMmPerM * model.body.sole.heel_m, kMmPerM * model.body.sole.toe_m - mean.zmp_mm);
    pace.rows.push_back(mean);
    if (!(mean.margin_mm >= pace.margin_mm)) pace.margin_mm = mean.margin_mm, pace.at_percent = mean.percent;
  }
  return pace;
}

double MeanDuration(const std::vector<Rise>& rises) {
  double sum_s = 0;
  for (const Rise& rise : rises) sum_s += rise.standing_s - rise.onset_s;
  return sum_s / static_cast<double>(rises.size());
}

}  // namespace

Balance FindBalance(const Model& model, const TrunkFit& trunk, const std::vector<Rise>& rises,
                    const LoadsOptions& options) {
  constexpr double kStep = 1.02;
  const auto at = [&](double rise_s) { return AtPace(model, trunk, rises, rise_s, options); };
  Balance balance{.own = at(MeanDuration(rises)), .slow = at(kSlow_s), .slowest_s = {}, .asked = {}};
  if (balance.own.margin_mm >= 0 && balance.slow.margin_mm < 0) {
    double rise_s = balance.own.rise_s;
    while (at(kStep * rise_s).margin_mm >= 0) rise_s *= kStep;
    balance.slowest_s = rise_s;
  }
  if (options.rise_s) balance.asked = at(*options.rise_s);
  return balance;
}

BodyPath MeanBodyPath(const Model& model, const TrunkFit& trunk, const std::vector<Rise>& rises,
                      const LoadsOptions& options) {
  BodyPath path{.body = model.body, .aids = {}, .trunk = {}, .feet_from_percent = 0};
  for (int percent = 0; percent < kPercents; ++percent) {
    TrunkSample mean{0, Eigen::Vector2d::Zero()};
    for (const Rise& rise : rises) {
      const double at_s = TimeOf(rise, percent), share = 1 / static_cast<double>(rises.size());
      const std::size_t frame = Locate(model.path.time_s, at_s).before;
      if (!SeatIsLeft(rise, at_s, options)) path.feet_from_percent = percent + 1;
      const LegPoints& points = model.path.frames[frame];
      if (!model.path.known[frame]) mean = {};  // NaN stays NaN
      const SegmentMotion segment = SegmentBetween(points[kHip], points[kTrunkTop]);
      mean.tilt_rad += share * segment.tilt_rad;
      mean.centre_m += share * (model.body.trunk.centre_m * segment.along + trunk.At(model.path, frame).value_m);
    }
    path.trunk.push_back(mean);
  }
  return path;
}

double SlowMargin(const Model& model, const TrunkFit& trunk, const std::vector<Rise>& rises,
                  const LoadsOptions& options) {
  return AtPace(model, trunk, rises, kSlow_s, options).margin_mm;
}

std::optional<std::string> BalanceWarning(const Balance& balance) {
  if (!balance.asked || balance.asked->margin_mm >= 0) return std::nullopt;
  const PaceLoads& asked = *balance.asked;
  return fmt::format(
      "along this path in {} s nobody keeps the balance: at {:.0f} % of the rise the ground's force has to act "
      "{:.0f} mm outside the foot{}; lean farther forward, draw the feet back, or let something hold the person",
      SignificantText(asked.rise_s, 3), asked.at_percent, -asked.margin_mm,
      balance.slowest_s ? fmt::format(" (the path is one of momentum, and takes {} s at most)",
                                      SignificantText(*balance.slowest_s, 2))
                        : "");
}

}  // namespace lake::loads
