#include "lake/synthesis/synthesis_outcome.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/problem/evaluate.h"

namespace lake::synthesis {
namespace {

constexpr std::array kMargins_mm{0.0, 0.1, 0.2,  0.5,  1.0,  2.0,  3.0,  4.0, 5.0,
                                 6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0};

constexpr int kFewStarts = 4;

// Along a curve of problems that differ little the last optimum leads to the next: that is one start, the problem's own
// is another, and two more follow where these do not meet.
LocalSolve BestOfFew(const problem::SynthesisProblem& problem, const linkage::Links& last,
                     const OptimizeOptions& options) {
  return SolveFromEach(
             StartsOf(problem, {last, problem.start}, kFewStarts, options.seed),
             [&](const linkage::Links& start) { return SolveFrom(problem, start, options); }, Until::kConfirmed)
      .TakeBestOrFirst();
}

problem::YieldOptions YieldOptionsOf(const problem::SynthesisProblem& problem, const SynthesisOptions& options) {
  return {.tolerance_mm = *options.yield_tolerance_mm,
          .pin_clearance_mm = problem.parts.bore_clearance_mm,
          .seed = options.optimize.seed};
}

// Of designs that keep the limits within a part of what a build can be off, the one whose builds keep them most often;
// of equals that with the largest range, which comes first.
std::optional<TolerantDesign> FindTolerant(const SynthesisOutcome& outcome) {
  const double most_mm = YieldOptionsOf(outcome.problem, outcome.options).Most_mm();
  std::optional<TolerantDesign> best;
  linkage::Links last = outcome.BestLinks();
  for (const double part : {0.25, 0.5, 0.75, 1.0}) {
    problem::SynthesisProblem problem = outcome.problem;
    problem.robust_mm = part * most_mm;
    if (!(problem.robust_mm <= problem::SynthesisProblem::kMostTolerance_mm)) break;
    const LocalSolve solve = BestOfFew(problem, last, outcome.options.optimize);
    if (!solve.IsUsable()) break;
    last = solve.end;
    problem::Yield yield = YieldOf(last, outcome.problem, outcome.options);
    if (!best || yield.all.value > best->yield.all.value)
      best = {*problem.robust_mm, last, problem::Evaluate(last, outcome.problem), std::move(yield)};
  }
  return best;
}

MarginPoint SolveMargin(const problem::SynthesisProblem& asked, double margin_mm, const linkage::Links& last,
                        const SynthesisOptions& options) {
  problem::SynthesisProblem problem = asked;
  problem.grashof_margin_mm = problem.singularity_margin_mm = margin_mm;
  MarginPoint point{.margin_mm = margin_mm,
                    .solved = false,
                    .links = last,
                    .range_deg = std::numeric_limits<double>::quiet_NaN(),
                    .yield = {}};
  const LocalSolve best = BestOfFew(problem, last, options.optimize);
  point.solved = best.IsUsable();
  if (!point.solved) return point;
  point.links = best.end;
  point.range_deg = best.evaluation.range_deg;
  if (options.yield_tolerance_mm) point.yield = YieldOf(point.links, asked, options).all.value;
  return point;
}

std::vector<MarginPoint> SweepMargins(const SynthesisOutcome& outcome) {
  std::vector<MarginPoint> points;
  Progress progress("margins", "problems", kMargins_mm.size(), outcome.options.quiet);
  linkage::Links last = outcome.BestLinks();
  for (const double margin : kMargins_mm) {
    points.push_back(SolveMargin(outcome.problem, margin, last, outcome.options));
    last = points.back().links;
    progress.Advance();
  }
  return points;
}

// Without the requirements that certificate::NotInBound names.
problem::SynthesisProblem OnlyWhatIsInTheBound(problem::SynthesisProblem problem) {
  problem.clearances.thigh_mm.reset();
  problem.clearances.shank_mm.reset();
  if (problem.clearances.placement_reach_mm) problem.clearances.seat_mm.reset();
  if (problem.actuator && problem.HasLoadProfile() && !problem.rests_anywhere)
    problem.actuator->holding_force_n.reset();
  problem.duration_s.reset();
  problem.goal = problem::SynthesisProblem::Goal::kRange;
  problem.robust_mm.reset();
  return problem;
}

// From all starts, at a pace that few of them find. Gives the problem with the moments of that pace.
problem::SynthesisProblem OptimiseAtItsPace(problem::SynthesisProblem problem, const OptimizeOptions& options,
                                            SynthesisResult& result) {
  OptimizeOptions few = options;
  few.starts = std::min(kFewStarts, options.starts);
  few.quiet = true;
  const auto optimise = [&](const OptimizeOptions& search) {
    SolveAtItsPace(problem, [&](const problem::SynthesisProblem& at_pace) {
      result = Optimize(at_pace, search);
      return result.BestOrFirst().UsableEnd();
    });
  };
  if (problem.HasLoadProfile() && problem.profile->HasPace()) optimise(few);
  optimise(options);
  return problem;
}

// No start found a way, but the elastic program did, without moving a limit: one more start from there.
void StartFromElastic(SynthesisOutcome& outcome) {
  LocalSolve solve = SolveFrom(outcome.problem, outcome.infeasible->links, outcome.options.optimize);
  if (!solve.IsUsable()) return;
  outcome.result.Add(std::move(solve));
  outcome.result.basin.push_back(0);
  outcome.infeasible.reset();
}

}  // namespace

void SynthesisOptions::Check() const {
  optimize.Check();
  if (certify_gap_deg && !(std::isfinite(*certify_gap_deg) && *certify_gap_deg > 0))
    throw UsageError("--certify {}: a gap above 0 deg", *certify_gap_deg);
  if (certify_time_s && !certify_gap_deg) throw UsageError("--certify-time limits --certify: give --certify as well");
  if (yield_tolerance_mm && !(*yield_tolerance_mm > 0 && *yield_tolerance_mm < 10))
    throw UsageError("--yield {}: a tolerance between 0 and 10 mm", *yield_tolerance_mm);
  if (round_mm && !(std::isfinite(*round_mm) && *round_mm > 0))
    throw UsageError("--round {}: a step above 0 mm", *round_mm);
}

void Describe(OptimizeOptions& o, OptionList& options) {
  options.Add("starts", o.starts, "Number of starts; all but the first are random within the bounds").AtLeast(1);
  options.Add("seed-number", o.seed, "Random seed");
}

void Describe(SynthesisOptions& o, OptionList& options) {
  Describe(o.optimize, options);
  options.Add("certify", o.certify_gap_deg, "Prove an upper bound on the range to within this gap")
      .Unit("degrees")
      .Positive()
      .Implied(FormatNumber(certificate::CertificateOptions{}.gap_deg));
  options
      .Add("certify-time", o.certify_time_s,
           fmt::format(
               "End that proof after this time with the gap so far, which then depends on the machine, and those "
               "for all margins after as long again together; with or without it each ends after {} steps",
               certificate::CertificateOptions{}.max_boxes))
      .Unit("s")
      .Positive();
  options
      .Add(
          "yield", o.yield_tolerance_mm,
          "The share of builds that keep each limit, and all of them, where every link and the shortest stroke are off "
          "by up to this, and the design whose builds keep them most often; not a requirement")
      .Unit("mm")
      .Positive();
  options.Add("round", o.round_mm, "Also find the best design whose links are multiples of this").Unit("mm").Positive();
}

problem::Yield YieldOf(const linkage::Links& links, const problem::SynthesisProblem& problem,
                       const SynthesisOptions& options) {
  return problem::EstimateYield(links, problem, YieldOptionsOf(problem, options));
}

certificate::Certificate CertifyOptimum(const problem::SynthesisProblem& problem, const linkage::Links& optimum,
                                        double range_deg, const certificate::CertificateOptions& certificate_options,
                                        const OptimizeOptions& options) {
  const auto names = certificate::NotInBound(problem);
  const problem::SynthesisProblem simpler = OnlyWhatIsInTheBound(problem);
  if (names == certificate::NotInBound(simpler))
    return certificate::CertifyRange(problem, range_deg, certificate_options);
  const LocalSolve best = BestOfFew(simpler, optimum, options);
  // The bound is of designs that can stand, if the problem has a requirement for which they must.
  const bool can_stand = best.IsUsable() && problem::UsedPoses(best.end, problem).Range();
  const double aim_deg = can_stand ? std::max(range_deg, best.evaluation.range_deg) : range_deg;
  certificate::Certificate certificate = certificate::CertifyRange(problem, aim_deg, certificate_options);
  certificate.range_deg = range_deg;
  certificate.gap_deg = certificate.upper_bound_deg - range_deg;
  certificate.reached = certificate.gap_deg <= certificate_options.gap_deg;
  return certificate;
}

SynthesisOutcome RunSynthesis(const problem::SynthesisProblem& problem, const SynthesisOptions& options) {
  problem.Check();
  options.Check();
  SynthesisOutcome outcome;
  outcome.options = options;
  outcome.problem = OptimiseAtItsPace(problem, options.optimize, outcome.result);
  outcome.start = problem::Evaluate(problem.start, outcome.problem);
  if (options.yield_tolerance_mm) outcome.start_yield = YieldOf(problem.start, outcome.problem, options);
  if (!outcome.IsSolved()) outcome.infeasible = AnalyseInfeasibility(outcome.problem, options.optimize);
  if (outcome.infeasible && outcome.infeasible->relaxations.empty()) StartFromElastic(outcome);
  if (!outcome.IsSolved()) return outcome;
  const LocalSolve& best = outcome.result.Best();
  outcome.active = FindActiveSet(best);
  if (options.certify_gap_deg)
    outcome.certificate =
        CertifyOptimum(outcome.problem, best.end, best.evaluation.range_deg,
                       {.gap_deg = *options.certify_gap_deg, .time_s = options.certify_time_s, .quiet = options.quiet},
                       options.optimize);
  {
    constexpr double kSpan_mm = 5;
    constexpr int kSteps = 100;
    Progress progress("sensitivity", "points", problem::PointsOfSensitivity(kSteps), options.quiet);
    outcome.sensitivity =
        problem::Sensitivity(best.end, outcome.problem, kSpan_mm, kSteps, [&] { progress.Advance(); });
  }
  // A tolerance takes the place of margins.
  if (problem.goal == problem::SynthesisProblem::Goal::kRange && !problem.robust_mm)
    outcome.margins = SweepMargins(outcome);
  if (options.yield_tolerance_mm) {
    outcome.yield = YieldOf(best.end, outcome.problem, options);
    outcome.tolerant = FindTolerant(outcome);
  }
  if (options.round_mm) outcome.rounded = problem::RoundLinks(best.end, outcome.problem, *options.round_mm);
  return outcome;
}

}  // namespace lake::synthesis
