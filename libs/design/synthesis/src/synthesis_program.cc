#include "lake/synthesis/synthesis_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"

namespace lake::synthesis {
namespace {

using Kind = problem::Requirement::Kind;
constexpr double kShortest_mm = 1, kLongest_mm = 1e4;  // bounds that give way, and strokes, stay within

// Where the variables of a pose start: on the linkage where it can be assembled, else at a plausible place.
struct PoseStart {
  double stroke_mm, phi_rad, theta_rad;
};

PoseStart StartAtRange(const problem::SynthesisProblem& problem, const linkage::Links& start) {
  if (const auto pose = linkage::SolvePose(start, problem.d_min_mm))
    return {problem.d_min_mm, pose->phi_rad, pose->theta_rad};
  constexpr double kPlausiblePhi_rad = 0.6, kPlausibleTheta_rad = 1.5;
  return {problem.d_min_mm, kPlausiblePhi_rad, kPlausibleTheta_rad};
}

PoseStart StartAt(const problem::SynthesisProblem& problem, const linkage::Links& start, const PoseStart& at_range,
                  double fraction) {
  const double standing = RadiansFromDegrees(problem.standing_deg);
  const double theta = std::lerp(standing, at_range.theta_rad, fraction);
  if (linkage::SolvePose(start, problem.d_min_mm)) {
    const linkage::UsedRange range = linkage::FindUsedRange(start, problem.d_min_mm, std::nullopt, standing);
    const auto stroke = linkage::StrokeForAngle(start, range, theta);
    const auto pose = stroke ? linkage::SolvePose(start, *stroke) : std::nullopt;
    if (pose) return {*stroke, pose->phi_rad, theta};
  }
  constexpr double kPlausibleTravel_mm = 120;
  return {problem.d_min_mm + (1 - fraction) * kPlausibleTravel_mm,
          std::lerp(std::numbers::pi, at_range.phi_rad, fraction), theta};
}

class Builder {
 public:
  Builder(const problem::SynthesisProblem& problem, const linkage::Links& start, Elasticity elasticity,
          double range_weight)
      : problem_(problem),
        start_(start),
        elasticity_(elasticity),
        range_weight_(range_weight),
        at_range_(StartAtRange(problem, start)) {}

  SynthesisProgram Build(const std::vector<double>& fractions) {
    AddLinksAndStroke();
    AddShortestPose();
    for (const problem::Requirement& requirement : problem::RequirementsOf(problem_)) AddRequirement(requirement);
    AddUsedRange(fractions);
    if (elasticity_ == Elasticity::kNone)
      AddScaledTerm(nlp(), nlp::NlpTerm::kCost, result_.range, -range_weight_ * kDegreesPerRadian);
    return std::move(result_);
  }

 private:
  nlp::NonlinearProgram& nlp() { return result_.program; }
  bool IsElastic() const { return elasticity_ != Elasticity::kNone; }

  // A slack for a row whose limit may be moved.
  int AddSlack(int row, const std::string& name, bool is_lower_limit, double unit) {
    const int slack = nlp().AddVariable("slack of " + name, 0, 0, nlp::kUnbounded);
    AddScaledTerm(nlp(), row, slack, is_lower_limit ? 1 : -1);
    AddScaledTerm(nlp(), nlp::NlpTerm::kCost, slack, 1 / unit);
    return slack;
  }

  void AddElasticBound(int variable, const std::string& name, double limit, bool is_lower_limit) {
    const std::string text = fmt::format("{} {} {:.6g} mm", name, is_lower_limit ? ">=" : "<=", limit);
    const int row =
        is_lower_limit ? nlp().AddRow(text, limit, nlp::kUnbounded) : nlp().AddRow(text, -nlp::kUnbounded, limit);
    AddScaledTerm(nlp(), row, variable, 1);
    result_.elastic_bounds.push_back({text, limit, is_lower_limit, AddSlack(row, text, is_lower_limit, 1), row});
  }

  void AddLinksAndStroke() {
    const bool wide = elasticity_ == Elasticity::kEverything;
    std::array<problem::Bounds, 6> bounds = problem_.bounds;
    if (wide) bounds.fill({kShortest_mm, kLongest_mm});
    result_.links = AddLinks(nlp(), bounds, start_);
    const double d = problem_.d_min_mm;
    result_.shortest_stroke = nlp().AddVariable("d_min", d, wide ? kShortest_mm : d, wide ? kLongest_mm : d);
    for (int i = 0; i < 6; ++i) result_.limits.push_back({{LimitId::On::kLink, i}, "mm", -1, result_.links[i]});
    result_.limits.push_back({{LimitId::On::kShortestStroke}, "mm", -1, result_.shortest_stroke});
    if (!wide) return;
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      AddElasticBound(result_.links[i], problem::LinkName(i), problem_.bounds[i].lower, true);
      AddElasticBound(result_.links[i], problem::LinkName(i), problem_.bounds[i].upper, false);
    }
    AddElasticBound(result_.shortest_stroke, "d_min", d, true);
    AddElasticBound(result_.shortest_stroke, "d_min", d, false);
  }

