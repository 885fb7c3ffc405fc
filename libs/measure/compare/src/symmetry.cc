#include "lake/compare/symmetry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/distributions.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/gait/squats.h"

namespace lake::compare {
namespace {

using gait::GaitCycle, gait::LegFitResult, gait::Measured, gait::MovementKind, gait::SitToStand, gait::Squat;

// What is off alike in all of a leg's repetitions, so that their scatter does not show it: by another spot of a marker
// an angle, by the form and the markers of a foot the times of its events.
enum class Alike { kNothing, kKneeAngle, kHipAngle, kEvents };

// A measure that a leg has of its own: when a rise begins and ends, or how fast one walks, is the person's.
template <typename Row>
struct Compared {
  Measured Row::*value;
  Alike alike = Alike::kNothing;
};
constexpr Compared<SitToStand> kOfRises[] = {{&SitToStand::flexion_s},
                                             {&SitToStand::transfer_s},
                                             {&SitToStand::extension_s},
                                             {&SitToStand::knee_seat_off_deg, Alike::kKneeAngle},
                                             {&SitToStand::hip_seat_off_deg, Alike::kHipAngle},
                                             {&SitToStand::knee_max_deg, Alike::kKneeAngle},
                                             {&SitToStand::hip_max_deg, Alike::kHipAngle},
                                             {&SitToStand::knee_extension_max_deg_s},
                                             {&SitToStand::hip_rise},
                                             {&SitToStand::hip_speed_max}};
constexpr Compared<Squat> kOfSquats[] = {{&Squat::knee_max_deg, Alike::kKneeAngle}, {&Squat::knee_extension_deg_s}};
constexpr Compared<GaitCycle> kOfStrides[] = {{&GaitCycle::stance_s, Alike::kEvents},
                                              {&GaitCycle::swing_s, Alike::kEvents},
                                              {&GaitCycle::stance_percent, Alike::kEvents},
                                              {&GaitCycle::knee_heel_strike_deg, Alike::kKneeAngle},
                                              {&GaitCycle::knee_loading_deg, Alike::kKneeAngle},
                                              {&GaitCycle::knee_stance_min_deg, Alike::kKneeAngle},
                                              {&GaitCycle::knee_swing_deg, Alike::kKneeAngle},
                                              {&GaitCycle::knee_range_deg},
                                              {&GaitCycle::thigh_range_deg},
                                              {&GaitCycle::shank_range_deg},
                                              {&GaitCycle::ankle_range_deg},
                                              {&GaitCycle::toe_clearance}};

constexpr double kOutside = 0.05;

// Of the angle between two segments that share a marker, where each of their three markers is off by `sd`.
double PlacementDeg(double sd, double first, double second) {
  const double angle = sd * std::hypot(1 / first, 1 / second, 1 / first + 1 / second);
  return std::isfinite(angle) ? DegreesFromRadians(angle) : 0;
}

double PlacementOf(const motion::LegMotion& motion, Alike alike, double sd) {
  const bool is_angle = alike == Alike::kKneeAngle || alike == Alike::kHipAngle;
  if (!is_angle || motion.unit != motion::LengthUnit::kMm) return 0;
  const double thigh = MedianLength(motion, &motion::LegSample::kh);
  return alike == Alike::kKneeAngle ? PlacementDeg(sd, MedianLength(motion, &motion::LegSample::ak), thigh)
                                    : PlacementDeg(sd, thigh, MedianLength(motion, &motion::LegSample::hw));
}

std::vector<double> Values(const ByRepetition& values_of) {
  std::vector<double> values;
  for (const auto& [repetition, measured] : values_of) values.push_back(measured.value);
  return values;
}

struct MeanDifference {
  double left = kNaN, right = kNaN;
  double sd = kNaN;  // of their difference; of a single repetition it is not known
  double freedom = kInfinity;
};

MeanDifference PairedDifference(const ByRepetition& left, const ByRepetition& right) {
  std::vector<double> of_left, of_right, differences;
  for (const auto& [repetition, measured] : left) {
    const auto other = right.find(repetition);
    if (other == right.end()) continue;
    of_left.push_back(measured.value);
    of_right.push_back(other->second.value);
    differences.push_back(measured.value - other->second.value);
  }
  MeanDifference mean{.left = Mean(of_left), .right = Mean(of_right)};
  if (differences.size() < 2) return mean;
  const auto n = static_cast<double>(differences.size());
  mean.sd = StandardDeviation(differences) / std::sqrt(n);
  mean.freedom = n - 1;
  return mean;
}

MeanDifference WelchDifference(const ByRepetition& left, const ByRepetition& right) {
  MeanDifference mean{.left = Mean(Values(left)), .right = Mean(Values(right))};
  if (left.size() < 2 || right.size() < 2) return mean;
  mean.sd = 0;
  double fourth = 0;
  for (const ByRepetition* side : {&left, &right}) {
    const auto n = static_cast<double>(side->size());
    const double variance = std::pow(StandardDeviation(Values(*side)), 2) / n;
    mean.sd = std::hypot(mean.sd, std::sqrt(variance));
    fourth += variance * variance / (n - 1);
  }
  if (fourth > 0) mean.freedom = std::pow(mean.sd, 4) / fourth;
  return mean;
}

// `alike_sd`: what no number of repetitions makes smaller.
SideDifference DifferenceOf(std::string name, const MeanDifference& mean, double alike_sd, double outside) {
  SideDifference difference{.name = std::move(name), .left = mean.left, .right = mean.right};
  difference.difference = mean.left - mean.right;
  const double upper = 1 - outside / 2, normal = NormalQuantile(upper), student = StudentQuantile(mean.freedom, upper),
               reach = std::hypot(student * mean.sd, normal * alike_sd);
  difference.interval = {difference.difference - reach, difference.difference + reach};
  const double middle = (mean.left + mean.right) / 2;
  const double to_percent = std::abs(middle) <= reach ? kNaN : 100 / middle;  // of what may be nothing there is none
  difference.index_percent = to_percent * difference.difference;
  difference.index_interval = {to_percent * difference.interval.low, to_percent * difference.interval.high};
  if (to_percent < 0) std::swap(difference.index_interval.low, difference.index_interval.high);
  return difference;
}

// The knee angle of each repetition at 0 to 100 %, between the frames.
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

ByRepetition AtPercent(const std::map<int, std::vector<Measured>>& curves, std::size_t percent) {
  ByRepetition values;
  for (const auto& [repetition, curve] : curves)
    if (std::isfinite(curve[percent].value)) values[repetition] = curve[percent];
  return values;
}

MovementKind KindOf(const LegFitResult& fit) {
  return fit.movement.kind.value_or(MovementKind::kSitToStand);
}

const char* RepetitionOf(const LegFitResult& fit) {
  return gait::MovementOf(KindOf(fit)).repetition;
}

struct Times {
  int repetition;
  double from_s, to_s;
};

// What is compared of one leg.
struct Side {
  struct Quantity {
    std::string name;
    ByRepetition values;
    double alike_sd = 0;  // that the scatter of the values does not show
  };
  std::size_t count = 0;
  std::vector<Times> times;
  std::vector<Quantity> quantities;  // in the same order for both legs
  std::map<int, std::vector<Measured>> knee;
};

// Of the events' standard deviation the share in which a person's legs differ, as strides do: the marker set is the
// same.
double BetweenLegs(const ByRepetition& values) {
  constexpr double kShare = 0.5;
  std::vector<double> sds;
  for (const auto& [repetition, measured] : values) sds.push_back(measured.sd);
  return sds.empty() ? 0 : kShare * Mean(sds);
}

template <typename Row, std::size_t kCount>
void TakeRows(const std::vector<Row>& rows, const Compared<Row> (&compared)[kCount], const LegFitResult& fit,
              double sd_mm, Side& side) {
  side.count = rows.size();
  for (const Compared<Row>& one : compared) {
    const auto field = std::ranges::find(Row::Fields(), one.value, &gait::Field<Row>::value);
    Side::Quantity quantity{
        .name = field->Column(fit.motion.unit), .values = {}, .alike_sd = PlacementOf(fit.motion, one.alike, sd_mm)};
    for (const Row& row : rows)
      if (std::isfinite((row.*one.value).value)) quantity.values[row.repetition] = row.*one.value;
    if (one.alike == Alike::kEvents) quantity.alike_sd = BetweenLegs(quantity.values);
    side.quantities.push_back(std::move(quantity));
  }
}

// Without the row of the five-times test. Times from seat-off where the recording begins after the onset; values of
// rises with an onset.
void TakeRises(const LegFitResult& fit, double sd_mm, Side& side) {
  std::vector<SitToStand> rises = gait::MeasureSitToStands(fit);
  std::erase_if(rises, [](const SitToStand& rise) { return rise.repetition == 0; });
  for (const SitToStand& rise : rises)
    side.times.push_back(
        {rise.repetition, std::fmin(rise.onset_s.value, rise.seat_off_s.value), rise.standing_s.value});
  std::erase_if(rises, [](const SitToStand& rise) { return std::isnan(rise.rise_s.value); });
  TakeRows(rises, kOfRises, fit, sd_mm, side);
}

template <typename Row, std::size_t kCount>
void TakeMeasures(const gait::Measures<Row>& measures, Measured Row::*duration_s,
                  const Compared<Row> (&compared)[kCount], const LegFitResult& fit, double sd_mm, Side& side) {
  for (const Row& row : measures.rows)
    side.times.push_back({row.repetition, row.begin_s.value, row.begin_s.value + (row.*duration_s).value});
  TakeRows(measures.rows, compared, fit, sd_mm, side);
}

Side SideOf(const LegFitResult& fit, double sd_mm) {
  Side side;
  if (KindOf(fit) == MovementKind::kWalking)
    TakeMeasures(gait::MeasureGaitCycles(fit), &GaitCycle::stride_s, kOfStrides, fit, sd_mm, side);
  else if (KindOf(fit) == MovementKind::kSquat)
    TakeMeasures(gait::MeasureSquats(fit), &Squat::squat_s, kOfSquats, fit, sd_mm, side);
  else
    TakeRises(fit, sd_mm, side);
  std::erase_if(side.times, [](const Times& of) { return !std::isfinite(of.to_s - of.from_s); });
  side.knee = KneeCurves(fit.motion);
  return side;
}

void CheckSide(const Side& side, const LegFitResult& fit, const char* name) {
  if (side.count == 0) throw Fail("the {} leg: no {} is whole in the recording", name, RepetitionOf(fit));
}

// From the other leg's heel strike to this leg's, which ends the stride.
Side::Quantity StepTimes(const LegFitResult& fit, const LegFitResult& other) {
  Side::Quantity steps{.name = "step_s", .values = {}};
  for (const GaitCycle& stride : gait::MeasureGaitCycles(fit).rows) {
    const double begin_s = stride.begin_s.value, end_s = begin_s + stride.stride_s.value;
    std::vector<motion::StsEvent> between;
    std::ranges::copy_if(other.events, std::back_inserter(between), [&](const motion::StsEvent& event) {
      return event.kind == motion::StsEventKind::kHeelStrike && event.time_s > begin_s && event.time_s < end_s;
    });
    if (between.size() == 1)
      steps.values[stride.repetition] = {end_s - between[0].time_s, std::hypot(stride.begin_s.sd, between[0].sd_s)};
  }
  steps.alike_sd = BetweenLegs(steps.values);
  return steps;
}

// How long both last at the same time. In a walk the legs take turns: a stride goes with that of the right leg which
// begins in it.
double Shared(const Times& left, const Times& right, MovementKind movement) {
  if (movement == MovementKind::kWalking) return right.from_s >= left.from_s && right.from_s < left.to_s ? 1 : 0;
  return std::min(left.to_s, right.to_s) - std::max(left.from_s, right.from_s);
}

// The left leg's number by the right leg's, each with the one with which it shares most.
std::map<int, int> LeftByRight(const std::vector<Times>& left, const std::vector<Times>& right, MovementKind movement) {
  std::map<int, int> left_by_right;
  for (const Times& l : left) {
    const Times* match = nullptr;
    double most = 0;
    for (const Times& r : right) {
      const double shared = Shared(l, r, movement);
      if (!(shared > most) || left_by_right.contains(r.repetition)) continue;
      most = shared;
      match = &r;
    }
    if (match) left_by_right[match->repetition] = l.repetition;
  }
  return left_by_right;
}

MatchedRepetitions Match(const Side& left, const Side& right, MovementKind movement) {
  MatchedRepetitions matched{.left_by_right = LeftByRight(left.times, right.times, movement), .warnings = {}};
  const auto warn = [&](const Times& of, const char* side, const char* other) {
    matched.warnings.push_back(
        fmt::format("{} {} of the {} leg, {:.2f} to {:.2f} s, has no counterpart among the {} leg's: it is left out",
                    gait::MovementOf(movement).repetition, of.repetition, side, of.from_s, of.to_s, other));
  };
  for (const Times& l : left.times)
    if (std::ranges::none_of(matched.left_by_right, [&](const auto& pair) { return pair.second == l.repetition; }))
      warn(l, "left", "right");
  for (const Times& r : right.times)
    if (!matched.left_by_right.contains(r.repetition)) warn(r, "right", "left");
  return matched;
}

template <typename Value>
std::map<int, Value> Renumbered(const std::map<int, Value>& values, const std::map<int, int>& left_by_right) {
  std::map<int, Value> renumbered;
  for (const auto& [repetition, value] : values)
    if (const auto number = left_by_right.find(repetition); number != left_by_right.end())
      renumbered[number->second] = value;
  return renumbered;
}

void CheckAlike(const LegFitResult& left, const LegFitResult& right) {
  const bool is_left_in_px = left.motion.unit == motion::LengthUnit::kPx;
  if (left.motion.unit != right.motion.unit)
    throw Fail("the left leg is in {} and the right leg in {}: give the one in px a scale: {} with a plane, or {}",
               ToString(left.motion.unit), ToString(right.motion.unit), is_left_in_px ? "--camera" : "--right-camera",
               is_left_in_px ? "--scale" : "--right-scale");
  if (KindOf(left) != KindOf(right))
    throw Fail("the left leg shows {}s and the right leg {}s: name one with --movement", RepetitionOf(left),
               RepetitionOf(right));
}

}  // namespace

MatchedRepetitions MatchRepetitions(const LegFitResult& left, const LegFitResult& right) {
  return Match(SideOf(left, 0), SideOf(right, 0), KindOf(left));
}

Symmetry CompareSides(const LegFitResult& left, const LegFitResult& right, const SymmetryOptions& options) {
  CheckAlike(left, right);
  Side l = SideOf(left, options.replacement_sd_mm), r = SideOf(right, options.replacement_sd_mm);
  CheckSide(l, left, "left");
  CheckSide(r, right, "right");
  Symmetry symmetry{.movement = KindOf(left), .left_count = l.count, .right_count = r.count};
  if (options.one_recording) {
    MatchedRepetitions matched = Match(l, r, symmetry.movement);
    symmetry.warnings = std::move(matched.warnings);
    if (symmetry.movement == MovementKind::kWalking) {
      l.quantities.push_back(StepTimes(left, right));
      r.quantities.push_back(StepTimes(right, left));
    }
    for (Side::Quantity& quantity : r.quantities) quantity.values = Renumbered(quantity.values, matched.left_by_right);
    r.knee = Renumbered(r.knee, matched.left_by_right);
  }
  for (const FurtherQuantity& further : options.further) {
    const auto quantity = [&](const ByRepetition& values) {
      return Side::Quantity{further.name, values, values.empty() ? 0 : further.relative_sd * Mean(Values(values))};
    };
    l.quantities.push_back(quantity(further.left));
    r.quantities.push_back(quantity(further.right));
  }
  const auto mean_of = [&](const ByRepetition& of_left, const ByRepetition& of_right) {
    if (of_left.empty() || of_right.empty()) return MeanDifference{};
    return options.one_recording ? PairedDifference(of_left, of_right) : WelchDifference(of_left, of_right);
  };
  std::vector<std::pair<std::size_t, MeanDifference>> known;
  for (std::size_t i = 0; i < l.quantities.size(); ++i) {
    const MeanDifference mean = mean_of(l.quantities[i].values, r.quantities[i].values);
    if (std::isfinite(mean.left - mean.right)) known.emplace_back(i, mean);
  }
  if (known.empty())
    throw Fail("the left leg shows {} {}s and the right leg {}, and none is in both", l.count, RepetitionOf(left),
               r.count);
  for (const auto& [i, mean] : known) {
    const double alike_sd = std::hypot(l.quantities[i].alike_sd, r.quantities[i].alike_sd);
    symmetry.quantities.push_back(
        DifferenceOf(l.quantities[i].name, mean, alike_sd, kOutside / static_cast<double>(known.size())));
    symmetry.is_asymmetric |= symmetry.quantities.back().IsAsymmetric();
  }
  if (std::ranges::all_of(known, [](const auto& one) { return std::isnan(one.second.sd); }))
    symmetry.warnings.push_back(fmt::format(
        "of a single {} nobody knows how much it varies: the differences have no interval; record more of them",
        RepetitionOf(left)));
  const double placement = std::hypot(PlacementOf(left.motion, Alike::kKneeAngle, options.replacement_sd_mm),
                                      PlacementOf(right.motion, Alike::kKneeAngle, options.replacement_sd_mm));
  for (std::size_t percent = 0; percent <= 100; ++percent)
    symmetry.knee_deg.push_back(DifferenceOf(
        std::to_string(percent), mean_of(AtPercent(l.knee, percent), AtPercent(r.knee, percent)), placement, kOutside));
  return symmetry;
}

}  // namespace lake::compare
