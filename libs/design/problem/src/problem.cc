#include "lake/problem/problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

Requirement Order(int smaller, int larger) {
  std::array<double, 6> coefficients{};
  coefficients[smaller] = -1;
  coefficients[larger] = 1;
  const std::string name = fmt::format("{} ≤ {}", LinkName(smaller), LinkName(larger));
  return {.id = {Requirement::Kind::kOrder, smaller, larger},
          .name = name,
          .coefficients = coefficients,
          .is_lower_limit = true,
          .limit = 0,
          .unit = "mm"};
}

}  // namespace

std::string LinkName(std::size_t index) {
  return fmt::format("l{}", index + 1);
}

void Clearances::Check() const {
  for (const auto& [clearance_mm, key] : {std::pair{seat_mm, "seat_mm"}, {thigh_mm, "limb_mm"}, {shank_mm, "limb_mm"}})
    if (clearance_mm) CheckMargin(*clearance_mm, key);
  if (AreAsked()) linkage::BodyOf(body);
  if (!(seat_edge_mm >= 0 && seat_edge_mm < 5000))
    throw Fail("seat_edge_mm = {} must lie between 0 and 5000", seat_edge_mm);
}

void SynthesisProblem::Check() const {
  CheckPositive(d_min_mm, "d_min_mm");
  if (d_max_mm && !(std::isfinite(*d_max_mm) && *d_max_mm > d_min_mm))
    throw Fail("d_max_mm = {} must exceed d_min_mm = {}", *d_max_mm, d_min_mm);
  CheckPlausible("d_min_mm", d_min_mm, kPlausibleStroke);
  if (d_max_mm) CheckPlausible("d_max_mm", *d_max_mm, kPlausibleStroke);
  for (std::size_t i = 0; i < bounds.size(); ++i) CheckBounds(bounds[i], LinkName(i));
  linkage::CheckLinks(start, "start");
  CheckMargin(grashof_margin_mm, "grashof_mm");
  CheckMargin(singularity_margin_mm, "singularity_mm");
  CheckPositive(knee_torque_nm, "knee_torque_nm");
  CheckPlausible("knee_torque_nm", knee_torque_nm, kPlausibleKneeTorque);
  if (max_force_n) CheckPositive(*max_force_n, "max_force_n");
  if (max_force_n) CheckPlausible("max_force_n", *max_force_n, kPlausibleForce);
  if (min_moment_arm_mm) CheckPositive(*min_moment_arm_mm, "min_moment_arm_mm");
  if (min_transmission_deg && !(*min_transmission_deg > 0 && *min_transmission_deg < 90))
    throw Fail("min_transmission_deg = {} must lie between 0 and 90", *min_transmission_deg);
  if (!(standing_deg >= -30 && standing_deg < 90))
    throw Fail("standing_deg = {} must lie between -30 and 90", standing_deg);
  if (assist && !(*assist >= 0 && *assist <= 1)) throw Fail("assist = {} must lie between 0 and 1", *assist);
  if (profile && !(DegreesFromRadians(profile->LargestAngle()) > standing_deg))
    throw Fail("the load profile ends before standing_deg = {}: its largest knee angle is {}°", standing_deg,
               SignificantText(DegreesFromRadians(profile->LargestAngle()), 4));
  if (actuator) actuator->Check();
  clearances.Check();
  parts.Check();
  if (max_pin_force_n) CheckPositive(*max_pin_force_n, "max_pin_force_n");
  if (max_mount_force_n) CheckPositive(*max_mount_force_n, "max_mount_force_n");
  if (robust_mm && !(*robust_mm > 0 && *robust_mm <= kMostTolerance_mm))
    throw Fail("a tolerance (robust_mm) of {} mm must lie above 0, and not beyond {}", *robust_mm, kMostTolerance_mm);
  if (safety_factor) CheckPositive(*safety_factor, "safety_factor");
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
  return max_angle_deg ? std::min(linkage::kSeated_rad, RadiansFromDegrees(*max_angle_deg)) : linkage::kSeated_rad;
}

void SynthesisProblem::CheckLoad() const {
  if (assist && !profile) throw UsageError("assist is a share of the knee moment: give that with --profile loads.json");
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
  if (actuator.closed_mm && actuator.stroke_mm) {
    const double longest_mm = *actuator.closed_mm + *actuator.stroke_mm;
    problem.d_max_mm = std::min(problem.d_max_mm.value_or(longest_mm), longest_mm);
  }
  if (const std::optional<double> force_n = actuator.LiftingForce())
    problem.max_force_n = std::min(problem.max_force_n.value_or(*force_n), *force_n);
  try {
    problem.Check();
  } catch (const Error& error) {
    throw Fail("the problem with the actuator {}: {}", actuator.name, error.what());
  }
  return problem;
}

