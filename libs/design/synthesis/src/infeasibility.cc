#include "lake/synthesis/infeasibility.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lake/core/error.h"
#include "lake/core/progress.h"
#include "lake/core/uncertain_text.h"

namespace lake::synthesis {
namespace {

constexpr double kNoSlack =
    1e-5;  // mm, deg or 1 % of a force: what an interior point leaves on a slack that is not needed

struct ElasticSolve {
  nlp::NlpSolution solution;
  SynthesisProgram program;
  bool holds = false;  // solved, and the moved limits hold over the used range by the closed form
  bool IsBetterThan(const ElasticSolve& other) const {
    return holds != other.holds ? holds : solution.cost < other.solution.cost;
  }
};

// The problem where a solution has placement and shortest stroke.
problem::SynthesisProblem Moved(problem::SynthesisProblem problem, const ElasticSolve& solve) {
  problem = Placed(std::move(problem), solve.program, solve.solution.x);
  problem.d_min_mm = solve.solution.x[solve.program.shortest_stroke];
  return problem;
}

// The requirements with their limits moved by the slacks.
std::vector<problem::Requirement> Relaxed(const ElasticSolve& solve) {
  std::vector<problem::Requirement> relaxed;
  for (const RequirementRow& entry : solve.program.requirements) {
    relaxed.push_back(entry.requirement);
    relaxed.back().limit += (entry.requirement.is_lower_limit ? -1 : 1) * entry.SlackAt(solve.solution.x);
  }
  return relaxed;
}

bool FamiliesHold(const problem::SynthesisProblem& problem, const std::vector<problem::Requirement>& requirements,
                  const linkage::Links& links) {
  constexpr double kTolerance = 1e-4;  // of the limit; the moved limits themselves are known no better
  problem::UsedPoses poses(links, problem);
  for (const problem::Requirement& requirement : requirements) {
    if (!requirement.IsFamily()) continue;
    const auto worst = poses.WorstPoints(requirement);
    if (worst.empty() || requirement.Slack(worst.front().value) < -kTolerance * std::max(1.0, requirement.limit))
      return false;
  }
  return true;
}

ElasticSolve SolveElastic(const problem::SynthesisProblem& problem, const linkage::Links& start, Elasticity elasticity,
                          const OptimizeOptions& options) {
  ElasticSolve solve;
  Collocation poses = FirstPoses(problem);
  linkage::Links from = start;
  for (int exchange = 0; exchange < options.max_exchanges; ++exchange) {
    solve.program = BuildProgram(problem, from, poses, elasticity);
    solve.solution = nlp::SolveNlp(solve.program.program, options.nlp);
    from = LinksAt(solve.program.links, solve.solution.x);
    if (!solve.solution.IsUsable() ||
        !AddViolatedPoses(Moved(problem, solve), Relaxed(solve), from, options.family_tolerance, poses))
      break;
  }
  const problem::SynthesisProblem moved = Moved(problem, solve);
  const std::vector<problem::Requirement> relaxed = Relaxed(solve);
  solve.holds = solve.solution.IsUsable() && FamiliesHold(moved, relaxed, from) &&
                std::ranges::all_of(poses.builds, [&](const problem::BuildError& build) {
                  return FamiliesHold(problem::ProblemOf(build, moved), relaxed, problem::LinksOf(build, from));
                });
  return solve;
}

ElasticSolve BestElastic(const problem::SynthesisProblem& problem, Elasticity elasticity,
                         const OptimizeOptions& options) {
  constexpr int kStarts = 10;
  ElasticSolve best;
  best.solution.cost = std::numeric_limits<double>::infinity();
  Progress progress("which limits give way", "starts", kStarts, options.quiet);
  for (const linkage::Links& start : StartsOf(problem, {problem.start}, kStarts, options.seed)) {
    ElasticSolve solve = SolveElastic(problem, start, elasticity, options);
    if (best.solution.x.empty() || solve.IsBetterThan(best)) best = std::move(solve);
    progress.Advance();
  }
  return best;
}

void CollectRelaxations(const ElasticSolve& solve, InfeasibilityReport& report) {
  const std::vector<double>& x = solve.solution.x;
  for (const RequirementRow& limit : solve.program.requirements) {
    const problem::Requirement& requirement = limit.requirement;
    const double slack = limit.SlackAt(x);
    if (slack > kNoSlack * SlackUnit(requirement))
      report.relaxations.push_back({requirement.Text(), requirement.limit,
                                    requirement.limit + (requirement.is_lower_limit ? -slack : slack),
                                    requirement.unit});
  }
  for (const ElasticBound& bound : solve.program.elastic_bounds)
    if (x[bound.slack] > kNoSlack)
      report.relaxations.push_back(
          {bound.text, bound.limit, bound.limit + (bound.is_lower_limit ? -1 : 1) * x[bound.slack], "mm"});
}

void CollectFighting(const ElasticSolve& solve, InfeasibilityReport& report) {
  constexpr double kNoCost = 1e-4;  // of a cost that counts in mm and deg
  const nlp::NlpSolution& solution = solve.solution;
  for (const RequirementRow& limit : solve.program.requirements)
    if (std::abs(solution.row_marginal_costs[limit.row]) * SlackUnit(limit.requirement) > kNoCost)
      report.fighting.push_back(limit.requirement.Text());
  for (const ElasticBound& bound : solve.program.elastic_bounds)
    if (std::abs(solution.row_marginal_costs[bound.row]) > kNoCost) report.fighting.push_back(bound.text);
  if (!solve.program.elastic_bounds.empty()) return;
  for (const int link : solve.program.links) {
    const nlp::NlpVariable& variable = solve.program.program.Variables()[link];
    const double cost = solution.variable_marginal_costs[link];
    if (std::abs(cost) > kNoCost)
      report.fighting.push_back(fmt::format("{} {} {} mm", variable.name, cost > 0 ? "≥" : "≤",
                                            SignificantText(cost > 0 ? variable.lower : variable.upper, 6)));
  }
}

std::string Sentence(const InfeasibilityReport& report) {
  if (!report.solved) return "no design was found that satisfies the problem, and none that nearly does";
  if (report.relaxations.empty()) return "the problem can be satisfied, but the solver did not reach an optimum";
  std::string text =
      fmt::format("no design satisfies all limits: {} cannot hold{}; the smallest change found that suffices:",
                  fmt::join(report.fighting, ", "), report.fighting.size() > 1 ? " together" : "");
  for (std::size_t i = 0; i < report.relaxations.size(); ++i) {
    const Relaxation& relaxation = report.relaxations[i];
    const double by = RoundedUp(std::abs(relaxation.relaxed - relaxation.limit)),
                 sign = relaxation.relaxed < relaxation.limit ? -1 : 1;
    const std::string unit = relaxation.unit == "1" ? "" : " " + relaxation.unit;
    text += i ? ", " : " ";
    // An order of two lengths, l2 <= l4, has no number of its own.
    if (relaxation.limit == 0 && sign < 0)
      text += fmt::format("allow {} + {}{}", relaxation.text, SignificantText(by, 4), unit);
    else
      text += fmt::format("relax {} by {}{} to {}", relaxation.text, SignificantText(by, 4), unit,
                          SignificantText(relaxation.limit + sign * by, 8));
  }
  return text;
}

}  // namespace

double RoundedUp(double value) {
  constexpr double kRoom = 1.001;
  const double digit = std::pow(10, std::floor(std::log10(value)) - 2);
  return std::ceil(kRoom * value / digit) * digit;
}

InfeasibilityReport AnalyseInfeasibility(const problem::SynthesisProblem& problem, const OptimizeOptions& options) {
  problem.Check();
  options.Check();
  ElasticSolve solve = BestElastic(problem, Elasticity::kRequirements, options);
  if (!solve.holds) solve = BestElastic(problem, Elasticity::kEverything, options);
  InfeasibilityReport report;
  report.solved = solve.holds;
  report.links = LinksAt(solve.program.links, solve.solution.x);
  if (report.solved) {
    CollectRelaxations(solve, report);
    CollectFighting(solve, report);
  }
  report.sentence = Sentence(report);
  return report;
}

}  // namespace lake::synthesis
