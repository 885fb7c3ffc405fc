#include "lake/problem/assistance.h"

#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"

namespace lake::problem {
namespace {

constexpr double kMillimetresPerMetre = 1000;

// A solver leaves a force this much above its limit.
bool Lifts(const LinearActuator& actuator, double force_n) {
  constexpr double kRounding = 1e-6;
  return !(std::abs(force_n) > actuator.LiftingForce().value_or(kInfinity) * (1 + kRounding));
}

AssistanceRow RowOf(const linkage::Links& links, const linkage::UsedRange& range, const SynthesisProblem& problem,
                    const LoadSample& sample) {
  AssistanceRow row{
      .percent = sample.percent, .knee_deg = DegreesFromRadians(sample.knee_rad), .knee_nm = sample.knee_nm};
  const std::optional<double> stroke = ProfileStroke(links, range, sample.knee_rad);
  if (!stroke) return row;
  const linkage::Transmission transmission = linkage::TransmissionOf(links, linkage::RequirePose(links, *stroke));
  row.stroke_mm = *stroke;
  row.moment_arm_mm = transmission.moment_arm_mm;
  row.speed_mm_s = sample.rad_per_rise / transmission.radians_per_mm;  // per rise; divided by its duration later
  if (!std::isnan(sample.knee_nm)) row.force_n = linkage::ActuatorForce(transmission, problem.TorqueAt(sample));
  if (problem.actuator && problem.actuator->HasSpeed())
    row.least_duration_s =
        Lifts(*problem.actuator, row.force_n) ? DurationAt(transmission, problem, sample) : kInfinity;
  return row;
}

// The first row with the largest value; nullptr if no row has one.
const AssistanceRow* RowWithLongest(const std::vector<AssistanceRow>& rows) {
  const AssistanceRow* longest = nullptr;
  for (const AssistanceRow& row : rows)
    if (!std::isnan(row.least_duration_s) && (!longest || row.least_duration_s > longest->least_duration_s))
      longest = &row;
  return longest;
}

// The knee's power against the actuator's largest.
void FindBound(const SynthesisProblem& problem, Assistance& assistance) {
  const double most_w = problem.actuator->LargestPower();
  if (!std::isfinite(most_w)) return;
  for (const int i : SamplesInUse(problem)) {
    const LoadSample& sample = problem.profile->samples[i];
    const double needed_s = std::abs(problem.TorqueAt(sample) * sample.rad_per_rise) / most_w;
    if (std::isnan(assistance.bound_s) || needed_s > assistance.bound_s) {
      assistance.bound_s = needed_s;
      assistance.bound_percent = sample.percent;
    }
  }
}

}  // namespace

std::vector<int> SamplesInUse(const SynthesisProblem& problem) {
  constexpr double kRounding_rad = 1e-9;
  std::vector<int> samples;
  const std::vector<LoadSample>& all = problem.profile->samples;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].knee_rad >= RadiansFromDegrees(problem.standing_deg) - kRounding_rad)
      samples.push_back(static_cast<int>(i));
  return samples;
}

std::optional<double> ProfileStroke(const linkage::Links& links, const linkage::UsedRange& range, double knee_rad) {
  // A solver leaves the range this far short of what it must reach.
  constexpr double kRounding_rad = 1e-5;
  if (knee_rad > range.theta_at_lower_rad && knee_rad <= range.theta_at_lower_rad + kRounding_rad)
    return range.stroke.lower_mm;
  if (knee_rad < range.theta_at_upper_rad && knee_rad >= range.theta_at_upper_rad - kRounding_rad)
    return range.stroke.upper_mm;
  return linkage::StrokeForAngle(links, range, knee_rad);
}

double DurationAt(const linkage::Transmission& transmission, const SynthesisProblem& problem,
                  const LoadSample& sample) {
  if (!problem.actuator) return 0;
  const double force_n = std::abs(linkage::ActuatorForce(transmission, problem.TorqueAt(sample)));
  const double mm_per_rise = std::abs(sample.rad_per_rise) * transmission.moment_arm_mm;
  const double speed_mm_s = problem.actuator->SpeedAt(force_n);
  return speed_mm_s > 0 ? mm_per_rise / speed_mm_s : kInfinity;
}

const AssistanceRow* Assistance::Largest(double AssistanceRow::*column) const {
  const AssistanceRow* largest = nullptr;
  for (const AssistanceRow& row : rows)
    if (!std::isnan(row.*column) && (!largest || std::abs(row.*column) > std::abs(largest->*column))) largest = &row;
  return largest;
}

Assistance FindAssistance(const linkage::Links& links, const SynthesisProblem& problem) {
  const linkage::UsedRange range =
      linkage::FindUsedRange(links, problem.d_min_mm, problem.d_max_mm, RadiansFromDegrees(problem.standing_deg));
  Assistance assistance;
  for (const LoadSample& sample : problem.profile->samples)
    assistance.rows.push_back(RowOf(links, range, problem, sample));
  if (const AssistanceRow* longest = RowWithLongest(assistance.rows)) {
    assistance.shortest_s = longest->least_duration_s;
    assistance.limiting_percent = longest->percent;
  }
  if (problem.actuator) {
    assistance.speed_under_load_is_known = problem.actuator->HasForceSpeedLaw();
    FindBound(problem, assistance);
  }
  const bool is_possible = std::isfinite(assistance.shortest_s) && assistance.shortest_s > 0;
  assistance.duration_s =
      problem.duration_s.value_or(is_possible ? assistance.shortest_s : problem.profile->duration_s);
  for (AssistanceRow& row : assistance.rows) {
    row.time_s = row.percent / 100 * assistance.duration_s;
    row.speed_mm_s /= assistance.duration_s;
    row.power_w = row.force_n * row.speed_mm_s / kMillimetresPerMetre;
  }
  return assistance;
}

}  // namespace lake::problem
