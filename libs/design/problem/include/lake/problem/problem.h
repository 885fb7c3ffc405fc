// The synthesis problem as data: variables, bounds and requirements.
//
//   max  theta(X, d_min)      Eq. (7)
//    X = (l1, ..., l6)        Eq. (8)
//   s.t. requirements (below), bounds on X
//
// Equation numbers and the constraints of sec. 3 are those of Gautam, Singla & Singla. The defaults are the paper's
// problem: no margins, no load.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/linkage/wear.h"
#include "lake/parts/mechanism.h"
#include "lake/problem/limits.h"
#include "lake/problem/linear_actuator.h"
#include "lake/problem/load_profile.h"

namespace lake::problem {

struct Bounds {
  double lower = 0, upper = 0;
};

// Clearances between linkage and subject in the sagittal plane (linkage/wear.h).
struct Clearances {
  std::optional<double> seat_mm;             // mount, links and actuator from the seat, at kSeated_rad
  std::optional<double> thigh_mm, shank_mm;  // the actuator from the limb, over the whole used range
  person::BodySize body;
  double seat_edge_mm = 0;                   // as linkage::WearOptions has it
  std::array<double, 2> placement_mm{0, 0};  // of the exoskeleton's knee, where a design is held against them …
  std::optional<double> placement_reach_mm;  // … and within this of the knee, on both axes, a program may vary it

  bool AreAsked() const { return seat_mm || thigh_mm || shank_mm; }
  // Throws Error for a clearance that is not 0 or above, or a body that BodyOf refuses.
  void Check() const;
};

struct SynthesisProblem {
  LimitValues limits;     // "max_force_n", …: the rows of kLimits that have a key
  double d_min_mm = 242;  // shortest stroke; Jain et al.'s actuator
  std::array<Bounds, 6> bounds{{{50, 100}, {50, 100}, {50, 100}, {50, 100}, {50, 120}, {200, 300}}};  // l1..l6, mm
  linkage::Links start{85, 85, 85, 80, 80, 235};  // the paper's Table 1

  double grashof_margin_mm = 0;      // l3 + l4 <= l1 + l2 - margin
  double singularity_margin_mm = 0;  // l7 <= l2 + d_min - margin

  // Over the whole used range, from d_min until the knee stands at `standing_deg`:
  double knee_torque_nm = 40;  // constant load, without a profile
  double standing_deg = 0;     // where the used range ends

  linkage::Mount mount = linkage::Mount::kBeside;  // clearances to the limbs are for behind
  Clearances clearances;

  parts::PartOptions parts;  // for the safety factor, and of the linkage on the body

  // The load on the knee over a rise and the actuator's share of it. max_force_n then limits assist x moment / moment
  // arm at each percent, and the range must reach the profile's largest angle. A share of 0 is the same as no profile.
  std::optional<LoadProfile> profile;
  std::optional<double> assist;  // 0..1; absent: 1

  // Its force and speed along the profile and its holding force are limits; WithActuator() sets d_min_mm, d_max_mm and
  // max_force_n to its lengths and its largest force.
  std::optional<LinearActuator> actuator;
  bool rests_anywhere = true;        // its holding force at every sample of the profile, else at standing alone
  std::optional<double> duration_s;  // of the profile's motion, run through evenly; needs profile and actuator

  // Tolerance of every link and of the shortest stroke (with it the longest), the play of the pins included.
  // Requirements hold for all builds within it, and the objective is that of the worst build. Bounds apply to the
  // nominal lengths.
  std::optional<double> robust_mm;
  static constexpr double kMostTolerance_mm = 5;

  enum class Goal {
    kRange,    // the largest range
    kDuration  // the shortest duration that the actuator allows
  } goal = Goal::kRange;
  static constexpr double kLongestDuration_s = 3600;

