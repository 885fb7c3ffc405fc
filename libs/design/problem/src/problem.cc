#include "lake/problem/problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/plausible.h"
#include "lake/core/uncertain_text.h"

namespace lake::problem {
namespace {

void CheckPositive(double value, std::string_view key) {
  if (!(std::isfinite(value) && value > 0)) throw Fail("{} = {} must be a finite number above 0", key, value);
}

void CheckMargin(double value, std::string_view key) {
  if (!(std::isfinite(value) && value >= 0)) throw Fail("{} = {} must be a finite number, 0 or above", key, value);
}

void CheckBounds(const Bounds& bounds, const std::string& key) {
  CheckPositive(bounds.lower, key + " lower bound");
  CheckPositive(bounds.upper, key + " upper bound");
  if (bounds.lower > bounds.upper)
    throw Fail("bounds of {} contradict each other: lower {} is above upper {}", key, bounds.lower, bounds.upper);
  constexpr double kLongest_mm = 1e4;  // as for any link
  if (bounds.upper > kLongest_mm) throw Fail("{} upper bound {} is beyond {} mm", key, bounds.upper, kLongest_mm);
}

// Of the row of kLimits with this index; nullopt where the problem has no such limit.
std::optional<double> LimitOf(const SynthesisProblem& problem, std::size_t index) {
  if (const char* key = kLimitInfos[index].key; *key) return problem.limits[key];
  std::optional<double> limit;
  VisitLimit(index, [&](const auto& row) {
    if constexpr (!std::is_null_pointer_v<std::remove_cvref_t<decltype(row.value)>>) limit = row.value(problem);
  });
  return limit;
}

}  // namespace

std::string LinkName(std::size_t index) {
  return fmt::format("l{}", index + 1);
}

void Clearances::Check() const {
  for (const auto& [clearance_mm, key] : {std::pair{seat_mm, "seat_mm"}, {thigh_mm, "limb_mm"}, {shank_mm, "limb_mm"}})
    if (clearance_mm) CheckMargin(*clearance_mm, key);
  if (AreAsked()) person::BodyOf(body);
  if (!(seat_edge_mm >= 0 && seat_edge_mm < 5000))
    throw Fail("seat_edge_mm = {} must lie between 0 and 5000", seat_edge_mm);
}

void SynthesisProblem::Check() const {
  CheckPositive(d_min_mm, "d_min_mm");
  CheckPlausible("d_min_mm", d_min_mm, kPlausibleStroke);
  const std::optional<double>&d_max_mm = limits["d_max_mm"], &max_angle_deg = limits["max_angle_deg"];
  if (d_max_mm && !(std::isfinite(*d_max_mm) && *d_max_mm > d_min_mm))
    throw Fail("d_max_mm = {} must exceed d_min_mm = {}", *d_max_mm, d_min_mm);
  if (d_max_mm) CheckPlausible("d_max_mm", *d_max_mm, kPlausibleStroke);
  for (std::size_t i = 0; i < bounds.size(); ++i) CheckBounds(bounds[i], LinkName(i));
  linkage::CheckLinks(start, "start");
  CheckMargin(grashof_margin_mm, "grashof_mm");
  CheckMargin(singularity_margin_mm, "singularity_mm");
  CheckPositive(knee_torque_nm, "knee_torque_nm");
  CheckPlausible("knee_torque_nm", knee_torque_nm, kPlausibleKneeTorque);
  for (const LimitInfo& info : kLimitInfos) {
    if (!*info.key || !limits[info.key]) continue;
    const double value = *limits[info.key];
    if (info.below == kInfinity)
      CheckPositive(value, info.key);
    else if (!(value > 0 && value < info.below))
      throw Fail("{} = {} must lie between 0 and {}", info.key, value, info.below);
    if (std::string_view(info.key) == "max_force_n") CheckPlausible(info.key, value, kPlausibleForce);
  }
  if (!(standing_deg >= -30 && standing_deg < 90))
    throw Fail("standing_deg = {} must lie between -30 and 90", standing_deg);
  if (assist && !(*assist >= 0 && *assist <= 1)) throw Fail("assist = {} must lie between 0 and 1", *assist);
  if (profile && !(DegreesFromRadians(profile->LargestAngle()) > standing_deg))
    throw Fail("the load profile ends before standing_deg = {}: its largest knee angle is {}°", standing_deg,
               SignificantText(DegreesFromRadians(profile->LargestAngle()), 4));
  if (actuator) actuator->Check();
  clearances.Check();
  parts.Check();
  if (robust_mm && !(*robust_mm > 0 && *robust_mm <= kMostTolerance_mm))
    throw Fail("a tolerance (robust_mm) of {} mm must lie above 0, and not beyond {}", *robust_mm, kMostTolerance_mm);
  if (duration_s && !(*duration_s > 0 && *duration_s <= kLongestDuration_s))
    throw Fail("duration_s = {} must lie above 0, and not beyond {}", *duration_s, kLongestDuration_s);
  if (max_angle_deg && !(*max_angle_deg > standing_deg && *max_angle_deg <= 180))
    throw Fail("max_angle_deg = {} must lie above standing_deg = {} and not beyond 180", *max_angle_deg, standing_deg);
}

double SynthesisProblem::TorqueAt(const LoadSample& sample) const {
  return std::isnan(sample.knee_nm) ? 0 : assist.value_or(1) * sample.knee_nm;
}

linkage::WearOptions SynthesisProblem::Wear() const {
  return {.bar_width_mm = parts.bar_width_mm,
          .actuator_diameter_mm = parts.actuator_diameter_mm,
          .seat_edge_mm = clearances.seat_edge_mm,
          .placement_mm = clearances.placement_mm,
          .mount = mount,
          .has_wide_seat = clearances.seat_mm.has_value()};
}

double SynthesisProblem::SeatedAngle_rad() const {
  const std::optional<double>& cap_deg = limits["max_angle_deg"];
  return cap_deg ? std::min(linkage::kSeated_rad, RadiansFromDegrees(*cap_deg)) : linkage::kSeated_rad;
}

std::optional<double> SynthesisProblem::LeastRange_deg() const {
  std::optional<double> least_rad;
  if (HasLoadProfile()) least_rad = profile->LargestAngle();
  for (std::size_t i = 0; i < kLimitCount; ++i)
    if (kLimitInfos[i].place == Place::kSeated && LimitOf(*this, i))
      least_rad = std::max(least_rad.value_or(0), SeatedAngle_rad());
  return least_rad ? std::optional(DegreesFromRadians(std::max(0.0, *least_rad))) : std::nullopt;
}

std::optional<double> SynthesisProblem::DurationLimit_s() const {
  if (!HasLoadProfile() || !(duration_s || SeeksDuration())) return std::nullopt;
  return duration_s.value_or(kLongestDuration_s);
}

PoseLoad SynthesisProblem::ConstantLoad() const {
  return {.torque_nmm = knee_torque_nm * kMillimetresPerMetre,
          .capacity = parts::CapacityOf(parts),
          .speed = actuator ? actuator->SpeedLines() : std::vector<SpeedLine>()};
}

PoseLoad SynthesisProblem::LoadAt(const LoadSample& sample) const {
  PoseLoad load = ConstantLoad();
  load.torque_nmm = TorqueAt(sample) * kMillimetresPerMetre;
  load.rad_per_rise = sample.rad_per_rise;
  return load;
}

void SynthesisProblem::CheckLoad() const {
  if (assist && !profile) throw UsageError("assist is a share of the knee moment: give that with --profile loads.json");
  if (!rests_anywhere && !(actuator && HasLoadProfile()))
    throw UsageError(
        "rest says where an actuator must hold its share: give --actuator, --profile loads.json, and an --assist above "
        "0");
  if (!duration_s && goal == Goal::kRange) return;
  if (!HasLoadProfile())
    throw UsageError("a duration depends on the knee moment: give --profile loads.json, and an --assist above 0");
  if (!actuator) throw UsageError("a duration depends on how fast the actuator is: give --actuator");
  if (!actuator->HasSpeed())
    throw UsageError("the speed of the actuator {} is not known, so there is no duration for it", actuator->name);
}

SynthesisProblem WithActuator(SynthesisProblem problem) {
  if (!problem.actuator) return problem;
  const LinearActuator& actuator = *problem.actuator;
  if (actuator.closed_mm) problem.d_min_mm = *actuator.closed_mm;
  if (actuator.closed_mm && actuator.travel_mm) {
    const double longest_mm = *actuator.closed_mm + *actuator.travel_mm;
    auto& d_max_mm = problem.limits["d_max_mm"];
    d_max_mm = std::min(d_max_mm.value_or(longest_mm), longest_mm);
  }
  if (const std::optional<double> force_n = actuator.LiftingForce()) {
    auto& max_force_n = problem.limits["max_force_n"];
    max_force_n = std::min(max_force_n.value_or(*force_n), *force_n);
  }
  try {
    problem.Check();
  } catch (const Error& error) {
    throw Fail("the problem with the actuator {}: {}", actuator.name, error.what());
  }
  return problem;
}

std::vector<BuildError> Corners(std::optional<double> tolerance_mm) {
  if (!tolerance_mm) return {};
  constexpr unsigned kCorners = 1u << std::tuple_size_v<BuildError>;
  std::vector<BuildError> corners(kCorners);
  for (unsigned corner = 0; corner < kCorners; ++corner)
    for (std::size_t i = 0; i < corners[corner].size(); ++i)
      corners[corner][i] = corner >> i & 1u ? *tolerance_mm : -*tolerance_mm;
  return corners;
}

SynthesisProblem ProblemOf(const BuildError& build, SynthesisProblem problem) {
  problem.d_min_mm += build.back();
  if (auto& d_max_mm = problem.limits["d_max_mm"]) *d_max_mm += build.back();
  problem.robust_mm.reset();
  problem.bounds.fill({-kInfinity, kInfinity});
  return problem;
}

linkage::Links LinksOf(const BuildError& build, const linkage::Links& links) {
  auto values = links.Values();
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += build[i];
  return linkage::Links::FromValues(values);
}

double Requirement::Slack(double value) const {
  if (std::isnan(value)) return -std::numeric_limits<double>::infinity();
  return is_lower_limit ? value - limit : limit - value;
}

std::string Requirement::Text() const {
  if (IsLinear() && limit == 0) return name == kGrashof ? "Grashof's law" : std::string(name);
  const std::string text = fmt::format("{} {} {}", name, is_lower_limit ? "≥" : "≤", SignificantText(limit, 6));
  return unit == "1" ? text : text + " " + unit;
}

std::vector<Requirement> RequirementsOf(const SynthesisProblem& problem) {
  std::vector<Requirement> all;
  for (std::size_t i = 0; i < kLimitCount; ++i) {
    const std::optional<double> limit = LimitOf(problem, i);
    if (!limit) continue;
    const LimitInfo& info = kLimitInfos[i];
    const bool is_loaded = info.place == Place::kLoaded || info.place == Place::kAtRest;
    all.push_back({.name = info.name,
                   .is_lower_limit = info.is_lower,
                   .limit = *limit,
                   .unit = info.unit,
                   .row = i,
                   .along_profile = info.place == Place::kProfile || (is_loaded && problem.HasLoadProfile()),
                   .is_sought = info.name == Requirement::kDuration && problem.SeeksDuration()});
  }
  return all;
}

std::size_t LimitValues::IndexOf(std::string_view key) {
  const auto found = std::ranges::find(kLimitInfos, key, &LimitInfo::key);
  if (key.empty() || found == kLimitInfos.end()) throw std::logic_error(fmt::format("no limit is called '{}'", key));
  return static_cast<std::size_t>(found - kLimitInfos.begin());
}

}  // namespace lake::problem
