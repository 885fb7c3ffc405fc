#include "lake/redesign/reoptimize.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/progress.h"
#include "lake/redesign/reoptimize_program.h"

namespace lake::redesign {
namespace {

using Goal = ReoptimizeProblem::Goal;

// Do the limits hold on the path that the closed form predicts?
bool HoldsOnPath(const ReoptimizeProblem& problem, const ReoptimizeSolve& solve) {
  constexpr double kTolerance = 1e-5;  // relative
  if (!solve.prediction) return false;
  if (problem.max_misalignment_percent &&
      solve.Misalignment_percent() > *problem.max_misalignment_percent * (1 + kTolerance))
    return false;
  if (problem.min_range_deg && solve.Range_deg() < *problem.min_range_deg * (1 - kTolerance)) return false;
  const double needed_s = NeededDuration(solve.point.knots_mm, problem.program.max_speed_mm_s);
  return !problem.program.duration_s || needed_s <= *problem.program.duration_s * (1 + kTolerance);
}

ReoptimizeSolve SolveOneSide(const ReoptimizeProblem& problem, const ReoptimizePoint& start,
                             ConstantStart constant_start, const synthesis::OptimizeOptions& options) {
  ReoptimizeSolve solve;
  ReoptimizeBuilder builder(problem, start, constant_start);
  solve.local = synthesis::SolveByExchange(problem.design, builder, options);
  solve.point = builder.Point();
  solve.prediction = PredictPoint(problem, solve.point);
  solve.holds_on_path = HoldsOnPath(problem, solve);
  if (solve.prediction) solve.objective = ObjectiveOf(problem, solve.point, solve.Range_deg(), *solve.prediction);
  return solve;
}

bool IsBetter(const ReoptimizeSolve& a, const ReoptimizeSolve& b) {
  constexpr double kBetter = 1e-5;  // of equals the first is kept
  return a.IsUsable() && (!b.IsUsable() || a.objective > b.objective + kBetter);
}

ReoptimizeProblem WithGoal(ReoptimizeProblem problem, Goal goal, std::optional<double> min_range_deg = {}) {
  problem.goal = goal;
  problem.min_range_deg = min_range_deg;
  problem.max_misalignment_percent.reset();
  problem.penalty_deg_per_mm = 0;
  return problem;
}

// Of local searches from random starts whose n ends are w different optima, w (n - 1) / (n - w - 2) optima are to be
// expected in all; the search is over when that is not half a one more than was found (Boender & Rinnooy Kan, Math.
// Program. 37, 1987).
bool HasFoundAll(int ends, int optima) {
  return ends > optima + 2 && optima * (ends - 1) < (optima + 0.5) * (ends - optima - 2);
}

// The different optima among usable ends.
class Optima {
 public:
  void Add(const ReoptimizeSolve& solve) {
    constexpr double kSame = 1e-3;  // deg or percent: ends of one optimum agree to 1e-6
    if (!solve.IsUsable()) return;
    ++ends_;
    if (std::ranges::none_of(objectives_, [&](double other) { return std::abs(other - solve.objective) < kSame; }))
      objectives_.push_back(solve.objective);
  }
  bool AreAll() const { return HasFoundAll(ends_, static_cast<int>(objectives_.size())); }

