// Solves a redesign from one or many starts, and along its Pareto front of range against misalignment.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "lake/redesign/redesign_problem.h"
#include "lake/synthesis/optimize.h"

namespace lake::redesign {

// Where a local solve ends: for one person, or for a group with the same links.
struct RedesignEnd {
  // Of the goal, larger is better: RoR less penalties in deg; -percent; -s; -N; -|p|, farthest . p or a margin in mm.
  double objective = 0;
  bool is_usable = false;             // solved; feasible by the closed form; the limits hold on the predicted path
  std::vector<RedesignPoint> points;  // of each person
  std::vector<double> multipliers;    // of what bounds each person's misalignment, 0 where nothing does
  // How strongly all that is asked of a person holds the links, in units of the goal per mm. Where the worst counts,
  // those without a pull could be left out: the links would stay an optimum.
  std::vector<double> pulls;

  bool IsUsable() const { return is_usable; }
  const linkage::Links& Links() const { return points.front().links; }
  const RedesignPoint& Point() const { return points.front(); }  // of one person
};
// From one process to another.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RedesignEnd, objective, is_usable, points, multipliers, pulls)

// One local solve, exchange included.
struct RedesignSolve : RedesignEnd {
  synthesis::LocalSolve local;
  bool holds_on_path = false;                          // the limits on misalignment, range and time, within 1e-5
  std::vector<std::optional<Prediction>> predictions;  // of the ends, by the closed form and the comparison's error

  double Range_deg() const { return local.evaluation.range_deg; }
  // Of one person.
  const std::optional<Prediction>& Predicted() const { return predictions.front(); }
  double Misalignment_percent() const;  // NaN without a prediction
};

// From a point for each person. Of a constant program both sides of max(d(theta_human(0)), d_min) are tried where the
// first ends on it. `warm`: the start is a solution of a problem close by.
RedesignSolve SolveFrom(const GroupProblem& problem, const std::vector<RedesignPoint>& start,
                        const synthesis::OptimizeOptions& options = {}, bool warm = false);
RedesignSolve SolveFrom(const RedesignProblem& problem, const RedesignPoint& start,
                        const synthesis::OptimizeOptions& options = {}, bool warm = false);

// The same problem with another goal, without penalty and limit on the misalignment.
RedesignProblem WithGoal(RedesignProblem problem, RedesignProblem::Goal goal, std::optional<double> min_range_deg = {});

using RedesignResult = synthesis::MultiStart<RedesignSolve>;

// From `links` in turn, then from random links within the bounds until there are options.starts. Throws Error for a
// problem or options that fail Check(), Interrupted on a signal.
RedesignResult Redesign(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                        const synthesis::OptimizeOptions& options = {});

// The best from the same starts, but no more of them than it takes for all optima to be likely to have been met;
// nullopt if none is usable.
std::optional<RedesignSolve> FindOptimum(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                                         const synthesis::OptimizeOptions& options);

// Does one of these starts end in a usable solution?
bool HasSolution(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                 const synthesis::OptimizeOptions& options);

// Designs count as equal that differ by no more than this.
inline constexpr double kEqualRange_deg = 0.01, kEqualMisalignment_percent = 0.1;

// Of the designs that hold every limit and are equal to this optimum (or better), the one whose joint is nearest to the
// knee: a free program determines the placement only weakly. The optimum itself where it is not fitted.
RedesignPoint NearestToKnee(const RedesignProblem& problem, const RedesignSolve& optimum,
                            const synthesis::OptimizeOptions& options = {});

// Where the joint may sit with these links, their program adapted.
struct PlacementRange {
  double within_percent = 0;  // of misalignment: the limit, or that of the point + kEqualMisalignment_percent if larger
  problem::Bounds x_mm, y_mm;  // farthest to either side, the other coordinate adapted
};
// nullopt where a side was not found.
std::optional<PlacementRange> FindPlacementRange(const RedesignProblem& problem, const RedesignPoint& point,
                                                 const synthesis::OptimizeOptions& options = {});

struct ParetoPoint {
  double least_range_deg = 0;  // asked for
  RedesignPoint point;
  double range_deg = 0, misalignment_percent = 0, rms_mm = 0;
};

// The least misalignment for each of `count` least ranges, evenly spaced from that of the least misalignment to the
// largest range: ends first and last. Swept warm from both ends, and the better of both kept, so the misalignment never
// falls with the range. Without penalty and limit. Empty if an end could not be solved; points in between
// that could not be solved are left out. `step` is called after each of the SolvesOfSweeps(count) in between.
std::vector<ParetoPoint> ParetoFront(
    const RedesignProblem& problem, int count, const std::vector<linkage::Links>& links,
    const synthesis::OptimizeOptions& options = {}, const std::function<void()>& step = [] {});
inline int SolvesOfSweeps(int count) {
  return 2 * (count - 2);
}

// What the knee needs along a stroke program: a load profile is of a rise at the person's own pace and in their own
// poses, and an actuator has to bear that of the program's. The program is sought under the moments that it makes, so
// the two are found in turn until they stay.

// The measured profile at the pace of a program, at the percents of the motion: with a body (balance.h) in the poses of
// the prediction, else in the person's own. As measured where neither the body nor the profile's file says what pace
// adds, and where there is no program: its duration is 0.
problem::LoadProfile ProfileAlong(const HumanMotion& human, const problem::LoadProfile& measured,
                                  const std::optional<Prediction>& prediction, double duration_s);
// Of a point's program.
problem::LoadProfile ProfileOf(const RedesignProblem& problem, const problem::LoadProfile& measured,
                               const RedesignPoint& point);

// Of two profiles at the same percents: the largest difference of moments that both know, N m. Throws std::logic_error
// where they have not as many samples, a mistake of the caller's.
double LargestDifferenceNm(const problem::LoadProfile& a, const problem::LoadProfile& b);

// Moments that are off by more are those of another program.
inline constexpr double kOtherMoments_nm = 1;

struct MomentsOfProgram {
  problem::LoadProfile measured, profile;  // of the person's own rise, of the program
  double duration_s = 0;                   // of the program's rise
  int rounds = 0;                          // of solving under the moments of the round before
  double off_nm = 0;                       // of the profile from the moments of the program that is found under it
};

// The moments of the optimum that is found under them, from the best of `start` and these links on; where none is
// usable, those of the first one's program, after no round. The problem has the measured profile.
MomentsOfProgram FindMoments(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                             const synthesis::OptimizeOptions& options, const std::optional<RedesignPoint>& start = {});

}  // namespace lake::redesign
