#include "lake/problem/robustness.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <random>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"
#include "lake/core/threads.h"

namespace lake::problem {
namespace {

constexpr int kLinks = 6;

double RangeOf(const linkage::Links& links, double d_min_mm) {
  const std::optional<linkage::Pose> pose = linkage::SolvePose(links, d_min_mm);
  return pose ? DegreesFromRadians(pose->theta_rad) : std::numeric_limits<double>::quiet_NaN();
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
  double range_deg;
  linkage::Links links;
};

// The candidates of the grid that meet the quick requirements, the largest range first.
std::vector<Candidate> Candidates(const std::array<std::vector<double>, 6>& grid, const SynthesisProblem& problem,
                                  double tolerance_mm) {
  const std::vector<Requirement> requirements = RequirementsOf(problem);
  std::vector<Candidate> candidates;
  const auto total = std::accumulate(grid.begin(), grid.end(), std::size_t{1},
                                     [](std::size_t product, const auto& axis) { return product * axis.size(); });
  for (std::size_t n = 0; n < total; ++n) {
    std::array<double, 6> values{};
    for (std::size_t i = 0, rest = n; i < values.size(); rest /= grid[i].size(), ++i)
      values[i] = grid[i][rest % grid[i].size()];
    const linkage::Links links = linkage::Links::FromValues(values);
    if (MeetsLinkRequirements(links, problem, requirements, tolerance_mm))
      candidates.push_back({RangeOf(links, problem.d_min_mm), links});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.range_deg > b.range_deg; });
  return candidates;
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
  // what is done tells what is left.
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

struct Build {
  linkage::Links links;
  double d_min_mm;
};

Build RandomBuild(const linkage::Links& links, double d_min_mm, const YieldOptions& options, std::mt19937_64& random) {
  const auto within = [&](double half_width) {
    const double unit = static_cast<double>(random() >> 11) * 0x1p-53;
    return half_width * (2 * unit - 1);
  };
  const auto play = [&](int holes) {
    double sum = 0;
    for (int i = 0; i < holes && options.pin_clearance_mm > 0; ++i) sum += within(options.pin_clearance_mm / 2);
    return sum;
  };
  auto values = links.Values();
  for (double& value : values) value += within(options.tolerance_mm);
  Build build{linkage::Links::FromValues(values), d_min_mm + within(options.tolerance_mm)};
  build.links.l1 += play(kCouplerHoles);
  build.links.l2 += play(kBarHoles);
  build.d_min_mm += play(kActuatorHoles);
  return build;
}

}  // namespace

Yield EstimateYield(const linkage::Links& links, const SynthesisProblem& problem, const YieldOptions& options) {
  options.Check();
  std::mt19937_64 random(options.seed);
  int assembled = 0, assembled_and_grashof = 0;
  std::vector<double> ranges;
  for (int sample = 0; sample < options.samples; ++sample) {
    if (sample % 1024 == 0) ThrowIfInterrupted();
    const Build built = RandomBuild(links, problem.d_min_mm, options, random);
    const linkage::Links& build = built.links;
    const double range = RangeOf(build, built.d_min_mm);
    if (std::isnan(range)) continue;
    ++assembled;
    assembled_and_grashof += build.l3 + build.l4 <= build.l1 + build.l2;
    ranges.push_back(range);
  }
  Yield yield{.options = options,
              .assembled = WilsonInterval(assembled, options.samples),
              .assembled_and_grashof = WilsonInterval(assembled_and_grashof, options.samples),
              .range_p5_deg = Quantile(ranges, 0.05),
              .range_median_deg = Quantile(ranges, 0.5),
              .range_p95_deg = Quantile(ranges, 0.95)};
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
    for (const Candidate& candidate : candidates) {
      ThrowIfInterrupted();
      if (IsFeasible(candidate.links, problem))
        return RoundedDesign{.step_mm = step_mm,
                             .links = candidate.links,
                             .evaluation = Evaluate(candidate.links, problem),
                             .candidates = static_cast<int>(candidates.size())};
    }
  }
  return std::nullopt;
}

}  // namespace lake::problem
