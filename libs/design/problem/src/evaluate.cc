#include "lake/problem/evaluate.h"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "lake/core/angles.h"
#include "lake/core/numbers.h"
#include "lake/problem/assistance.h"

namespace lake::problem {
namespace {

constexpr int kGridPoints = 721;  // a quarter of a degree or finer over any range of a knee

// The used range of a design that can stand; nullopt otherwise. An optimum may stand exactly where the actuator is
// stretched out, the end of its assembly range, where an angle is known to the square root of rounding.
std::optional<linkage::UsedRange> StandingRange(const linkage::Links& links, const SynthesisProblem& problem) {
  if (!linkage::SolvePose(links, problem.d_min_mm)) return std::nullopt;
  const linkage::UsedRange range =
      linkage::FindUsedRange(links, problem.d_min_mm, std::nullopt, RadiansFromDegrees(problem.standing_deg));
  constexpr double kRounding_rad = 1e-5;
  const bool stands = range.end == linkage::UsedRange::End::kStanding ||
                      range.theta_at_upper_rad <= RadiansFromDegrees(problem.standing_deg) + kRounding_rad;
  return stands ? std::optional(range) : std::nullopt;
}

// At a stroke; nullopt where there is none or no pose.
std::optional<linkage::Pose> PoseAt(const linkage::Links& links, std::optional<double> stroke_mm) {
  return stroke_mm ? linkage::SolvePose(links, *stroke_mm) : std::nullopt;
}

// At a fraction of the used range.
std::optional<linkage::Pose> PoseAt(const linkage::Links& links, const linkage::UsedRange& range, double fraction) {
  const double theta = std::lerp(range.theta_at_upper_rad, range.theta_at_lower_rad, fraction);
  return PoseAt(links, fraction <= 0   ? range.stroke.upper_mm
                       : fraction >= 1 ? range.stroke.lower_mm
                                       : linkage::StrokeForAngle(links, range, theta));
}

// mm, of a pose on the body.
double ClearanceOf(const linkage::Pose& pose, const SynthesisProblem& problem, Obstacle obstacle) {
  const person::Body body = person::BodyOf(problem.clearances.body);
  const linkage::WearOptions wear = problem.Wear();
  const linkage::Pose on_body = linkage::PutOnBody(pose, wear.placement_mm);
  if (obstacle == Obstacle::kSeat) return linkage::SeatClearance(on_body, body, wear);
  const linkage::Limb limb = obstacle == Obstacle::kThigh ? linkage::Limb::kThigh : linkage::Limb::kShank;
  return linkage::LimbSeparation(limb, on_body, body, wear).distance_mm;
}

// The value of a row of kLimits in any pose of a linkage under one load.
class PoseValue {
 public:
  PoseValue(const linkage::Links& links, const SynthesisProblem& problem, std::size_t row, const PoseLoad& load)
      : links_(links.Values()), problem_(problem), info_(kLimitInfos[row]) {
    VisitLimit(row, [&](const auto& of) {
      of.parts(load, [&](const char*, auto ratio) { ratios_.emplace_back(std::move(ratio)); });
    });
  }

  // NaN where there is no pose.
  double operator()(const std::optional<linkage::Pose>& pose) const {
    if (!pose) return kNaN;
    if (info_.obstacle != Obstacle::kNone) return ClearanceOf(*pose, problem_, info_.obstacle);
    const PoseQuantities<double> quantities(links_.data(), pose->stroke_mm, pose->phi_rad, pose->theta_rad);
    double worst = info_.is_lower ? kInfinity : ratios_.empty() ? 0 : -kInfinity;
    for (const auto& ratio : ratios_) {
      const auto [over, under] = ratio(quantities);
      // Of the two signs of a force one is never the worst.
      const double value = under > 0 ? over / under : kInfinity;
      worst = info_.is_lower ? std::min(worst, value) : std::max(worst, value);
    }
    return info_.is_sine ? DegreesFromRadians(std::asin(std::clamp(worst, -1.0, 1.0))) : worst;
  }