std::vector<BuildError> Corners(double tolerance_mm) {
  constexpr unsigned kCorners = 1u << std::tuple_size_v<BuildError>;
  std::vector<BuildError> corners(kCorners);
  for (unsigned corner = 0; corner < kCorners; ++corner)
    for (std::size_t i = 0; i < corners[corner].size(); ++i)
      corners[corner][i] = corner >> i & 1u ? tolerance_mm : -tolerance_mm;
  return corners;
}

SynthesisProblem ProblemOf(const BuildError& build, SynthesisProblem problem) {
  problem.d_min_mm += build.back();
  if (problem.d_max_mm) *problem.d_max_mm += build.back();
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
  if (IsLinear() && limit == 0) return id.kind == Kind::kGrashof ? "Grashof's law" : name;
  const std::string text = fmt::format("{} {} {}", name, is_lower_limit ? "≥" : "≤", SignificantText(limit, 6));
  return unit == "1" ? text : text + " " + unit;
}

std::vector<Requirement> RequirementsOf(const SynthesisProblem& problem) {
  using Kind = Requirement::Kind;
  std::vector<Requirement> all;
  all.push_back({.id = {Kind::kGrashof},
                 .name = "grashof",
                 .coefficients = {1, 1, -1, -1, 0, 0},
                 .is_lower_limit = true,
                 .limit = problem.grashof_margin_mm,
                 .unit = "mm"});
  for (const auto& [smaller, larger] : {std::pair{2, 0}, {2, 1}, {2, 3}, {1, 3}, {0, 3}, {4, 5}, {3, 5}})
    all.push_back(Order(smaller, larger));
  const auto add = [&](Kind kind, const char* name, bool is_lower_limit, std::optional<double> limit, const char* unit,
                       bool along_profile) {
    if (limit)
      all.push_back({.id = {kind},
                     .name = name,
                     .coefficients = {},
                     .is_lower_limit = is_lower_limit,
                     .limit = *limit,
                     .unit = unit,
                     .along_profile = along_profile});
  };
  const auto at_least = [&](Kind kind, const char* name, std::optional<double> limit, const char* unit,
                            bool along_profile = false) { add(kind, name, true, limit, unit, along_profile); };
  const auto at_most = [&](Kind kind, const char* name, std::optional<double> limit, const char* unit,
                           bool along_profile = false) { add(kind, name, false, limit, unit, along_profile); };
  const bool has_profile = problem.HasLoadProfile();
  at_least(Kind::kSingularity, "singularity", problem.singularity_margin_mm, "mm");
  at_least(Kind::kMomentArm, "moment arm", problem.min_moment_arm_mm, "mm");
  at_most(Kind::kForce, "force", problem.max_force_n, "N", has_profile);
  at_most(Kind::kPinForce, "pin force", problem.max_pin_force_n, "N", has_profile);
  at_most(Kind::kMountForce, "mount force", problem.max_mount_force_n, "N", has_profile);
  at_least(Kind::kSafety, "safety factor", problem.safety_factor, "1", has_profile);
  at_least(Kind::kTransmission, "transmission angle", problem.min_transmission_deg, "deg");
  at_most(Kind::kMaxStroke, "stroke when standing", problem.d_max_mm, "mm");
  if (problem.actuator) at_most(Kind::kHolding, "holding force", problem.actuator->holding_force_n, "N", has_profile);
  if (has_profile && (problem.duration_s || problem.SeeksDuration()))
    at_most(Kind::kDuration, "duration", problem.duration_s.value_or(SynthesisProblem::kLongestDuration_s), "s", true);
  const Clearances& clearances = problem.clearances;
  const double profile_rad = has_profile ? problem.profile->LargestAngle() : 0;
  const double seated_rad = clearances.seat_mm ? problem.SeatedAngle_rad() : 0;
  if (has_profile || clearances.seat_mm)
    at_least(Kind::kReach, "range", DegreesFromRadians(std::max(profile_rad, seated_rad)), "deg");
  at_least(Kind::kSeat, "seat clearance", clearances.seat_mm, "mm");
  at_least(Kind::kThigh, "thigh clearance", clearances.thigh_mm, "mm");
  at_least(Kind::kShank, "shank clearance", clearances.shank_mm, "mm");
  at_most(Kind::kMaxAngle, "angle", problem.max_angle_deg, "deg");
  return all;
}

}  // namespace lake::problem
