#include "lake/problem/assistance.h"

#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/problem/evaluate.h"

namespace lake::problem {
namespace {

// A solver leaves a force above its limit, and the pace that it was solved for a little off.
bool Lifts(const LinearActuator& actuator, double force_n) {
  constexpr double kRounding = 1e-5;
  return !(std::abs(force_n) > actuator.LiftingForce().value_or(kInfinity) * (1 + kRounding));
}

// Where the profile's sample has the linkage; nullopt beyond the used range. No pace changes that.
std::optional<linkage::Pose> PoseAt(const linkage::Links& links, const linkage::UsedRange& range,
                                    const LoadSample& sample) {
  const std::optional<double> stroke = ProfileStroke(links, range, sample.knee_rad);
  return stroke ? std::optional(linkage::RequirePose(links, *stroke)) : std::nullopt;
}

AssistanceRow AssistanceAt(const linkage::Links& links, const std::optional<linkage::Pose>& pose,
                           const SynthesisProblem& problem, const LoadSample& sample) {
  AssistanceRow row{
      .percent = sample.percent, .knee_deg = DegreesFromRadians(sample.knee_rad), .knee_nm = sample.knee_nm};
  if (!pose) return row;
  const linkage::Transmission transmission = linkage::TransmissionOf(links, *pose);
  row.stroke_mm = pose->stroke_mm;
  row.moment_arm_mm = transmission.moment_arm_mm;
  row.speed_mm_s = sample.rad_per_rise / transmission.radians_per_mm;  // per rise; divided by its duration later
  if (!std::isnan(sample.knee_nm)) row.force_n = linkage::ActuatorForce(transmission, problem.TorqueAt(sample));
  if (problem.actuator && problem.actuator->HasSpeed())
    row.least_duration_s =
        Lifts(*problem.actuator, row.force_n)
            ? ValueInPose(links, problem, RowOf(Requirement::kDuration), problem.LoadAt(sample), pose)
            : kInfinity;
  return row;
}

// The row with the largest magnitude of a column; nullptr if none is known.
const AssistanceRow* LargestOf(std::span<const AssistanceRow> rows, double AssistanceRow::*column) {
  const AssistanceRow* largest = nullptr;
  for (const AssistanceRow& row : rows)
    if (!std::isnan(row.*column) && (!largest || std::abs(row.*column) > std::abs(largest->*column))) largest = &row;
  return largest;
}

// The shortest duration T with needed_s(T) <= T, to rounding: the first from `from_s` on by steps of 2 %, bisected.
// Infinite where there is none.
template <typename Needed>
double FirstEnough(double from_s, const Needed& needed_s) {
  constexpr double kStep = 1.02;
  constexpr int kHalvings = 60;
  if (needed_s(from_s) <= from_s) return from_s;
  double less_s = from_s, enough_s = from_s * kStep;
  while (!(needed_s(enough_s) <= enough_s)) {
    if (enough_s > SynthesisProblem::kLongestDuration_s) return kInfinity;
    less_s = std::exchange(enough_s, enough_s * kStep);
  }
  for (int i = 0; i < kHalvings; ++i) {
    const double middle_s = std::midpoint(less_s, enough_s);
    (needed_s(middle_s) <= middle_s ? enough_s : less_s) = middle_s;
  }
  return enough_s;
}

constexpr double kNoRise_s = 1e-3;  // shorter than any rise

// The duration T = needed_s(T) to which needed_s leads from `from_s` on; nullopt where it leads to none. Where a slower
// rise needs more this is the shortest, be it that none slower is possible.
template <typename Needed>
std::optional<double> LedTo(double from_s, const Needed& needed_s) {
  constexpr double kSame = 1e-12;
  constexpr int kMost = 100;
  for (int i = 0; i < kMost && std::isfinite(from_s) && from_s > 0; ++i)
    if (const double last_s = std::exchange(from_s, needed_s(from_s)); std::abs(from_s / last_s - 1) < kSame)
      return from_s;
  return std::nullopt;
}

// A design along the load profile at any pace.
class AlongProfile {
 public:
  AlongProfile(const linkage::Links& links, const SynthesisProblem& problem) : links_(links), problem_(problem) {
    const linkage::UsedRange range = linkage::FindUsedRange(links, problem.d_min_mm, problem.limits["d_max_mm"],
                                                            RadiansFromDegrees(problem.standing_deg));
    for (const LoadSample& sample : problem.profile->samples) poses_.push_back(PoseAt(links, range, sample));
  }