 private:
  std::array<double, 6> links_;
  const SynthesisProblem& problem_;
  const LimitInfo& info_;
  std::vector<std::function<Ratio<double>(const PoseQuantities<double>&)>> ratios_;
};

// Those of the profile's samples that a requirement is on.
std::vector<int> SamplesOf(const SynthesisProblem& problem, const Requirement& requirement) {
  const std::vector<int> samples = SamplesInUse(problem);
  const bool at_the_end = requirement.Info().place == Place::kAtRest && !problem.rests_anywhere;
  return at_the_end && !samples.empty() ? std::vector<int>{samples.back()} : samples;
}

void SortBySlack(std::vector<WorstPoint>& worst, const Requirement& requirement) {
  std::stable_sort(worst.begin(), worst.end(), [&](const WorstPoint& a, const WorstPoint& b) {
    return requirement.Slack(a.value) < requirement.Slack(b.value);
  });
}

std::vector<WorstPoint> WorstSamples(const linkage::Links& links, const SynthesisProblem& problem,
                                     const linkage::UsedRange& range, const Requirement& requirement) {
  std::vector<WorstPoint> points;
  for (const int i : SamplesOf(problem, requirement)) {
    const LoadSample& sample = problem.profile->samples[i];
    const PoseValue value(links, problem, requirement.row, problem.LoadAt(sample));
    points.push_back({sample.percent / 100, value(PoseAt(links, ProfileStroke(links, range, sample.knee_rad))), i});
  }
  const auto slack = [&](std::size_t i) { return requirement.Slack(points[i].value); };
  std::vector<WorstPoint> worst;
  for (std::size_t i = 0; i < points.size(); ++i)
    if ((i == 0 || slack(i) <= slack(i - 1)) && (i + 1 == points.size() || slack(i) < slack(i + 1)))
      worst.push_back(points[i]);
  SortBySlack(worst, requirement);
  return worst;
}

// Of a requirement that is closed form in the links and the range.
double LinkValue(const linkage::Links& links, const SynthesisProblem& problem, const Requirement& requirement,
                 double range_deg) {
  if (!requirement.IsOnLinks()) return range_deg;
  if (!requirement.IsLinear()) return links.l2 + problem.d_min_mm - links.L7();
  double sum = 0;
  const auto l = links.Values();
  for (std::size_t i = 0; i < l.size(); ++i) sum += requirement.Info().coefficients[i] * l[i];
  return sum;
}

// `poses` of these links.
RequirementCheck CheckRequirement(const linkage::Links& links, const SynthesisProblem& problem,
                                  const Requirement& requirement, double range_deg, UsedPoses& poses) {
  RequirementCheck check{.requirement = requirement, .value = kNaN, .slack = 0, .fraction = 1};
  if (!requirement.NeedsStanding()) {
    check.value = LinkValue(links, problem, requirement, range_deg);
  } else if (!requirement.IsFamily()) {
    if (poses.Range()) check.value = poses.At(requirement, 0);
    check.fraction = 0;
  } else if (const auto worst = poses.WorstPoints(requirement); !worst.empty()) {
    check.value = worst.front().value;
    check.fraction = worst.front().fraction;
  }
  check.slack = requirement.Slack(check.value);
  return check;
}

double BoundViolation(const linkage::Links& links, const SynthesisProblem& problem) {
  const auto l = links.Values();
  double worst = 0;
  for (std::size_t i = 0; i < l.size(); ++i)
    worst = std::max({worst, problem.bounds[i].lower - l[i], l[i] - problem.bounds[i].upper});
  return worst;
}

}  // namespace

double ValueInPose(const linkage::Links& links, const SynthesisProblem& problem, std::size_t row, const PoseLoad& load,
                   const std::optional<linkage::Pose>& pose) {
  return PoseValue(links, problem, row, load)(pose);
}

UsedPoses::UsedPoses(const linkage::Links& links, const SynthesisProblem& problem)
    : links_(links), problem_(problem), range_(StandingRange(links, problem)) {}

const std::vector<std::optional<linkage::Pose>>& UsedPoses::Grid() {
  if (grid_.empty())
    for (int i = 0; i < kGridPoints; ++i) grid_.push_back(PoseAt(links_, *range_, i / (kGridPoints - 1.0)));
  return grid_;
}

double UsedPoses::At(const Requirement& requirement, double fraction) const {
  return PoseValue(links_, problem_, requirement.row, problem_.ConstantLoad())(PoseAt(links_, *range_, fraction));
}

std::vector<WorstPoint> UsedPoses::WorstPoints(const Requirement& requirement) {
  if (!requirement.IsFamily())
    throw std::logic_error(fmt::format("{} is no requirement on many poses", requirement.name));
  if (!range_) return {};
  if (requirement.along_profile) return WorstSamples(links_, problem_, *range_, requirement);
  const PoseValue of_pose(links_, problem_, requirement.row, problem_.ConstantLoad());
  const auto value = [&](double fraction) { return of_pose(PoseAt(links_, *range_, fraction)); };
  if (requirement.Info().place == Place::kSeated) {
    const double seated = (problem_.SeatedAngle_rad() - range_->theta_at_upper_rad) /
                          (range_->theta_at_lower_rad - range_->theta_at_upper_rad);
    const double fraction = std::min(1.0, seated);
    return {{fraction, value(fraction)}};
  }
  const auto slack = [&](double fraction) { return requirement.Slack(value(fraction)); };
  std::vector<double> grid;
  for (const std::optional<linkage::Pose>& pose : Grid()) grid.push_back(requirement.Slack(of_pose(pose)));

  std::vector<WorstPoint> worst;
  for (int i = 0; i < kGridPoints; ++i) {
    const bool below_left = i == 0 || grid[i] <= grid[i - 1],
               below_right = i == kGridPoints - 1 || grid[i] < grid[i + 1];
    if (!below_left || !below_right) continue;
    double fraction = i / (kGridPoints - 1.0);
    if (std::isfinite(grid[i])) {
      const auto [refined, least] = boost::math::tools::brent_find_minima(
          slack, std::max(0, i - 1) / (kGridPoints - 1.0), std::min(kGridPoints - 1, i + 1) / (kGridPoints - 1.0),
          std::numeric_limits<double>::digits / 2);
      if (least < grid[i]) fraction = refined;
    }
    worst.push_back({fraction, value(fraction)});
  }
  SortBySlack(worst, requirement);
  return worst;
}

const RequirementCheck& DesignEvaluation::CheckOf(std::string_view name) const {
  const auto found =
      std::ranges::find_if(checks, [&](const RequirementCheck& check) { return check.requirement.name == name; });
  if (found == checks.end()) throw std::out_of_range("the problem has no such requirement");
  return *found;
}

namespace {

// Ends where more than `most` is violated.
DesignEvaluation EvaluateAsMade(const linkage::Links& links, const SynthesisProblem& problem, double most = kInfinity) {
  UsedPoses poses(links, problem);
  DesignEvaluation evaluation;
  evaluation.pose = linkage::SolvePose(links, problem.d_min_mm);
  if (const auto gap = linkage::FindAssemblyGap(links, problem.d_min_mm)) evaluation.gap = gap->text;
  evaluation.range_deg = evaluation.pose ? DegreesFromRadians(evaluation.pose->theta_rad) : kNaN;
  evaluation.worst_range_deg = evaluation.range_deg;
  if (poses.Range()) evaluation.stands_mm = poses.Range()->stroke.upper_mm;
  evaluation.bound_violation_mm = BoundViolation(links, problem);
  evaluation.violation = std::max(evaluation.pose ? 0 : kInfinity, evaluation.bound_violation_mm);
  for (const Requirement& requirement : RequirementsOf(problem)) {
    if (evaluation.violation > most) break;
    evaluation.checks.push_back(CheckRequirement(links, problem, requirement, evaluation.range_deg, poses));
    evaluation.violation = std::max(evaluation.violation, evaluation.checks.back().Violation());
  }
  return evaluation;
}

// Takes what is worse of a build.
void TakeWorst(const DesignEvaluation& build, DesignEvaluation& worst) {
  for (std::size_t i = 0; i < worst.checks.size(); ++i)
    if (build.checks[i].slack < worst.checks[i].slack) worst.checks[i] = build.checks[i];
  worst.violation = std::max(worst.violation, build.violation);
  worst.worst_range_deg = std::min(worst.worst_range_deg, std::isnan(build.range_deg) ? -kInfinity : build.range_deg);
}

}  // namespace

DesignEvaluation Evaluate(const linkage::Links& links, const SynthesisProblem& problem) {
  DesignEvaluation evaluation = EvaluateAsMade(links, problem);
  for (const BuildError& build : Corners(problem.robust_mm))
    TakeWorst(EvaluateAsMade(LinksOf(build, links), ProblemOf(build, problem)), evaluation);
  return evaluation;
}

bool IsFeasible(const linkage::Links& links, const SynthesisProblem& problem, double tolerance) {
  const auto is_feasible = [tolerance](const linkage::Links& of, const SynthesisProblem& as) {
    return EvaluateAsMade(of, as, tolerance).IsFeasible(tolerance);
  };
  return is_feasible(links, problem) && std::ranges::all_of(Corners(problem.robust_mm), [&](const BuildError& build) {
           return is_feasible(LinksOf(build, links), ProblemOf(build, problem));
         });
}

double GoalOf(const SynthesisProblem& problem, const DesignEvaluation& evaluation) {
  if (problem.goal == SynthesisProblem::Goal::kRange) return evaluation.worst_range_deg;
  return -evaluation.CheckOf(Requirement::kDuration).value;
}

bool MeetsLinkRequirements(const linkage::Links& links, const SynthesisProblem& problem,
                           const std::vector<Requirement>& requirements, double tolerance_mm) {
  const std::optional<linkage::Pose> pose = linkage::SolvePose(links, problem.d_min_mm);
  if (!pose || BoundViolation(links, problem) > tolerance_mm) return false;
  const double range_deg = DegreesFromRadians(pose->theta_rad);
  return std::all_of(requirements.begin(), requirements.end(), [&](const Requirement& requirement) {
    return requirement.NeedsStanding() ||
           requirement.Slack(LinkValue(links, problem, requirement, range_deg)) >= -tolerance_mm;
  });
}

}  // namespace lake::problem
