#include "lake/compare/symmetry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/distributions.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/gait/sit_to_stand.h"

namespace lake::compare {
namespace {

using gait::Measured, gait::SitToStand;

// Those that a leg has of its own: when the rise begins and ends is the person's.
struct Compared {
  Measured SitToStand::*value;
  // The segments between whose markers the angle is, which tell how much a marker on another spot changes it.
  enum class Angle { kNone, kKnee, kHip } angle = Angle::kNone;
};
constexpr Compared kCompared[] = {{&SitToStand::flexion_s},
                                  {&SitToStand::transfer_s},
                                  {&SitToStand::extension_s},
                                  {&SitToStand::knee_seat_off_deg, Compared::Angle::kKnee},
                                  {&SitToStand::hip_seat_off_deg, Compared::Angle::kHip},
                                  {&SitToStand::knee_max_deg, Compared::Angle::kKnee},
                                  {&SitToStand::hip_max_deg, Compared::Angle::kHip},
                                  {&SitToStand::knee_extension_max_deg_s},
                                  {&SitToStand::hip_rise},
                                  {&SitToStand::hip_speed_max}};

constexpr double kOutside = 0.05;

// Of the angle between two segments that share a marker, where each of their three markers is off by `sd`.
double PlacementDeg(double sd, double first, double second) {
  const double angle = sd * std::hypot(1 / first, 1 / second, 1 / first + 1 / second);
  return std::isfinite(angle) ? DegreesFromRadians(angle) : 0;
}

double PlacementOf(const motion::LegMotion& motion, Compared::Angle angle, double sd) {
  if (angle == Compared::Angle::kNone || motion.unit != motion::LengthUnit::kMm) return 0;
  const double thigh = MedianLength(motion, &motion::LegSample::kh);
  return angle == Compared::Angle::kKnee ? PlacementDeg(sd, MedianLength(motion, &motion::LegSample::ak), thigh)
                                         : PlacementDeg(sd, thigh, MedianLength(motion, &motion::LegSample::hw));
}

// Values of rises by their numbers.
using ByRise = std::map<int, Measured>;

std::vector<double> Values(const ByRise& rises) {
  std::vector<double> values;
  for (const auto& [repetition, measured] : rises) values.push_back(measured.value);
  return values;
}

struct MeanDifference {
  double left = kNaN, right = kNaN, sd = kNaN;  // of the difference
  double freedom = kInfinity;
};

MeanDifference PairedDifference(const ByRise& left, const ByRise& right) {
  std::vector<double> of_left, of_right, differences;
  double variance = 0;
  for (const auto& [repetition, measured] : left) {
    const auto other = right.find(repetition);
    if (other == right.end()) continue;
    of_left.push_back(measured.value);
    of_right.push_back(other->second.value);
    differences.push_back(measured.value - other->second.value);
    variance += measured.sd * measured.sd + other->second.sd * other->second.sd;
  }
  if (differences.empty()) return {};
  MeanDifference mean{.left = Mean(of_left), .right = Mean(of_right)};
  const auto n = static_cast<double>(differences.size());
  mean.sd = n > 1 ? StandardDeviation(differences) / std::sqrt(n) : std::sqrt(variance);
  if (n > 1) mean.freedom = n - 1;
  return mean;
}

MeanDifference WelchDifference(const ByRise& left, const ByRise& right) {
  MeanDifference mean{.left = Mean(Values(left)), .right = Mean(Values(right)), .sd = 0};
  double fourth = 0;
  for (const ByRise* side : {&left, &right}) {
    const auto n = static_cast<double>(side->size());
    const double variance =
        n > 1 ? std::pow(StandardDeviation(Values(*side)), 2) / n : std::pow(side->begin()->second.sd, 2);
    mean.sd = std::hypot(mean.sd, std::sqrt(variance));
    if (n > 1) fourth += variance * variance / (n - 1);
  }
  if (fourth > 0) mean.freedom = std::pow(mean.sd, 4) / fourth;
  return mean;
}

// `placement`: of the markers, which no number of rises makes smaller.
SideDifference DifferenceOf(std::string name, const MeanDifference& mean, double placement, double outside) {
  SideDifference difference{.name = std::move(name), .left = mean.left, .right = mean.right};
  difference.difference = mean.left - mean.right;
  const double upper = 1 - outside / 2, normal = NormalQuantile(upper), student = StudentQuantile(mean.freedom, upper),
               reach = std::hypot(student * mean.sd, normal * placement);
  difference.interval = {difference.difference - reach, difference.difference + reach};
  const double to_percent = 100 / ((mean.left + mean.right) / 2);
  difference.index_percent = to_percent * difference.difference;
  difference.index_interval = {to_percent * difference.interval.low, to_percent * difference.interval.high};
  if (to_percent < 0) std::swap(difference.index_interval.low, difference.index_interval.high);
  return difference;
}

// The knee angle of each rise at 0 to 100 %, between the frames.
std::map<int, std::vector<Measured>> KneeCurves(const motion::LegMotion& motion) {
  constexpr std::size_t kPercents = 101;
  std::map<int, std::vector<Measured>> curves;
  for (std::size_t i = 1; i < motion.samples.size(); ++i) {
    const motion::LegSample &before = motion.samples[i - 1], &after = motion.samples[i];
    if (!before.repetition || before.repetition != after.repetition || !(after.percent > before.percent)) continue;
    std::vector<Measured>& curve = curves.try_emplace(*after.repetition, kPercents).first->second;
    for (auto percent = static_cast<std::size_t>(std::ceil(before.percent));
         percent < kPercents && static_cast<double>(percent) <= after.percent; ++percent) {
      const double part = (static_cast<double>(percent) - before.percent) / (after.percent - before.percent);
      curve[percent] = {std::lerp(before.knee_deg, after.knee_deg, part),
                        std::lerp(before.knee_sigma_deg, after.knee_sigma_deg, part)};
    }
  }
  return curves;
}

ByRise AtPercent(const std::map<int, std::vector<Measured>>& curves, std::size_t percent) {
  ByRise rises;
  for (const auto& [repetition, curve] : curves)
    if (std::isfinite(curve[percent].value)) rises[repetition] = curve[percent];
  return rises;
}

// Rises from onset to standing, without the row of the five-times test.
std::vector<SitToStand> WholeRisesOf(const gait::LegFitResult& fit) {
  std::vector<SitToStand> rises = gait::MeasureSitToStands(fit);
  std::erase_if(rises, [](const SitToStand& rise) { return rise.repetition == 0 || std::isnan(rise.rise_s.value); });
  return rises;
}

std::vector<SitToStand> WholeRises(const gait::LegFitResult& fit, const char* side) {
  std::vector<SitToStand> rises = WholeRisesOf(fit);
  if (rises.empty()) throw Fail("the {} leg: no rise has an onset and a standing in the recording", side);
  return rises;
}

// From onset, or from seat-off where the recording begins after the onset, to standing.
struct RiseTimes {
  int repetition;
  double from_s, to_s;
};

std::vector<RiseTimes> TimesOf(const gait::LegFitResult& fit) {
  std::vector<RiseTimes> times;
  for (const SitToStand& rise : gait::MeasureSitToStands(fit, {})) {
    const double from_s = std::fmin(rise.onset_s.value, rise.seat_off_s.value), to_s = rise.standing_s.value;
    if (rise.repetition != 0 && std::isfinite(from_s) && std::isfinite(to_s))
      times.push_back({rise.repetition, from_s, to_s});
  }
  return times;
}

// The left leg's number by the right leg's, of rises that overlap in time, each with the one that it overlaps longest.
std::map<int, int> LeftByRight(const std::vector<RiseTimes>& left, const std::vector<RiseTimes>& right) {
  std::map<int, int> left_by_right;
  for (const RiseTimes& l : left) {
    const RiseTimes* match = nullptr;
    double most_s = 0;
    for (const RiseTimes& r : right) {
      const double both_s = std::min(l.to_s, r.to_s) - std::max(l.from_s, r.from_s);
      if (!(both_s > most_s) || left_by_right.contains(r.repetition)) continue;
      most_s = both_s;
      match = &r;
    }
    if (match) left_by_right[match->repetition] = l.repetition;
  }
  return left_by_right;
}

std::string WithoutMatch(const RiseTimes& rise, const char* side, const char* other) {
  return fmt::format("rise {} of the {} leg, {:.2f} to {:.2f} s, has no counterpart among the {} leg's: it is left out",
                     rise.repetition, side, rise.from_s, rise.to_s, other);
}

ByRise Of(const std::vector<SitToStand>& rises, Measured SitToStand::*value) {
  ByRise values;
  for (const SitToStand& rise : rises)
    if (std::isfinite((rise.*value).value)) values[rise.repetition] = rise.*value;
  return values;
}

std::string ColumnName(Measured SitToStand::*value, motion::LengthUnit unit) {
  return std::ranges::find(SitToStand::Fields(), value, &gait::Field<SitToStand>::value)->Column(unit);
}

}  // namespace

MatchedRises MatchRises(const gait::LegFitResult& left, gait::LegFitResult right) {
  const std::vector<RiseTimes> of_left = TimesOf(left), of_right = TimesOf(right);
  const std::map<int, int> left_by_right = LeftByRight(of_left, of_right);
  MatchedRises matched;
  for (const RiseTimes& l : of_left)
    if (std::ranges::none_of(left_by_right, [&](const auto& pair) { return pair.second == l.repetition; }))
      matched.warnings.push_back(WithoutMatch(l, "left", "right"));
  for (const RiseTimes& r : of_right)
    if (!left_by_right.contains(r.repetition)) matched.warnings.push_back(WithoutMatch(r, "right", "left"));
  std::erase_if(right.events, [&](const motion::StsEvent& event) { return !left_by_right.contains(event.repetition); });
  for (motion::StsEvent& event : right.events) event.repetition = left_by_right.at(event.repetition);
  for (motion::LegSample& sample : right.motion.samples) {
    if (!sample.repetition) continue;
    const auto number = left_by_right.find(*sample.repetition);
    sample.repetition = number != left_by_right.end() ? std::optional<int>(number->second) : std::nullopt;
  }
  matched.right = std::move(right);
  return matched;
}

Symmetry CompareSides(const gait::LegFitResult& left, const gait::LegFitResult& all_of_right,
                      const SymmetryOptions& options) {
  if (left.motion.unit != all_of_right.motion.unit)
    throw Fail("the left leg is in {} and the right leg in {}: give the one in px a scale: {} with a plane, or {}",
               ToString(left.motion.unit), ToString(all_of_right.motion.unit),
               left.motion.unit == motion::LengthUnit::kPx ? "--camera" : "--right-camera",
               left.motion.unit == motion::LengthUnit::kPx ? "--scale" : "--right-scale");
  const std::vector<SitToStand> of_left = WholeRises(left, "left");
  const std::size_t right_rises = WholeRises(all_of_right, "right").size();
  MatchedRises matched =
      options.one_recording ? MatchRises(left, all_of_right) : MatchedRises{.right = all_of_right, .warnings = {}};
  const gait::LegFitResult& right = matched.right;
  const std::vector<SitToStand> of_right = WholeRisesOf(right);
  const auto mean_of = [&](const ByRise& l, const ByRise& r) {
    return options.one_recording ? PairedDifference(l, r) : WelchDifference(l, r);
  };
  Symmetry symmetry{.left_rises = of_left.size(), .right_rises = right_rises};
  symmetry.warnings = std::move(matched.warnings);
  const double outside = kOutside / static_cast<double>(std::size(kCompared) + options.further.size());
  const auto add = [&](const std::string& name, const ByRise& l, const ByRise& r, double placement) {
    if (l.empty() || r.empty()) return;
    const MeanDifference mean = mean_of(l, r);
    if (!std::isfinite(mean.sd)) return;
    symmetry.quantities.push_back(DifferenceOf(name, mean, placement, outside));
    symmetry.is_asymmetric |= symmetry.quantities.back().IsAsymmetric();
  };
  for (const Compared& compared : kCompared)
    add(ColumnName(compared.value, left.motion.unit), Of(of_left, compared.value), Of(of_right, compared.value),
        std::hypot(PlacementOf(left.motion, compared.angle, options.replacement_sd_mm),
                   PlacementOf(right.motion, compared.angle, options.replacement_sd_mm)));
  for (const RiseQuantity& quantity : options.further) {
    if (quantity.left.empty() || quantity.right.empty()) continue;
    const double instruments =
        quantity.relative_sd * std::hypot(Mean(Values(quantity.left)), Mean(Values(quantity.right)));
    add(quantity.name, quantity.left, quantity.right, instruments);
  }
  if (symmetry.quantities.empty())
    throw Fail("the left leg rises {} and the right leg {} times, and none of the rises is in both", of_left.size(),
               right_rises);
  const auto left_knee = KneeCurves(left.motion), right_knee = KneeCurves(right.motion);
  const double placement = std::hypot(PlacementOf(left.motion, Compared::Angle::kKnee, options.replacement_sd_mm),
                                      PlacementOf(right.motion, Compared::Angle::kKnee, options.replacement_sd_mm));
  for (std::size_t percent = 0; percent <= 100; ++percent) {
    const ByRise l = AtPercent(left_knee, percent), r = AtPercent(right_knee, percent);
    const MeanDifference mean = l.empty() || r.empty() ? MeanDifference{} : mean_of(l, r);
    symmetry.knee_deg.push_back(DifferenceOf(std::to_string(percent), mean, placement, kOutside));
  }
  return symmetry;
}

}  // namespace lake::compare