  void AddShortestPose() {
    result_.range = nlp().AddVariable("theta", at_range_.theta_rad, -std::numbers::pi, std::numbers::pi);
    poses_.push_back(AddPose(nlp(), "", result_.links, result_.shortest_stroke, result_.range, 1,
                             RadiansFromDegrees(problem_.standing_deg), at_range_.phi_rad));
  }

  void AddRequirement(const problem::Requirement& requirement) {
    const double limit = requirement.limit;
    RequirementRow& entry = result_.requirements.emplace_back(RequirementRow{requirement});
    // The loop implies it; as a row of its own it would have the loop's gradient and multipliers without bound.
    if (requirement.id.kind == Kind::kSingularity && limit == 0 && !IsElastic()) return;
    // The limit of a family is a variable of the program, so that its row carries the one price of all poses.
    entry.row = requirement.IsFamily()       ? nlp().AddRow(requirement.Text(), limit, limit)
                : requirement.is_lower_limit ? nlp().AddRow(requirement.Text(), limit, nlp::kUnbounded)
                                             : nlp().AddRow(requirement.Text(), -nlp::kUnbounded, limit);
    result_.limits.push_back({LimitOn(requirement.id), requirement.unit, entry.row});
    if (requirement.IsLinear())
      AddLinearTerm(nlp(), entry.row, result_.links, requirement.coefficients);
    else if (requirement.id.kind == Kind::kSingularity)
      AddSingularityTerm(nlp(), entry.row, result_.links, result_.shortest_stroke);
    else if (requirement.id.kind == Kind::kMaxAngle)
      AddScaledTerm(nlp(), entry.row, result_.range, kDegreesPerRadian);
    if (requirement.IsFamily()) {
      entry.family_limit = nlp().AddVariable("limit of " + requirement.name, limit, -nlp::kUnbounded, nlp::kUnbounded);
      AddScaledTerm(nlp(), entry.row, entry.family_limit, 1);
    }
    if (IsElastic())
      entry.slack = AddSlack(entry.row, requirement.name, requirement.is_lower_limit, SlackUnit(requirement));
  }

  void AddUsedRange(std::vector<double> fractions) {
    const bool stands = std::ranges::any_of(
        result_.requirements, [](const RequirementRow& entry) { return entry.requirement.NeedsStanding(); });
    if (!stands) return;
    constexpr double kStanding = 0;
    fractions.push_back(kStanding);
    std::sort(fractions.begin(), fractions.end());
    fractions.erase(std::unique(fractions.begin(), fractions.end()), fractions.end());
    for (const double fraction : fractions) {
      const std::string name = fmt::format(" at {:.4g}", fraction);
      const PoseStart start = StartAt(problem_, start_, at_range_, fraction);
      const int stroke = nlp().AddVariable("d" + name, start.stroke_mm, kShortest_mm, kLongest_mm);
      poses_.push_back(AddPose(nlp(), name, result_.links, stroke, result_.range, fraction,
                               RadiansFromDegrees(problem_.standing_deg), start.phi_rad));
    }
    for (const PoseVariables& pose : poses_) AddNoTurningRow(nlp(), pose);
    const PoseVariables& standing = *std::ranges::find(poses_, kStanding, &PoseVariables::fraction);
    for (const RequirementRow& entry : result_.requirements) {
      if (entry.requirement.id.kind == Kind::kMaxStroke) AddScaledTerm(nlp(), entry.row, standing.stroke, 1);
      if (!entry.requirement.IsFamily()) continue;
      for (const PoseVariables& pose : poses_)
        AddFamilyRow(nlp(), entry.requirement, pose, entry.family_limit, problem_.knee_torque_nm);
    }
  }

  const problem::SynthesisProblem& problem_;
  const linkage::Links start_;
  const Elasticity elasticity_;
  const double range_weight_;
  const PoseStart at_range_;
  SynthesisProgram result_;
  std::vector<PoseVariables> poses_;
};

}  // namespace

LimitId LimitOn(const problem::Requirement::Id& requirement) {
  return {LimitId::On::kRequirement, 0, requirement};
}

const Limit* SynthesisProgram::Find(const LimitId& id) const {
  const auto found = std::ranges::find(limits, id, &Limit::id);
  return found == limits.end() ? nullptr : &*found;
}

double SlackUnit(const problem::Requirement& requirement) {
  return requirement.id.kind == Kind::kForce ? requirement.limit / 100 : 1;
}

SynthesisProgram BuildProgram(const problem::SynthesisProblem& problem, const linkage::Links& start,
                              const std::vector<double>& fractions, Elasticity elasticity, double range_weight) {
  return Builder(problem, start, elasticity, range_weight).Build(fractions);
}

}  // namespace lake::synthesis
