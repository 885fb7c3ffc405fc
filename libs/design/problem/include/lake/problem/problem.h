// The synthesis problem as data: what may vary, and what a design must satisfy.
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
#include <vector>

#include "lake/linkage/linkage.h"

namespace lake::problem {

struct Bounds {
  double lower = 0, upper = 0;
};

struct SynthesisProblem {
  double d_min_mm = 242;           // shortest stroke; Jain et al.'s actuator
  std::optional<double> d_max_mm;  // the knee must stand straight at no longer stroke
  std::array<Bounds, 6> bounds{{{50, 100}, {50, 100}, {50, 100}, {50, 100}, {50, 120}, {200, 300}}};  // l1..l6, mm
  linkage::Links start{85, 85, 85, 80, 80, 235};  // the paper's Table 1

  double grashof_margin_mm = 0;      // l3 + l4 <= l1 + l2 - margin
  double singularity_margin_mm = 0;  // l7 <= l2 + d_min - margin

  // Over the whole used range, from d_min until the knee stands at `standing_deg`:
  double knee_torque_nm = 40;                  // constant load that max_force_n refers to
  std::optional<double> max_force_n;           // actuator force that balances it: the force limit, Kind::kForce below
  std::optional<double> min_moment_arm_mm;     // |dd/dtheta|, mm per rad
  std::optional<double> min_transmission_deg;  // angle between coupler and shank link, and its supplement
  double standing_deg = 0;                     // where the used range ends

  std::optional<double> max_angle_deg;  // anatomical cap on theta(d_min)

  // Throws Error naming key and value: not finite, not positive, contradictory bounds, negative margins, ...
  void Check() const;
};

// One thing a design must satisfy: value >= limit, or value <= limit.
struct Requirement {
  enum class Kind {
    kGrashof,       // l1 + l2 - l3 - l4, mm
    kOrder,         // larger - smaller link, mm
    kSingularity,   // l2 + d_min - l7, mm
    kMomentArm,     // smallest moment arm over the used range, mm per rad
    kForce,         // largest actuator force over the used range, N
    kTransmission,  // smallest transmission angle over the used range, deg
    kMaxStroke,     // stroke at standing_deg, mm
    kMaxAngle       // theta(d_min), deg
  };
  // Tells it from the others of a problem.
  struct Id {
    Kind kind = Kind::kGrashof;
    int smaller = -1, larger = -1;  // kOrder only: links, 0..5
    bool operator==(const Id&) const = default;
  };
  Id id;
  std::string name;                      // short, as in the tables: "grashof", "l3 <= l1", "moment arm"
  std::array<double, 6> coefficients{};  // of the links, if it is linear in them
  bool is_lower_limit = true;            // value >= limit
  double limit = 0;
  std::string unit = "mm";

  // Must hold at every pose of the used range.
  bool IsFamily() const {
    return id.kind == Kind::kMomentArm || id.kind == Kind::kForce || id.kind == Kind::kTransmission;
  }
  // coefficients . X >= limit
  bool IsLinear() const { return id.kind == Kind::kGrashof || id.kind == Kind::kOrder; }
  // Concerns poses other than the one at d_min, so the linkage must be able to stand.
  bool NeedsStanding() const { return IsFamily() || id.kind == Kind::kMaxStroke; }
  // Distance of a value to the limit, positive if satisfied; -infinity for NaN, a value that could not be had.
  double Slack(double value) const;
  // "grashof >= 2 mm"
  std::string Text() const;
};

// Those that the problem switches on, the paper's fixed ones first. Grashof and singularity are always among them.
// Evaluate() holds designs against this list; the nonlinear program takes its rows from it (synthesis_program.h).
std::vector<Requirement> RequirementsOf(const SynthesisProblem& problem);

// "l1".."l6".
std::string LinkName(std::size_t index);

}  // namespace lake::problem
