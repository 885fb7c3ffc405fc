#include "lake/problem/robustness.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <numeric>
#include <random>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/core/threads.h"

namespace lake::problem {
namespace {

constexpr int kLinks = 6;

double RangeOf(const linkage::Links& links, double d_min_mm) {
  const std::optional<linkage::Pose> pose = linkage::SolvePose(links, d_min_mm);
  return pose ? DegreesFromRadians(pose->theta_rad) : kNaN;
}

Fraction WilsonInterval(int successes, int samples) {
  constexpr double kZ = 1.959963984540054;  // 95 %, two-sided
  const double n = samples, p = successes / n, z2 = kZ * kZ;
  const double centre = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kZ / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  return {p, std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

// Multiples of the step within the bounds, at most `reach` of them on either side of the length.
std::vector<double> GridAround(double length, const Bounds& bounds, double step, int reach) {
  constexpr double kRounding = 1e-9;
  std::vector<double> grid;
  const double centre = std::round(length / step);
  for (int i = -reach; i <= reach; ++i) {
    const double value = (centre + i) * step;
    if (value >= bounds.lower - kRounding && value <= bounds.upper + kRounding) grid.push_back(value);
  }
  return grid;
}

struct Candidate {
  double most;  // that its goal can be
  linkage::Links links;
};

// The goal of the exact links, which no tolerance betters; NaN where they have none.
double NominalGoal(const linkage::Links& links, const SynthesisProblem& problem, const Requirement* duration) {
  if (!duration) return RangeOf(links, problem.d_min_mm);
  const std::vector<WorstPoint> worst = UsedPoses(links, problem).WorstPoints(*duration);
  return worst.empty() ? kNaN : -worst.front().value;
}

// The candidates of the grid that meet the quick requirements, the best first.
std::vector<Candidate> Candidates(const std::array<std::vector<double>, 6>& grid, const SynthesisProblem& problem,
                                  double tolerance_mm) {
  const std::vector<Requirement> requirements = RequirementsOf(problem);
  const auto duration =
      std::ranges::find_if(requirements, [&](const Requirement& requirement) { return requirement.is_sought; });
  const Requirement* sought = duration == requirements.end() ? nullptr : &*duration;
  std::vector<Candidate> candidates;
  const auto total = std::accumulate(grid.begin(), grid.end(), std::size_t{1},
                                     [](std::size_t product, const auto& axis) { return product * axis.size(); });
  for (std::size_t n = 0; n < total; ++n) {
    if (n % 1024 == 0) ThrowIfInterrupted();
    std::array<double, 6> values{};
    for (std::size_t i = 0, rest = n; i < values.size(); rest /= grid[i].size(), ++i)
      values[i] = grid[i][rest % grid[i].size()];
    const linkage::Links links = linkage::Links::FromValues(values);
    if (!MeetsLinkRequirements(links, problem, requirements, tolerance_mm)) continue;
    if (const double most = NominalGoal(links, problem, sought); !std::isnan(most)) candidates.push_back({most, links});
  }
  std::ranges::stable_sort(candidates, std::ranges::greater(), &Candidate::most);
  return candidates;
}

// The best of the candidates, which come with the most that each can be: the search ends where that is no better than
// what was found.
std::optional<DesignEvaluation> FindBest(const std::vector<Candidate>& candidates, const SynthesisProblem& problem,
                                         linkage::Links& links) {
  std::optional<DesignEvaluation> best;
  for (const Candidate& candidate : candidates) {
    ThrowIfInterrupted();
    if (best && candidate.most <= GoalOf(problem, *best)) break;
    if (!IsFeasible(candidate.links, problem)) continue;
    DesignEvaluation evaluation = Evaluate(candidate.links, problem);
    if (best && GoalOf(problem, evaluation) <= GoalOf(problem, *best)) continue;
    best = std::move(evaluation);
    links = candidate.links;
  }
  return best;
}

}  // namespace

std::string LengthName(int link) {
  return link < kLinks ? LinkName(link) : "d_min";
}

std::vector<SensitivityPoint> Sensitivity(const linkage::Links& links, const SynthesisProblem& problem, double span_mm,
                                          int steps, const std::function<void()>& step) {
  const std::vector<Requirement> requirements = RequirementsOf(problem);
  // The optimum itself sits on its limits to within what a solver leaves.
  constexpr double kTolerance_mm = 1e-6;
  std::vector<std::optional<SensitivityPoint>> points(static_cast<std::size_t>(PointsOfSensitivity(steps)));
  // Points take the longer the nearer they are to the design: by such strides all parts of the work are alike, and
  // what is left follows from what is done.
  auto stride = static_cast<std::size_t>(0.618 * static_cast<double>(points.size())) + 1;
  while (std::gcd(stride, points.size()) != 1) ++stride;
  std::mutex stepping;
  ForEachInThreads(points.size(), Threads(), [&](std::size_t turn) {
    ThrowIfInterrupted();
    const std::size_t n = turn * stride % points.size();
    const int of_each = 2 * steps + 1, link = static_cast<int>(n) / of_each, i = static_cast<int>(n) % of_each - steps;
    auto values = links.Values();
    SynthesisProblem changed = problem;
    SensitivityPoint point{.link = link, .delta_mm = span_mm * i / steps, .range_deg = 0, .feasible = false};
    double& length = link < kLinks ? values[static_cast<std::size_t>(link)] : changed.d_min_mm;
    length += point.delta_mm;
    if (length > 0) {
      const linkage::Links build = linkage::Links::FromValues(values);
      point.range_deg = RangeOf(build, changed.d_min_mm);
      point.feasible = MeetsLinkRequirements(build, changed, requirements, kTolerance_mm) &&
                       IsFeasible(build, changed, kTolerance_mm);
      points[n] = point;
    }
    const std::lock_guard lock(stepping);
    step();
  });
  std::vector<SensitivityPoint> found;
  for (const std::optional<SensitivityPoint>& point : points)
    if (point) found.push_back(*point);
  return found;
}

void YieldOptions::Check() const {
  if (!(std::isfinite(tolerance_mm) && tolerance_mm > 0))
    throw Fail("the tolerance of the yield must be above 0 mm, not {}", tolerance_mm);
  if (!(std::isfinite(pin_clearance_mm) && pin_clearance_mm >= 0))
    throw Fail("the clearance of the pins must be 0 mm or above, not {}", pin_clearance_mm);
  if (samples < 1) throw Fail("the yield needs at least one sample, not {}", samples);
}

namespace {

// In how many holes play makes a member longer or shorter. Coupler, bar and actuator have two each; the knee's pin
// bears the coupler's force along the coupler's line, as a third.
constexpr int kCouplerHoles = 3, kBarHoles = 2, kActuatorHoles = 2;

BuildError RandomBuild(const YieldOptions& options, std::mt19937_64& random) {
  const auto within = [&](double half_width) {
    const double unit = static_cast<double>(random() >> 11) * 0x1p-53;
    return half_width * (2 * unit - 1);
  };
  const auto play = [&](int holes) {
    double sum = 0;
    for (int i = 0; i < holes && options.pin_clearance_mm > 0; ++i) sum += within(options.pin_clearance_mm / 2);
    return sum;
  };
  BuildError build{};
  for (double& error : build) error = within(options.tolerance_mm);
  build[0] += play(kCouplerHoles);
  build[1] += play(kBarHoles);
  build[6] += play(kActuatorHoles);
  return build;
}

// The values of the limits and the range of one build; NaN where there is none.
struct BuildValues {
  bool is_assembled = false, keeps_all = false;
  double range_deg = kNaN;
  std::vector<double> values;
  std::vector<bool> kept;
};

BuildValues ValuesOf(const BuildError& build, const linkage::Links& links, const SynthesisProblem& problem) {
  const DesignEvaluation evaluation = Evaluate(LinksOf(build, links), ProblemOf(build, problem));
  BuildValues values;
  values.is_assembled = evaluation.pose.has_value();
  values.keeps_all = evaluation.IsFeasible();
  values.range_deg = evaluation.range_deg;
  for (const RequirementCheck& check : evaluation.checks) {
    values.values.push_back(check.value);
    values.kept.push_back(check.Holds());
  }
  return values;
}

// Builds without a value are worse than any.
double KeptBy95(std::vector<double> values, bool is_lower_limit) {
  const auto builds = static_cast<double>(values.size());
  std::erase_if(values, [](double value) { return std::isnan(value); });
  const double share = 0.95 * builds / static_cast<double>(values.size());
  return share <= 1 ? Quantile(std::move(values), is_lower_limit ? 1 - share : share) : kNaN;
}

template <typename Counts>
Fraction FractionOf(const std::vector<BuildValues>& builds, const Counts& counts) {
  return WilsonInterval(static_cast<int>(std::ranges::count_if(builds, counts)), static_cast<int>(builds.size()));
}

}  // namespace

double YieldOptions::Most_mm() const {
  return tolerance_mm + pin_clearance_mm / 2 * std::max({kCouplerHoles, kBarHoles, kActuatorHoles});
}

const LimitYield* Yield::Find(std::string_view name) const {
  const auto found = std::ranges::find(limits, name, [](const LimitYield& limit) { return limit.requirement.name; });
  return found == limits.end() ? nullptr : &*found;
}

Yield EstimateYield(const linkage::Links& links, const SynthesisProblem& problem, const YieldOptions& options) {
  options.Check();
  std::mt19937_64 random(options.seed);
  std::vector<BuildError> errors;
  for (int sample = 0; sample < options.samples; ++sample) errors.push_back(RandomBuild(options, random));
  std::vector<BuildValues> builds(errors.size());
  ForEachInThreads(errors.size(), Threads(), [&](std::size_t i) {
    ThrowIfInterrupted();
    builds[i] = ValuesOf(errors[i], links, problem);
  });
  Yield yield;
  yield.options = options;
  yield.assembled = FractionOf(builds, &BuildValues::is_assembled);
  yield.all = FractionOf(builds, &BuildValues::keeps_all);
  const std::vector<Requirement> requirements = RequirementsOf(problem);
  for (std::size_t i = 0; i < requirements.size(); ++i) {
    std::vector<double> values;
    for (const BuildValues& build : builds) values.push_back(build.values[i]);
    yield.limits.push_back({.requirement = requirements[i],
                            .kept = FractionOf(builds, [i](const BuildValues& build) { return build.kept[i]; }),
                            .kept_by_95 = KeptBy95(std::move(values), requirements[i].is_lower_limit)});
  }
  std::vector<double> ranges;
  for (const BuildValues& build : builds)
    if (build.is_assembled) ranges.push_back(build.range_deg);
  yield.range_p5_deg = Quantile(ranges, 0.05);
  yield.range_median_deg = Quantile(ranges, 0.5);
  yield.range_p95_deg = Quantile(ranges, 0.95);
  const double play_mm = options.pin_clearance_mm / 2;
  yield.safe_singularity_margin_mm =
      options.tolerance_mm * (2 + (links.l5 + links.l6) / links.L7()) + play_mm * (kBarHoles + kActuatorHoles);
  yield.safe_grashof_margin_mm = options.tolerance_mm * 4 + play_mm * (kCouplerHoles + kBarHoles);
  return yield;
}

std::optional<RoundedDesign> RoundLinks(const linkage::Links& links, const SynthesisProblem& problem, double step_mm) {
  if (!(std::isfinite(step_mm) && step_mm > 0)) throw Fail("links cannot be rounded to multiples of {} mm", step_mm);
  constexpr double kRounding_mm = 1e-9;  // of sums of multiples of a step that is no binary fraction
  for (const int reach : {2, 4}) {
    std::array<std::vector<double>, 6> grid;
    for (std::size_t i = 0; i < grid.size(); ++i) {
      grid[i] = GridAround(links.Values()[i], problem.bounds[i], step_mm, reach);
      if (grid[i].empty() && reach == 4)
        throw Fail("no multiple of {} mm lies within the bounds of {}, {}..{} mm", step_mm, LinkName(i),
                   problem.bounds[i].lower, problem.bounds[i].upper);
    }
    const std::vector<Candidate> candidates = Candidates(grid, problem, kRounding_mm);
    RoundedDesign rounded;
    rounded.step_mm = step_mm;
    rounded.candidates = static_cast<int>(candidates.size());
    if (auto best = FindBest(candidates, problem, rounded.links)) {
      rounded.evaluation = std::move(*best);
      return rounded;
    }
  }
  return std::nullopt;
}

}  // namespace lake::problem