 private:
  int ends_ = 0;
  std::vector<double> objectives_;
};

// Where the solves of a problem start: `links` in turn, then random ones within the bounds.
std::vector<linkage::Links> StartsOf(const ReoptimizeProblem& problem, const std::vector<linkage::Links>& links,
                                     const synthesis::OptimizeOptions& options) {
  std::vector<linkage::Links> starts = links;
  const int random = std::max(0, options.starts - static_cast<int>(links.size()));
  for (const linkage::Links& start : synthesis::RandomStarts(problem.design, random, options.seed))
    starts.push_back(start);
  starts.resize(std::min(starts.size(), static_cast<std::size_t>(options.starts)));
  return starts;
}

ParetoPoint ParetoPointOf(const ReoptimizeSolve& solve, double least_range_deg) {
  return {least_range_deg, solve.point, solve.Range_deg(), solve.Misalignment_percent(), solve.prediction->rms_mm};
}

using Front = std::vector<std::optional<ParetoPoint>>;

// Solves each problem between the ends from the solution before it, in this order, and keeps what is better than known.
void Sweep(const ReoptimizeProblem& problem, const std::vector<std::size_t>& order, const std::vector<double>& ranges,
           const synthesis::OptimizeOptions& options, const std::function<void()>& step, Front& front) {
  ReoptimizePoint start = front[order.front()]->point;
  for (std::size_t k = 1; k + 1 < order.size(); ++k) {
    ThrowIfInterrupted();
    const std::size_t i = order[k];
    const ReoptimizeProblem at = WithGoal(problem, Goal::kMisalignment, ranges[i]);
    ReoptimizeSolve solve = SolveFrom(at, start, options, true);
    if (!solve.IsUsable()) solve = SolveFrom(at, start, options);
    step();
    if (!solve.IsUsable()) continue;
    if (!front[i] || solve.Misalignment_percent() < front[i]->misalignment_percent)
      front[i] = ParetoPointOf(solve, ranges[i]);
    start = front[i]->point;
  }
}

// A design for a larger range serves the smaller one too.
void MakeMonotone(std::vector<ParetoPoint>& front) {
  for (std::size_t i = front.size() - 1; i-- > 0;) {
    if (front[i + 1].misalignment_percent >= front[i].misalignment_percent) continue;
    const double least_range_deg = front[i].least_range_deg;
    front[i] = front[i + 1];
    front[i].least_range_deg = least_range_deg;
  }
}

}  // namespace

double ReoptimizeSolve::Misalignment_percent() const {
  return prediction ? 100 * prediction->relative_rms : std::numeric_limits<double>::quiet_NaN();
}

double ObjectiveOf(const ReoptimizeProblem& problem, const ReoptimizePoint& point, double range_deg,
                   const Prediction& prediction) {
  switch (problem.goal) {
    case Goal::kMisalignment:
      return -100 * prediction.relative_rms;
    case Goal::kDuration:
      return -NeededDuration(point.knots_mm, problem.program.max_speed_mm_s);
    case Goal::kNearest:
      return -point.placement_mm.norm();
    case Goal::kFarthest:
      return problem.farthest.dot(point.placement_mm);
    default:
      return range_deg - problem.penalty_deg_per_mm * prediction.rms_mm;
  }
}

ReoptimizeSolve SolveFrom(const ReoptimizeProblem& problem, const ReoptimizePoint& start,
                          const synthesis::OptimizeOptions& options, bool warm) {
  synthesis::OptimizeOptions inner = options;
  constexpr int kMostIterations = 150;  // solves that succeed take 12 to 60; the others wander until stopped
  inner.nlp.max_iterations = std::min(inner.nlp.max_iterations, kMostIterations);
  if (warm) inner.nlp.start_push = 1e-6, inner.nlp.start_barrier = 1e-4;
  ReoptimizeSolve solve = SolveOneSide(problem, start, ConstantStart::kAtHumanAngle, inner);
  if (problem.program.kind == linkage::StrokeProgram::Kind::kFree) return solve;
  constexpr double kTouching_mm = 1e-3;
  if (solve.IsUsable() && solve.point.knots_mm.front() > problem.design.d_min_mm + kTouching_mm) return solve;
  const ReoptimizePoint& from = solve.IsUsable() ? solve.point : start;
  ReoptimizeSolve other = SolveOneSide(problem, from, ConstantStart::kAtShortestStroke, inner);
  return IsBetter(other, solve) ? std::move(other) : std::move(solve);
}

ReoptimizeResult Reoptimize(const ReoptimizeProblem& problem, const std::vector<linkage::Links>& links,
                            const synthesis::OptimizeOptions& options) {
  problem.Check();
  options.Check();
  const std::vector<linkage::Links> starts = StartsOf(problem, links, options);
  ReoptimizeResult result;
  Progress progress("re-optimise", "starts", static_cast<std::int64_t>(starts.size()), options.quiet);
  for (const linkage::Links& start : starts) {
    ThrowIfInterrupted();
    result.starts.push_back(SolveFrom(problem, StartPoint(problem, start), options));
    const ReoptimizeSolve& solve = result.starts.back();
    if (solve.IsUsable() && (!result.IsSolved() || IsBetter(solve, result.Best())))
      result.best = static_cast<int>(result.starts.size()) - 1;
    progress.Advance();
  }
  return result;
}

std::optional<ReoptimizeSolve> FindOptimum(const ReoptimizeProblem& problem, const std::vector<linkage::Links>& links,
                                           const synthesis::OptimizeOptions& options) {
  std::optional<ReoptimizeSolve> best;
  Optima optima;
  for (const linkage::Links& start : StartsOf(problem, links, options)) {
    ThrowIfInterrupted();
    ReoptimizeSolve solve = SolveFrom(problem, StartPoint(problem, start), options);
    optima.Add(solve);
    if (solve.IsUsable() && (!best || IsBetter(solve, *best))) best = std::move(solve);
    if (optima.AreAll()) break;
  }
  return best;
}

bool HasSolution(const ReoptimizeProblem& problem, const std::vector<linkage::Links>& links,
                 const synthesis::OptimizeOptions& options) {
  return std::ranges::any_of(StartsOf(problem, links, options), [&](const linkage::Links& start) {
    ThrowIfInterrupted();
    return SolveFrom(problem, StartPoint(problem, start), options).IsUsable();
  });
}

ReoptimizePoint NearestToKnee(const ReoptimizeProblem& problem, const ReoptimizeSolve& optimum,
                              const synthesis::OptimizeOptions& options) {
  if (!problem.fit_placement) return optimum.point;
  ReoptimizeProblem nearest = WithGoal(problem, Goal::kNearest, optimum.Range_deg() - kEqualRange_deg);
  nearest.max_misalignment_percent = optimum.Misalignment_percent() + kEqualMisalignment_percent;
  if (problem.max_misalignment_percent)
    nearest.max_misalignment_percent = std::min(*nearest.max_misalignment_percent, *problem.max_misalignment_percent);
  const ReoptimizeSolve solve = SolveFrom(nearest, optimum.point, options, true);
  const bool nearer = solve.IsUsable() && solve.point.placement_mm.norm() < optimum.point.placement_mm.norm();
  return nearer ? solve.point : optimum.point;
}

std::optional<PlacementRange> FindPlacementRange(const ReoptimizeProblem& problem, const ReoptimizePoint& point,
                                                 const synthesis::OptimizeOptions& options) {
  constexpr double kSameLinks_mm = 0.01;  // a machinist's; wide enough for an interior point to move in
  const auto prediction = PredictPoint(problem, point);
  if (!prediction) return std::nullopt;
  ReoptimizeProblem farthest = WithGoal(problem, Goal::kFarthest);
  farthest.fit_placement = true;
  for (std::size_t i = 0; i < 6; ++i) {
    problem::Bounds& bounds = farthest.design.bounds[i];
    const double length = point.links.Values()[i];
    bounds = {std::max(bounds.lower, length - kSameLinks_mm), std::min(bounds.upper, length + kSameLinks_mm)};
  }
  PlacementRange range;
  range.within_percent = std::max(problem.max_misalignment_percent.value_or(0),
                                  100 * prediction->relative_rms + kEqualMisalignment_percent);
  farthest.max_misalignment_percent = range.within_percent;
  for (const int axis : {0, 1})
    for (const double side : {-1.0, 1.0}) {
      farthest.farthest = side * Eigen::Vector2d::Unit(axis);
      const ReoptimizeSolve solve = SolveFrom(farthest, point, options, true);
      if (!solve.IsUsable()) return std::nullopt;
      problem::Bounds& bounds = axis == 0 ? range.x_mm : range.y_mm;
      (side < 0 ? bounds.lower : bounds.upper) = solve.point.placement_mm[axis];
    }
  return range;
}

std::vector<ParetoPoint> ParetoFront(const ReoptimizeProblem& problem, int count,
                                     const std::vector<linkage::Links>& links,
                                     const synthesis::OptimizeOptions& options, const std::function<void()>& step) {
  if (count < 2 || count > 1000) throw UsageError(fmt::format("--pareto {}: 2 to 1000 points", count));
  const auto least = FindOptimum(WithGoal(problem, Goal::kMisalignment), links, options);
  const auto widest = FindOptimum(WithGoal(problem, Goal::kRange), links, options);
  if (!least || !widest) return {};
  std::vector<double> ranges;
  std::vector<std::size_t> up;
  for (int i = 0; i < count; ++i) {
    ranges.push_back(std::lerp(least->Range_deg(), widest->Range_deg(), i / (count - 1.0)));
    up.push_back(static_cast<std::size_t>(i));
  }
  Front found(count);
  found.front() = ParetoPointOf(*least, ranges.front()), found.back() = ParetoPointOf(*widest, ranges.back());
  Sweep(problem, up, ranges, options, step, found);
  Sweep(problem, {up.rbegin(), up.rend()}, ranges, options, step, found);
  std::vector<ParetoPoint> front;
  for (const auto& point : found)
    if (point) front.push_back(*point);
  MakeMonotone(front);
  return front;
}

}  // namespace lake::redesign
