// Solves a re-optimisation from one or many starts, and along its Pareto front of range against misalignment.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lake/redesign/group_problem.h"
#include "lake/synthesis/optimize.h"

namespace lake::redesign {

// One local solve, exchange included.
struct SolveInMotion {
  synthesis::LocalSolve local;
  // Of the goal, larger is better: RoR - w RMS in deg; -percent; -s; -|p| or farthest . p in mm.
  double objective = 0;
  bool holds_on_path = false;  // the limits on misalignment, range and time, within 1e-5

  // Solved; feasible by the closed form; the limits hold on the predicted path.
  bool IsUsable() const { return local.IsUsable() && holds_on_path; }
  double Range_deg() const { return local.evaluation.range_deg; }
};

struct ReoptimizeSolve : SolveInMotion {
  ReoptimizePoint point;                 // the end
  std::optional<Prediction> prediction;  // of the end, by the closed form and the comparison's error

  double Misalignment_percent() const;  // NaN without a prediction
};

// The same for a group: ends and predictions of each person, all with the same links.
struct GroupSolve : SolveInMotion {
  std::vector<ReoptimizePoint> points;
  std::vector<std::optional<Prediction>> predictions;
  std::vector<double> prices;  // of what bounds each person's misalignment, 0 where nothing does
  // How strongly all that is asked of a person holds the links, in units of the goal per mm. Where the worst counts,
  // those without a pull could be left out: the links would stay an optimum.
  std::vector<double> pulls;

  std::vector<double> Misalignments_percent() const;  // NaN without a prediction
};

// The goal's value at a design and its path, as ReoptimizeSolve::objective.
double ObjectiveOf(const ReoptimizeProblem& problem, const ReoptimizePoint& point, double range_deg,
                   const Prediction& prediction);

// Of a constant program both sides of max(d(theta_human(0)), d_min) are tried where the first ends on it. `warm`: the
// start is a solution of a problem close by.
ReoptimizeSolve SolveFrom(const ReoptimizeProblem& problem, const ReoptimizePoint& start,
                          const synthesis::OptimizeOptions& options = {}, bool warm = false);
// The same for a group, from a point for each person.
GroupSolve SolveFrom(const GroupProblem& problem, const std::vector<ReoptimizePoint>& start,
                     const synthesis::OptimizeOptions& options = {}, bool warm = false);

// Is `a` usable, and `b` not or worse? Of equals neither is better.
bool IsBetter(const SolveInMotion& a, const SolveInMotion& b);

// Where the solves of a problem start: `links` in turn, then random ones within the bounds.
std::vector<linkage::Links> StartsOf(const ReoptimizeProblem& problem, const std::vector<linkage::Links>& links,
                                     const synthesis::OptimizeOptions& options);

// The different optima among usable ends of local searches.
class Optima {
 public:
  void Add(bool is_usable, double objective);
  // Of n ends at w different optima, w (n - 1) / (n - w - 2) optima are to be expected in all; the search is over when
  // that is not half a one more than was found (Boender & Rinnooy Kan, Math. Program. 37, 1987).
  bool AreAll() const;

 private:
  int ends_ = 0;
  std::vector<double> objectives_;
};

// The same problem with another goal, without penalty and limit on the misalignment.
ReoptimizeProblem WithGoal(ReoptimizeProblem problem, ReoptimizeProblem::Goal goal,
                           std::optional<double> min_range_deg = {});

struct ReoptimizeResult {
  std::vector<ReoptimizeSolve> starts;  // in order of starting
  int best = -1;                        // index of the best usable start; -1: none

  bool IsSolved() const { return best >= 0; }
  const ReoptimizeSolve& Best() const { return starts.at(best); }
  const ReoptimizeSolve& BestOrFirst() const { return starts.at(IsSolved() ? best : 0); }
};

// From `links` in turn, then from random links within the bounds until there are options.starts. Throws Error for a
// problem or options that fail Check(), Interrupted on a signal.
ReoptimizeResult Reoptimize(const ReoptimizeProblem& problem, const std::vector<linkage::Links>& links,
                            const synthesis::OptimizeOptions& options = {});

// The best from the same starts, but no more of them than it takes for all optima to be likely to have been met;
// nullopt if none is usable.
std::optional<ReoptimizeSolve> FindOptimum(const ReoptimizeProblem& problem, const std::vector<linkage::Links>& links,
                                           const synthesis::OptimizeOptions& options);

// Does one of these starts end in a usable solution?
bool HasSolution(const ReoptimizeProblem& problem, const std::vector<linkage::Links>& links,
                 const synthesis::OptimizeOptions& options);

// Designs count as equal that differ by no more than this.
inline constexpr double kEqualRange_deg = 0.01, kEqualMisalignment_percent = 0.1;

// Of the designs that hold every limit and are equal to this optimum (or better), the one whose joint is nearest to the
// knee: a free program determines the placement only weakly. The optimum itself where it is not fitted.
ReoptimizePoint NearestToKnee(const ReoptimizeProblem& problem, const ReoptimizeSolve& optimum,
                              const synthesis::OptimizeOptions& options = {});

// Where the joint may sit with these links, their program adapted.
struct PlacementRange {
  double within_percent = 0;  // of misalignment: the limit, or that of the point + kEqualMisalignment_percent if larger
  problem::Bounds x_mm, y_mm;  // farthest to either side, the other coordinate adapted
};
// nullopt where a side was not found.
std::optional<PlacementRange> FindPlacementRange(const ReoptimizeProblem& problem, const ReoptimizePoint& point,
                                                 const synthesis::OptimizeOptions& options = {});

struct ParetoPoint {
  double least_range_deg = 0;  // asked for
  ReoptimizePoint point;
  double range_deg = 0, misalignment_percent = 0, rms_mm = 0;
};

// The least misalignment for each of `count` least ranges, evenly spaced from that of the least misalignment to the
// largest range: ends first and last. Swept warm from both ends, and the better of both kept, so the misalignment never
// falls with the range. Without penalty and limit. Empty if an end could not be solved; points in between
// that could not be solved are left out. `step` is called after each of the SolvesOfSweeps(count) in between.
std::vector<ParetoPoint> ParetoFront(
    const ReoptimizeProblem& problem, int count, const std::vector<linkage::Links>& links,
    const synthesis::OptimizeOptions& options = {}, const std::function<void()>& step = [] {});
inline int SolvesOfSweeps(int count) {
  return 2 * (count - 2);
}

}  // namespace lake::redesign
