#include "lake/synthesis/actuator_front.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
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

// From few starts and the links of the last share; from all starts where these lead to nothing.
LocalSolve SolveShare(const SynthesisProblem& problem, const std::optional<linkage::Links>& last,
                      const OptimizeOptions& options) {
  const auto solve_from = [&](const std::vector<linkage::Links>& starts) {
    return SolveFromEach(starts, [&](const linkage::Links& start) { return SolveFrom(problem, start, options); })
        .TakeBestOrFirst();
  };
  if (last) {
    constexpr int kFewStarts = 4;
    std::vector<linkage::Links> few =
        StartsOf(problem, {problem.start}, std::min(options.starts, kFewStarts), options.seed);
    few.push_back(*last);
    LocalSolve best = solve_from(few);
    if (best.IsUsable()) return best;
  }
  return solve_from(StartsOf(problem, {problem.start}, options.starts, options.seed));
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
  ActuatorCurve curve{.problem = std::move(problem), .points = {}, .failing = contradiction, .limits = {contradiction}};
  for (const double share : shares) curve.points.emplace_back().assist = share;
  return curve;
}

ActuatorCurve FindCurve(SynthesisProblem problem, const std::vector<double>& shares, const OptimizeOptions& options) {
  ActuatorCurve curve{.problem = problem, .points = {}, .failing = "", .limits = {}};
  std::optional<linkage::Links> last;
  for (const double share : shares) {
    ThrowIfInterrupted();
    problem.assist = share;
    FrontPoint& point = curve.points.emplace_back();
    point.assist = share;
    if (!curve.failing.empty()) continue;
    problem.Check();
    LocalSolve best;
    SolveAtItsPace(problem, [&](const SynthesisProblem& at_pace) {
      best = SolveShare(at_pace, last, options);
      return best.UsableEnd();
    });
    point.solved = best.IsUsable();
    if (!point.solved) {
      Explain(problem, options, curve);
      continue;
    }
    point.links = best.end;
    point.range_deg = best.evaluation.range_deg;
    point.assistance = problem::FindAssistance(best.end, problem);
    last = best.end;
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
  if (!problem.profile) throw Fail("actuators are compared over the knee moment: a load profile is missing");
  options.Check();
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