  // Under the moments of a rise in this time, as far as the profile says what pace adds to them.
  std::vector<AssistanceRow> RowsAt(double duration_s) const {
    const LoadProfile profile = AtPace(*problem_.profile, duration_s).value_or(*problem_.profile);
    std::vector<AssistanceRow> rows;
    for (std::size_t i = 0; i < poses_.size(); ++i)
      rows.push_back(AssistanceAt(links_, poses_[i], problem_, profile.samples[i]));
    return rows;
  }

  void FindShortest(Assistance& assistance) const {
    const std::vector<AssistanceRow> as_given = RowsAt(problem_.profile->moments_s);
    if (!LargestOf(as_given, &AssistanceRow::least_duration_s)) return;
    // No pace is faster than the path at the speed without load.
    const double path_s =
        std::abs(LargestOf(as_given, &AssistanceRow::speed_mm_s)->speed_mm_s) / problem_.actuator->SpeedAt(0);
    const auto needed_s = [&](double duration_s) {
      const std::vector<AssistanceRow> rows = RowsAt(duration_s);
      return LargestOf(rows, &AssistanceRow::least_duration_s)->least_duration_s;
    };
    const std::optional<double> led_to_s = LedTo(problem_.profile->duration_s, needed_s);
    assistance.shortest_s = led_to_s ? *led_to_s : FirstEnough(std::max(path_s, kNoRise_s), needed_s);
    const std::vector<AssistanceRow> rows =
        RowsAt(std::min(assistance.shortest_s, SynthesisProblem::kLongestDuration_s));
    const AssistanceRow* limiting = LargestOf(rows, &AssistanceRow::least_duration_s);
    constexpr double kSame = 1e-9;
    assistance.force_is_limit = limiting->least_duration_s < assistance.shortest_s * (1 - kSame);
    if (assistance.force_is_limit)
      limiting = LargestOf(rows, &AssistanceRow::force_n);
    else
      assistance.shortest_s = limiting->least_duration_s;
    assistance.limiting_percent = limiting->percent;
  }

 private:
  const linkage::Links links_;
  const SynthesisProblem& problem_;
  std::vector<std::optional<linkage::Pose>> poses_;
};

// The knee's power against the actuator's largest.
void FindBound(const SynthesisProblem& problem, Assistance& assistance) {
  const double most_w = problem.actuator->LargestPower();
  if (!std::isfinite(most_w)) return;
  const std::vector<int> in_use = SamplesInUse(problem);
  const auto needed_s = [&](double duration_s) {
    const LoadProfile profile = AtPace(*problem.profile, duration_s).value_or(*problem.profile);
    double most_s = 0;
    for (const int i : in_use) {
      const LoadSample& sample = profile.samples[i];
      const double sample_s = std::abs(problem.TorqueAt(sample) * sample.rad_per_rise) / most_w;
      if (sample_s > most_s) {
        most_s = sample_s;
        assistance.bound_percent = sample.percent;
      }
    }
    return most_s;
  };
  assistance.bound_s = FirstEnough(kNoRise_s, needed_s);
  needed_s(assistance.bound_s);
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

const AssistanceRow* Assistance::Largest(double AssistanceRow::*column) const {
  return LargestOf(rows, column);
}

double DurationUnderMoments(const linkage::Links& links, const SynthesisProblem& problem) {
  const std::vector<AssistanceRow> rows = AlongProfile(links, problem).RowsAt(problem.profile->moments_s);
  const AssistanceRow* longest = LargestOf(rows, &AssistanceRow::least_duration_s);
  return longest ? longest->least_duration_s : kNaN;
}

Assistance FindAssistance(const linkage::Links& links, const SynthesisProblem& problem) {
  const AlongProfile along(links, problem);
  Assistance assistance;
  along.FindShortest(assistance);
  if (problem.actuator) {
    assistance.speed_under_load_is_known = problem.actuator->HasForceSpeedLaw();
    FindBound(problem, assistance);
  }
  const bool is_possible = std::isfinite(assistance.shortest_s) && assistance.shortest_s > 0;
  assistance.duration_s =
      problem.duration_s.value_or(is_possible ? assistance.shortest_s : problem.profile->duration_s);
  assistance.moments_s = problem.profile->HasPace() ? assistance.duration_s : problem.profile->moments_s;
  assistance.rows = along.RowsAt(assistance.duration_s);
  for (AssistanceRow& row : assistance.rows) {
    row.time_s = row.percent / 100 * assistance.duration_s;
    row.speed_mm_s /= assistance.duration_s;
    row.power_w = row.force_n * row.speed_mm_s / kMillimetresPerMetre;
  }
  return assistance;
}

}  // namespace lake::problem
