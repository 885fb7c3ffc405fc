#include "lake/redesign/redesign.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/numbers.h"
#include "lake/core/progress.h"
#include "lake/redesign/redesign_program.h"

namespace lake::redesign {

namespace {

using Goal = RedesignProblem::Goal;
using synthesis::Until;

std::vector<double> ValuesOf(double (*value)(const Prediction&), const RedesignSolve& solve) {
  std::vector<double> of_people;
  for (const auto& prediction : solve.predictions) of_people.push_back(prediction ? value(*prediction) : kNaN);
  return of_people;
}

// Do the limits hold on the paths that the closed form predicts?
bool HoldsOnPath(const GroupProblem& group, const RedesignSolve& solve) {
  constexpr double kTolerance = 1e-5;
  const RedesignProblem& problem = group.shared;
  if (problem.min_range_deg && solve.Range_deg() < *problem.min_range_deg * (1 - kTolerance)) return false;
  return std::ranges::all_of(kQuantities, [&](const Quantity& quantity) {
    const std::optional<double>& limit = quantity.limit(problem);
    if (!limit || problem.goal == quantity.goal) return true;
    std::vector<double> values = ValuesOf(quantity.value, solve);
    if (&quantity == &kMisalignment) values = {group.Combine(values)};
    return std::ranges::all_of(values, [&](double value) { return quantity.Holds(value, *limit); });
  });
}

double ObjectiveOf(const GroupProblem& group, const RedesignSolve& solve) {
  const RedesignProblem& problem = group.shared;
  const auto combined = [&](double (*value)(const Prediction&)) { return group.Combine(ValuesOf(value, solve)); };
  for (const Quantity& quantity : kQuantities)
    if (problem.goal == quantity.goal) return quantity.Merit(combined(quantity.value));
  const Eigen::Vector2d& placement_mm = solve.Point().placement_mm;
  if (problem.goal == Goal::kNearest) return -placement_mm.norm();
  if (problem.goal == Goal::kFarthest) return problem.farthest.dot(placement_mm);
  double objective = solve.Range_deg();
  for (const Quantity& quantity : kQuantities)
    if (quantity.weight) objective -= problem.*quantity.weight * combined(quantity.weighed);
  return objective;
}

// Of each person the length of what their rows, with their marginal costs, do to the links. Rows that have links have
// variables of one person at most (redesign_program.h).
std::vector<double> PullsOf(const std::vector<RedesignVariables>& people, const synthesis::LocalSolve& solve) {
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  std::vector<Vector6d> pulls(people.size(), Vector6d::Zero());
  std::vector<double> gradient;
  for (const nlp::NlpTerm& term : solve.program.program.Terms()) {
    if (term.row == nlp::NlpTerm::kCost || solve.solution.row_marginal_costs.empty()) continue;
    const std::span<const int> variables = term.term->Variables();
    const int last = std::ranges::max(variables);
    const auto after = std::ranges::upper_bound(people, last, {}, [](const auto& of) { return of.knots.front(); });
    if (after == people.begin()) continue;  // the links' own
    gradient.resize(variables.size());
    term.term->Gradient(solve.solution.x.data(), gradient.data());
    const double cost = solve.solution.row_marginal_costs[static_cast<std::size_t>(term.row)];
    for (std::size_t k = 0; k < variables.size(); ++k) {
      const auto link = std::ranges::find(people.front().links, variables[k]);
      if (link == people.front().links.end()) continue;
      pulls[static_cast<std::size_t>(after - people.begin() - 1)][link - people.front().links.begin()] +=
          cost * gradient[k];
    }
  }
  std::vector<double> lengths;
  for (const Vector6d& pull : pulls) lengths.push_back(pull.norm());
  return lengths;
}

RedesignSolve SolveOneSide(const GroupProblem& problem, const std::vector<RedesignPoint>& start,
                           const std::vector<ConstantStart>& sides, const synthesis::OptimizeOptions& options) {
  RedesignSolve solve;
  RedesignBuilder builder(problem, start, sides);
  solve.local = synthesis::SolveByExchange(problem.shared.design, builder, options);
  solve.points = builder.Points();
  for (std::size_t i = 0; i < problem.people.size(); ++i) {
    solve.predictions.push_back(PredictPoint(problem.Of(i), solve.points[i]));
    const int row = builder.Variables()[i].misalignment_row;
    const std::vector<double>& costs = solve.local.solution.row_marginal_costs;
    solve.multipliers.push_back(row >= 0 && !costs.empty() ? std::abs(costs[static_cast<std::size_t>(row)]) : 0);
  }
  solve.pulls = PullsOf(builder.Variables(), solve.local);
  if (std::ranges::all_of(solve.predictions, [](const auto& of) { return of.has_value(); })) {
    solve.holds_on_path = HoldsOnPath(problem, solve);
    solve.is_usable = solve.local.IsUsable() && solve.holds_on_path;
    solve.objective = ObjectiveOf(problem, solve);
  }
  return solve;
}

// Without margins multipliers need not be unique, and a solve may stall just short of the tolerance, where all starts
// meet: it goes on from there to 1e-7 deg, finer than anything that is reported.
RedesignSolve SolveOrFinish(const GroupProblem& problem, const std::vector<RedesignPoint>& start,
                            const std::vector<ConstantStart>& sides, synthesis::OptimizeOptions options) {
  RedesignSolve solve = SolveOneSide(problem, start, sides, options);
  if (solve.local.solution.status != nlp::NlpStatus::kStalled || !solve.holds_on_path) return solve;
  constexpr double kFine = 1e-7;
  options.nlp.tolerance = std::max(options.nlp.tolerance, kFine);
  options.nlp.StartWarm();
  RedesignSolve finished = SolveOneSide(problem, solve.points, sides, options);
  finished.local.iterations += solve.local.iterations;
  return finished.IsUsable() ? std::move(finished) : std::move(solve);
}

ParetoPoint ParetoPointOf(const RedesignSolve& solve, double least_range_deg) {
  return {.least_range_deg = least_range_deg,
          .point = solve.Point(),
          .range_deg = solve.Range_deg(),
          .misalignment_percent = solve.Misalignment_percent(),
          .rms_mm = solve.Predicted()->Rms().mm};
}

using Front = std::vector<std::optional<ParetoPoint>>;

// Solves each problem between the ends from the solution before it, in this order, and keeps what is better than known.
void Sweep(const RedesignProblem& problem, const std::vector<std::size_t>& order, const std::vector<double>& ranges,
           const synthesis::OptimizeOptions& options, const std::function<void()>& step, Front& front) {
  RedesignPoint start = front[order.front()]->point;
  for (std::size_t k = 1; k + 1 < order.size(); ++k) {
    ThrowIfInterrupted();
    const std::size_t i = order[k];
    const RedesignProblem at = WithGoal(problem, Goal::kMisalignment, ranges[i]);
    RedesignSolve solve = SolveFrom(at, start, options, true);
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

double RedesignSolve::Misalignment_percent() const {
  return Predicted() ? kMisalignment.value(*Predicted()) : kNaN;
}

RedesignProblem WithGoal(RedesignProblem problem, Goal goal, std::optional<double> min_range_deg) {
  problem.goal = goal;
  problem.min_range_deg = min_range_deg;
  problem.max_misalignment_percent.reset();
  problem.penalty_deg_per_mm = problem.cuff_penalty_deg_per_n = 0;
  return problem;
}

RedesignSolve SolveFrom(const GroupProblem& problem, const std::vector<RedesignPoint>& start,
                        const synthesis::OptimizeOptions& options, bool warm) {
  synthesis::OptimizeOptions inner = options;
  constexpr int kMostIterations = 150;  // solves that succeed take 12 to 60; the others wander until stopped
  inner.nlp.max_iterations = std::min(inner.nlp.max_iterations, kMostIterations);
  // Of a group, starts that succeed restore feasibility for three iterations at most, if at all. The others take a
  // hundred in a row, with many pivots put off: one of fifty people took 106 s, where its neighbours took 2 s.
  constexpr int kMostRestoration = 10;
  if (problem.people.size() > 1) inner.nlp.max_restoration_iterations = kMostRestoration;
  if (warm) inner.nlp.StartWarm();
  std::vector<ConstantStart> sides(problem.people.size(), ConstantStart::kAtHumanAngle);
  RedesignSolve solve = SolveOrFinish(problem, start, sides, inner);
  if (problem.shared.program.kind == linkage::StrokeProgram::Kind::kFree || problem.shared.program.free_ends)
    return solve;
  constexpr double kTouching_mm = 1e-3;
  bool touches = false;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (solve.IsUsable() && solve.points[i].knots_mm.front() > problem.shared.design.d_min_mm + kTouching_mm) continue;
    sides[i] = ConstantStart::kAtShortestStroke;
    touches = true;
  }
  if (!touches) return solve;
  const std::vector<RedesignPoint>& from = solve.IsUsable() ? solve.points : start;
  RedesignSolve other = SolveOrFinish(problem, from, sides, inner);
  synthesis::MultiStart<RedesignSolve> both;
  both.Add(std::move(solve));
  both.Add(std::move(other));
  return both.TakeBestOrFirst();
}

RedesignSolve SolveFrom(const RedesignProblem& problem, const RedesignPoint& start,
                        const synthesis::OptimizeOptions& options, bool warm) {
  return SolveFrom(GroupProblem::OfOne(problem), std::vector{start}, options, warm);
}

namespace {

RedesignResult Search(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                      const synthesis::OptimizeOptions& options, Until until, Progress* progress = nullptr) {
  return synthesis::SolveFromEach(
      synthesis::StartsOf(problem.design, links, options.starts, options.seed),
      [&](const linkage::Links& start) { return SolveFrom(problem, StartPoint(problem, start), options); }, until,
      progress);
}

}  // namespace

RedesignResult Redesign(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                        const synthesis::OptimizeOptions& options) {
  problem.Check();
  options.Check();
  Progress progress("re-optimise", "starts", options.starts, options.quiet);
  return Search(problem, links, options, Until::kLastStart, &progress);
}

std::optional<RedesignSolve> FindOptimum(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                                         const synthesis::OptimizeOptions& options) {
  RedesignResult result = Search(problem, links, options, Until::kAllOptima);
  return result.IsSolved() ? std::optional(result.TakeBestOrFirst()) : std::nullopt;
}

bool HasSolution(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                 const synthesis::OptimizeOptions& options) {
  return Search(problem, links, options, Until::kUsable).IsSolved();
}

RedesignPoint NearestToKnee(const RedesignProblem& problem, const RedesignSolve& optimum,
                            const synthesis::OptimizeOptions& options) {
  if (!problem.fit_placement) return optimum.Point();
  RedesignProblem nearest = WithGoal(problem, Goal::kNearest, optimum.Range_deg() - kEqualRange_deg);
  nearest.max_misalignment_percent = optimum.Misalignment_percent() + kEqualMisalignment_percent;
  if (problem.max_misalignment_percent)
    nearest.max_misalignment_percent = std::min(*nearest.max_misalignment_percent, *problem.max_misalignment_percent);
  if (problem.cuff_penalty_deg_per_n > 0) nearest.max_cuff_force_n = optimum.Predicted()->cuff_force_n;
  const RedesignSolve solve = SolveFrom(nearest, optimum.Point(), options, true);
  const bool nearer = solve.IsUsable() && solve.Point().placement_mm.norm() < optimum.Point().placement_mm.norm();
  return nearer ? solve.Point() : optimum.Point();
}

std::optional<PlacementRange> FindPlacementRange(const RedesignProblem& problem, const RedesignPoint& point,
                                                 const synthesis::OptimizeOptions& options) {
  const auto prediction = PredictPoint(problem, point);
  if (!prediction) return std::nullopt;
  RedesignProblem farthest = WithLinks(WithGoal(problem, Goal::kFarthest), point.links);
  farthest.fit_placement = true;
  PlacementRange range;
  range.within_percent = std::max(problem.max_misalignment_percent.value_or(0),
                                  100 * prediction->Rms().relative + kEqualMisalignment_percent);
  farthest.max_misalignment_percent = range.within_percent;
  for (const int axis : {0, 1})
    for (const double side : {-1.0, 1.0}) {
      farthest.farthest = side * Eigen::Vector2d::Unit(axis);
      const RedesignSolve solve = SolveFrom(farthest, point, options, true);
      if (!solve.IsUsable()) return std::nullopt;
      problem::Bounds& bounds = axis == 0 ? range.x_mm : range.y_mm;
      (side < 0 ? bounds.lower : bounds.upper) = solve.Point().placement_mm[axis];
    }
  return range;
}

std::vector<ParetoPoint> ParetoFront(const RedesignProblem& problem, int count,
                                     const std::vector<linkage::Links>& links,
                                     const synthesis::OptimizeOptions& options, const std::function<void()>& step) {
  if (count < 2 || count > 1000) throw UsageError("--pareto {}: 2 to 1000 points", count);
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
  found.front() = ParetoPointOf(*least, ranges.front());
  found.back() = ParetoPointOf(*widest, ranges.back());
  Sweep(problem, up, ranges, options, step, found);
  Sweep(problem, {up.rbegin(), up.rend()}, ranges, options, step, found);
  std::vector<ParetoPoint> front;
  for (const auto& point : found)
    if (point) front.push_back(*point);
  MakeMonotone(front);
  return front;
}

// What the knee needs along a stroke program.

namespace {

// Until the feet alone bear the body the moment is not known, and the knee bends as the person's does.
problem::LoadProfile ProfileInPoses(const HumanMotion& human, const Prediction& prediction) {
  const BalanceCourse& course = *prediction.balance;
  const std::size_t first = human.size() - course.samples.size();
  std::vector<double> percent, knee_deg, knee_nm;
  for (auto* list : {&percent, &knee_deg, &knee_nm}) list->reserve(human.size());
  for (std::size_t i = 0; i < human.size(); ++i) {
    percent.push_back(PercentOf(i, human));
    knee_deg.push_back(DegreesFromRadians(i < first ? human[i].knee_rad : prediction.theta_rad[i]));
    knee_nm.push_back(i < first ? kNaN : course.samples[i - first].knee_nm);
  }
  return problem::MakeLoadProfile(percent, knee_deg, knee_nm, course.duration_s);
}

// Between two samples; of one alone where it is there. std::lerp takes the other where the first is NaN.
double Between(double a, double b, double weight) {
  constexpr double kRounding = 1e-9;
  if (weight < kRounding) return a;
  if (weight > 1 - kRounding) return b;
  return a + weight * (b - a);
}

// Linear between the profile's samples; not known where one of the two is not.
problem::LoadProfile AtPercentsOf(const HumanMotion& human, const problem::LoadProfile& profile) {
  const std::vector<problem::LoadSample>& samples = profile.samples;
  std::vector<double> percents, knee_deg, knee_nm;
  for (auto* list : {&percents, &knee_deg, &knee_nm}) list->reserve(human.size());
  for (std::size_t i = 0; i < human.size(); ++i) {
    const double percent = PercentOf(i, human);
    const auto after =
        std::ranges::lower_bound(samples.begin() + 1, samples.end() - 1, percent, {}, &problem::LoadSample::percent);
    const problem::LoadSample &b = *after, &a = *(after - 1);
    const double weight = (percent - a.percent) / (b.percent - a.percent);
    percents.push_back(percent);
    knee_deg.push_back(DegreesFromRadians(Between(a.knee_rad, b.knee_rad, weight)));
    knee_nm.push_back(Between(a.knee_nm, b.knee_nm, weight));
  }
  return problem::MakeLoadProfile(percents, knee_deg, knee_nm, profile.duration_s);
}

}  // namespace

problem::LoadProfile ProfileAlong(const HumanMotion& human, const problem::LoadProfile& measured,
                                  const std::optional<Prediction>& prediction, double duration_s) {
  if (prediction && prediction->balance) return ProfileInPoses(human, *prediction);
  const auto at_pace = duration_s > 0 ? problem::AtPace(measured, duration_s) : std::nullopt;
  return AtPercentsOf(human, at_pace.value_or(measured));
}

problem::LoadProfile ProfileOf(const RedesignProblem& problem, const problem::LoadProfile& measured,
                               const RedesignPoint& point) {
  return ProfileAlong(problem.human, measured, PredictPoint(problem, point), DurationOf(problem, point));
}

double LargestDifferenceNm(const problem::LoadProfile& a, const problem::LoadProfile& b) {
  if (a.samples.size() != b.samples.size())
    throw std::logic_error(
        fmt::format("moments at {} and at {} percents cannot be compared", a.samples.size(), b.samples.size()));
  double largest_nm = 0;
  for (std::size_t i = 0; i < a.samples.size(); ++i)
    if (const double difference_nm = std::abs(a.samples[i].knee_nm - b.samples[i].knee_nm);
        std::isfinite(difference_nm))
      largest_nm = std::max(largest_nm, difference_nm);
  return largest_nm;
}

MomentsOfProgram FindMoments(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                             const synthesis::OptimizeOptions& options, const std::optional<RedesignPoint>& start) {
  constexpr int kMostRounds = 8;
  constexpr double kSame_nm = 0.1;
  const problem::LoadProfile& measured = *problem.design.profile;
  std::vector<RedesignPoint> starts;
  if (start) starts.push_back(*start);
  for (const linkage::Links& one : links) starts.push_back(StartPoint(problem, one));
  MomentsOfProgram found{.measured = measured,
                         .profile = ProfileOf(problem, measured, starts.front()),
                         .duration_s = DurationOf(problem, starts.front())};
  RedesignProblem under = problem;
  do {
    under.design.profile = found.profile;
    RedesignResult search;
    for (const RedesignPoint& start : starts) search.Add(SolveFrom(under, start, options));
    if (!search.IsSolved()) break;
    const RedesignPoint point = search.Best().Point();
    ++found.rounds;
    found.profile = ProfileOf(problem, measured, point);
    found.off_nm = LargestDifferenceNm(found.profile, *under.design.profile);
    found.duration_s = DurationOf(problem, point);
    starts = {point};
  } while (found.off_nm > kSame_nm && found.rounds < kMostRounds);
  return found;
}

}  // namespace lake::redesign