  bool HasLoadProfile() const { return profile && assist != 0; }
  bool SeeksDuration() const { return goal == Goal::kDuration; }
  // Torque in N m, positive in extension, that the actuator balances at a sample of the profile; 0 where the moment is
  // not known.
  double TorqueAt(const LoadSample& sample) const;
  linkage::WearOptions Wear() const;
  // The knee angle at which a person sits: kSeated_rad, or the cap if that is less.
  double SeatedAngle_rad() const;
  // The knee angle that the range must reach: the profile's largest, and that of each limit where a person sits.
  std::optional<double> LeastRange_deg() const;
  std::optional<double> DurationLimit_s() const;  // where a duration is asked for or sought
  // What the linkage bears under the constant torque, or at a sample of the profile.
  PoseLoad ConstantLoad() const;
  PoseLoad LoadAt(const LoadSample& sample) const;

  // Throws Error naming key and value: not finite, not positive, contradictory bounds, negative margins, ...
  void Check() const;
  // Throws UsageError where a share, a rest or a duration is asked for, but no load profile, for a rest no actuator or,
  // for a duration, none with a known speed is there.
  void CheckLoad() const;
};

// Errors of a build: l1..l6 and the strokes, mm.
using BuildError = std::array<double, 7>;
// All 128 builds with every length off by the whole tolerance, either way; none without a tolerance.
std::vector<BuildError> Corners(std::optional<double> tolerance_mm);
// The problem that a build must satisfy: with its strokes, without tolerance and bounds on the links.
SynthesisProblem ProblemOf(const BuildError& build, SynthesisProblem problem);
linkage::Links LinksOf(const BuildError& build, const linkage::Links& links);

// A requirement on designs: value >= limit, or value <= limit.
struct Requirement {
  std::string_view name;  // unique, short, as in the tables: "grashof", "l3 ≤ l1", "moment arm"; of static storage
  bool is_lower_limit = true;  // value >= limit
  double limit = 0;
  std::string unit = "mm";
  std::size_t row = 0;         // of kLimits
  bool along_profile = false;  // at the samples of the load profile, else over the used range
  bool is_sought = false;      // the limit is what is minimised

  const LimitInfo& Info() const { return kLimitInfos[row]; }
  bool IsOnLinks() const { return Info().place == Place::kLinks; }
  // Of a pose other than that at d_min, so the linkage must be able to stand; of many, but for the length at standing.
  bool NeedsStanding() const { return Info().place != Place::kShortest && !IsOnLinks(); }
  bool IsFamily() const { return NeedsStanding() && Info().place != Place::kStanding; }
  bool IsClearance() const { return Info().obstacle != Obstacle::kNone; }
  // coefficients . X >= limit
  bool IsLinear() const { return IsOnLinks() && name != kSingularity; }
  // Distance of a value to the limit, positive if satisfied; -infinity for NaN, a value that could not be had.
  double Slack(double value) const;
  // "grashof >= 2 mm"
  std::string Text() const;

  static constexpr std::string_view kGrashof = "grashof", kSingularity = "singularity", kDuration = "duration";
};

// >= 0 where a ratio keeps a limit, which is divided by `scale` (1, or of its order).
template <typename T, typename Limit>
T MarginOf(const LimitInfo& info, const Limit& limit, const Ratio<T>& ratio, double scale = 1) {
  return info.is_lower ? ratio.over - limit * ratio.under : (limit * ratio.under - ratio.over) * (1 / scale);
}

// The active requirements of a problem, the paper's fixed ones first. Grashof and singularity are always among them.
// Evaluate() checks designs against this list; the nonlinear program takes its rows from it (synthesis_program.h).
std::vector<Requirement> RequirementsOf(const SynthesisProblem& problem);

// The problem with its actuator's lengths and largest force, as far as these are known; tighter limits stay. Throws
// Error where the actuator's lengths contradict the problem.
SynthesisProblem WithActuator(SynthesisProblem problem);

// "l1".."l6".
std::string LinkName(std::size_t index);

}  // namespace lake::problem
