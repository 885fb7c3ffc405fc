#include "balance.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"

namespace lake::loads {
namespace {

constexpr double kSlow_s = 1000;  // no acceleration is left

// The same points at a pace by a factor faster.
LegPoints Faster(LegPoints points, double factor) {
  for (PointMotion& point : points) {
    point.velocity_m_s *= factor;
    point.acceleration_m_s2 *= factor * factor;
  }
  return points;
}

double MeanDuration(const std::vector<Rise>& rises) {
  double sum_s = 0;
  for (const Rise& rise : rises) sum_s += rise.standing_s - rise.onset_s;
  return sum_s / static_cast<double>(rises.size());
}

// Of one frame, at a pace by a factor faster.
LegLoads FasterLoads(const Model& model, const TrunkFit& trunk, std::size_t frame, double factor) {
  Displacement beside = trunk.At(model.path, frame);
  beside.acceleration_m_s2 *= factor * factor;
  return LoadsFromTrunk(Faster(model.path.frames[frame], factor), model.body, beside);
}

// The frames around a time; nullopt where the markers do not show both.
std::optional<Between> KnownAround(const Model& model, double at_s) {
  const Between b = Locate(model.path.time_s, at_s);
  return model.path.known[b.before] && model.path.known[b.before + 1] ? std::optional(b) : std::nullopt;
}

// The mean of the rises, all slowed down alike so that the mean takes a time; `trunk`: where its centre is at the
// person's own pace.
PaceLoads AtPace(const Model& model, const TrunkFit& trunk, const std::vector<Rise>& rises, double rise_s,
                 const LoadsOptions& options) {
  const double factor = MeanDuration(rises) / rise_s;
  const auto row_of = [&](const Rise& rise, int percent) -> std::optional<PaceRow> {
    const double at_s = TimeOf(rise, percent);
    const auto b = KnownAround(model, at_s);
    if (!SeatIsLeft(rise, at_s, options) || !b) return std::nullopt;
    const LegLoads before = FasterLoads(model, trunk, b->before, factor),
                   after = FasterLoads(model, trunk, b->before + 1, factor);
    return PaceRow{.percent = static_cast<double>(percent),
                   .time_s = rise_s * percent / 100,
                   .knee_nm = std::lerp(before.moments.knee_nm, after.moments.knee_nm, b->part),
                   .zmp_mm = kMmPerM * std::lerp(before.zmp_m, after.zmp_m, b->part)};
  };
  PaceLoads pace{.rise_s = rise_s, .rows = {}, .margin_mm = LoadsRow::kUnknown, .at_percent = LoadsRow::kUnknown};
  for (int percent = 0; percent < kPercents; ++percent) {
    PaceRow mean{.percent = static_cast<double>(percent), .time_s = rise_s * percent / 100};
    double count = 0;
    for (const Rise& rise : rises) {
      const auto row = row_of(rise, percent);
      if (!row) continue;
      ++count;
      mean.knee_nm += row->knee_nm;
      mean.zmp_mm += row->zmp_mm;
    }
    if (count < static_cast<double>(rises.size())) continue;
    mean.knee_nm /= count;
    mean.zmp_mm /= count;
    mean.margin_mm =
        std::min(mean.zmp_mm + kMmPerM * model.body.sole.heel_m, kMmPerM * model.body.sole.toe_m - mean.zmp_mm);
    pace.rows.push_back(mean);
    if (mean.margin_mm >= pace.margin_mm) continue;
    pace.margin_mm = mean.margin_mm;
    pace.at_percent = mean.percent;
  }
  return pace;
}

SegmentMotion TrunkSegment(const Model& model, std::size_t frame) {
  return SegmentBetween(model.path.frames[frame][kHip], model.path.frames[frame][kTrunkTop]);
}

// The last frame where none is known from then on.
std::size_t FirstKnownFrom(const Model& model, double at_s) {
  const std::size_t last = model.path.time_s.size() - 1;
  std::size_t frame = std::min(FrameFrom(model.path.time_s, at_s), last);
  while (frame < last && !model.path.known[frame]) ++frame;
  return frame;
}

// Before the feet alone bear the body no force shows where in the trunk its centre is: there it is where it is at first
// on the feet, so that nothing jumps then.
TrunkSample TrunkOf(const Model& model, const TrunkFit& trunk, std::size_t frame, std::size_t on_feet) {
  const std::size_t known = std::max(frame, on_feet);
  const SegmentMotion segment = TrunkSegment(model, frame), at_known = TrunkSegment(model, known);
  const Eigen::Vector2d centre_m = model.body.trunk.centre_m * at_known.along + trunk.At(model.path, known).value_m;
  return {segment.tilt_rad, Eigen::Rotation2Dd(at_known.tilt_rad - segment.tilt_rad) * centre_m};
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
      if (!SeatIsLeft(rise, at_s, options)) path.feet_from_percent = percent + 1;
      const auto b = KnownAround(model, at_s);
      if (!b) {
        mean = {};  // NaN stays NaN
        continue;
      }
      const std::size_t on_feet = FirstKnownFrom(model, rise.seat_off_s + options.seat_release_s);
      const TrunkSample before = TrunkOf(model, trunk, b->before, on_feet),
                        after = TrunkOf(model, trunk, b->before + 1, on_feet);
      mean.tilt_rad += share * std::lerp(before.tilt_rad, after.tilt_rad, b->part);
      mean.centre_m += share * ((1 - b->part) * before.centre_m + b->part * after.centre_m);
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
