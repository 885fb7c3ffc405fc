#include "lake/synthesis/actuator_front.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/progress.h"

namespace lake::synthesis {
namespace {

using problem::SynthesisProblem;

SynthesisProblem ProblemOf(SynthesisProblem problem, const problem::LinearActuator& actuator) {
  problem.actuator = actuator;
  problem.duration_s.reset();
  problem.goal = actuator.HasSpeed() ? SynthesisProblem::Goal::kDuration : SynthesisProblem::Goal::kRange;
  return problem::WithActuator(std::move(problem));
}

// From the links of the last share too; all starts where it is not that these lead on.
std::optional<LocalSolve> SolveShare(const SynthesisProblem& problem, const std::optional<linkage::Links>& last,
                                     const OptimizeOptions& options) {
  OptimizeOptions search = options;
  constexpr int kFewStarts = 4;
  if (last) search.starts = std::min(options.starts, kFewStarts);
  SynthesisResult result = Optimize(problem, search);
  std::optional<LocalSolve> best;
  if (result.best >= 0) best = std::move(result.starts[result.best]);
  if (last) {
    LocalSolve solve = SolveFrom(problem, *last, options);
    if (solve.IsUsable() &&
        (!best || problem::GoalOf(problem, solve.evaluation) > problem::GoalOf(problem, best->evaluation)))
      best = std::move(solve);
  }
  return best;
}

// What a share fails for.
void Explain(const SynthesisProblem& problem, const OptimizeOptions& options, ActuatorCurve& curve) {
  const InfeasibilityReport report = AnalyseInfeasibility(problem, options);
  curve.failing = report.sentence;
  for (const Relaxation& relaxation : report.relaxations) curve.limits.push_back(relaxation.text);
}

// Without its lengths and its force, of which one contradicts the problem.
ActuatorCurve ContradictingCurve(SynthesisProblem problem, const problem::LinearActuator& actuator,
                                 const std::vector<double>& shares, const std::string& contradiction) {
  problem.actuator = actuator;
  ActuatorCurve curve{std::move(problem), {}, contradiction, {contradiction}};
  for (const double share : shares) curve.points.emplace_back().assist = share;
  return curve;
}

ActuatorCurve FindCurve(SynthesisProblem problem, const std::vector<double>& shares, const OptimizeOptions& options) {
  ActuatorCurve curve{problem, {}, "", {}};
  std::optional<linkage::Links> last;
  for (const double share : shares) {
    ThrowIfInterrupted();
    problem.assist = share;
    FrontPoint point;
    point.assist = share;
    const std::optional<LocalSolve> best = curve.failing.empty() ? SolveShare(problem, last, options) : std::nullopt;
    if (best) {
      point.solved = true, point.links = best->end, point.range_deg = best->evaluation.range_deg;
      point.assistance = problem::FindAssistance(best->end, problem);
      last = best->end;
    } else if (curve.failing.empty()) {
      Explain(problem, options, curve);
    }
    curve.points.push_back(std::move(point));
  }
  return curve;
}

void MarkFront(std::vector<ActuatorCurve>& curves) {
  const auto each = [&](const auto& work) {
    for (ActuatorCurve& curve : curves)
      for (FrontPoint& point : curve.points)
        if (point.solved && std::isfinite(point.assistance.shortest_s)) work(point);
  };
  each([&](FrontPoint& point) {
    point.is_on_front = true;
    each([&](const FrontPoint& other) {
      const double time = point.assistance.shortest_s, others = other.assistance.shortest_s;
      if (other.assist >= point.assist && others <= time && (other.assist > point.assist || others < time))
        point.is_on_front = false;
    });
  });
}

}  // namespace

const FrontPoint* ActuatorCurve::Last() const {
  const FrontPoint* last = nullptr;
  for (const FrontPoint& point : points)
    if (point.solved) last = &point;
  return last;
}

std::vector<ActuatorCurve> FindActuatorFront(const SynthesisProblem& problem,
                                             const std::vector<problem::LinearActuator>& actuators,
                                             const std::vector<double>& shares, const OptimizeOptions& options) {
  if (!problem.profile) throw Fail("actuators are compared over what the knee needs: a load profile is missing");
  for (const double share : shares)
    if (!(share > 0 && share <= 1)) throw Fail("a share of {} must lie above 0, and not beyond 1", share);
  OptimizeOptions quiet = options;
  quiet.quiet = true;
  std::vector<ActuatorCurve> curves;
  Progress progress("actuators", "actuators", static_cast<std::int64_t>(actuators.size()), options.quiet);
  problem.Check();
  for (const problem::LinearActuator& actuator : actuators) {
    std::optional<SynthesisProblem> own;
    std::string contradiction;
    try {
      own = ProblemOf(problem, actuator);
    } catch (const Error& error) {
      contradiction = error.what();
    }
    curves.push_back(own ? FindCurve(*own, shares, quiet)
                         : ContradictingCurve(problem, actuator, shares, contradiction));
    progress.Advance();
  }
  MarkFront(curves);
  return curves;
}

}  // namespace lake::synthesis
