// Sensitivity of a design to errors of its lengths: one at a time, at random, or by rounding.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/problem/evaluate.h"

namespace lake::problem {

struct SensitivityPoint {
  int link = 0;           // 0..5: l1..l6; 6: the actuator's shortest length, d_min
  double delta_mm = 0;    // change of that length alone
  double range_deg = 0;   // NaN: cannot be assembled at d_min
  bool feasible = false;  // within the bounds and satisfies all requirements, those over the used range too
};

// "l1".."l6", "d_min".
std::string LengthName(int link);

// Each length changed from -span to +span in 2 steps + 1 points: the paper's figure of its "local minimum", on both
// sides, less those that have no length left. `step` is called after each, of one thread at a time. Throws Interrupted
// on a signal.
std::vector<SensitivityPoint> Sensitivity(
    const linkage::Links& links, const SynthesisProblem& problem, double span_mm = 5, int steps = 100,
    const std::function<void()>& step = [] {});
inline int PointsOfSensitivity(int steps) {
  return 7 * (2 * steps + 1);
}

// The scope of a yield, for readers of tables and reports.
inline constexpr const char* kYieldScope =
    "links and the actuator's shortest length, each within the tolerance, and the play of the pins: coupler, slewing "
    "bar and actuator bear forces along their own lines, so play makes them longer or shorter";

// Random builds: every link and d_min are off, and in each hole its pin lies to one side or the other.
struct YieldOptions {
  double tolerance_mm = 0.1;      // every link and d_min uniform within +- this
  double pin_clearance_mm = 0.0;  // by which a hole is wider than its pin: half of it is play to either side
  int samples = 5000;             // standard error of a fraction below 0.71 %
  std::uint64_t seed = 1;

  void Check() const;  // throws Error
  // By how much any length can be off, play included.
  double Most_mm() const;
};

// A fraction of builds with its 95 % interval (Wilson, JASA 22, 1927).
struct Fraction {
  double value = 0, lower = 0, upper = 0;
};

// One limit of the problem over the builds.
struct LimitYield {
  Requirement requirement;
  Fraction kept;
  // What 95 % of the builds keep: the 95th percentile of a value with an upper limit, the 5th of one with a lower; NaN
  // where more than 5 % of the builds have no value.
  double kept_by_95 = 0;
};

struct Yield {
  YieldOptions options;
  Fraction assembled;                                                // can be assembled at d_min
  std::vector<LimitYield> limits;                                    // each of RequirementsOf()
  Fraction all;                                                      // keeps every limit, and can be assembled
  double range_p5_deg = 0, range_median_deg = 0, range_p95_deg = 0;  // of those that can be assembled; NaN if none
  // Margins that no such build can use up: sum of tolerance and play x |derivative|.
  double safe_singularity_margin_mm = 0, safe_grashof_margin_mm = 0;

  const LimitYield* Find(std::string_view name) const;  // nullptr if the problem has none
};

// The builds are held against the problem's limits as they stand: without its bounds on nominal links and its own
// tolerance (robust_mm). The same for any number of threads. Throws Error for options that fail Check(), Interrupted on
// a signal.
Yield EstimateYield(const linkage::Links& links, const SynthesisProblem& problem, const YieldOptions& options = {});

struct RoundedDesign {
  double step_mm = 0;
  linkage::Links links;
  DesignEvaluation evaluation;
  int candidates = 0;  // grid points that were feasible by the quick requirements
};

// The feasible design that is best in what the problem seeks (GoalOf) of those whose links are multiples of the step, a
// few steps around; nullopt if none is feasible. Throws Error for a step that is not positive, or coarser than a
// bound's width.
std::optional<RoundedDesign> RoundLinks(const linkage::Links& links, const SynthesisProblem& problem, double step_mm);

}  // namespace lake::problem
