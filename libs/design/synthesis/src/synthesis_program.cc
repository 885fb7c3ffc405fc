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
    AddRangePose();
    for (const problem::Requirement& requirement : problem::RequirementsOf(problem_)) AddLimit(requirement);
    AddUsedRange(fractions);
    if (elasticity_ == Elasticity::kNone)
      AddScaledTerm(nlp(), nlp::NlpTerm::kCost, range_, -range_weight_ * kDegreesPerRadian);
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
    stroke_ = nlp().AddVariable("d_min", d, wide ? kShortest_mm : d, wide ? kLongest_mm : d);
    if (!wide) return;
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      AddElasticBound(result_.links[i], problem::LinkName(i), problem_.bounds[i].lower, true);
      AddElasticBound(result_.links[i], problem::LinkName(i), problem_.bounds[i].upper, false);
    }
    AddElasticBound(stroke_, "d_min", d, true);
    AddElasticBound(stroke_, "d_min", d, false);
  }

  void AddRangePose() {
    range_ = nlp().AddVariable("theta", at_range_.theta_rad, -std::numbers::pi, std::numbers::pi);
    result_.poses.push_back(AddPose(nlp(), "", result_.links, stroke_, range_, 1,
                                    RadiansFromDegrees(problem_.standing_deg), at_range_.phi_rad));
  }

  void AddLimit(const problem::Requirement& requirement) {
    const double limit = requirement.limit;
    result_.limits.push_back({requirement});
    LimitRow& entry = result_.limits.back();
    // The loop implies it; as a row of its own it would have the loop's gradient and multipliers without bound.
    if (requirement.kind == Kind::kSingularity && limit == 0 && !IsElastic()) return;
    // The limit of a family is a variable of the program, so that its row carries the one price of all poses.
    entry.row = requirement.IsFamily()       ? nlp().AddRow(requirement.Text(), limit, limit)
                : requirement.is_lower_limit ? nlp().AddRow(requirement.Text(), limit, nlp::kUnbounded)
                                             : nlp().AddRow(requirement.Text(), -nlp::kUnbounded, limit);
    if (requirement.kind == Kind::kLinear)
      AddLinearTerm(nlp(), entry.row, result_.links, requirement.coefficients);
    else if (requirement.kind == Kind::kSingularity)
      AddSingularityTerm(nlp(), entry.row, result_.links, stroke_);
    else if (requirement.kind == Kind::kMaxAngle)
      AddScaledTerm(nlp(), entry.row, range_, kDegreesPerRadian);
    if (requirement.IsFamily()) {
      family_limits_.push_back(
          nlp().AddVariable("limit of " + requirement.name, limit, -nlp::kUnbounded, nlp::kUnbounded));
      AddScaledTerm(nlp(), entry.row, family_limits_.back(), 1);
    }
    if (IsElastic())
      entry.slack = AddSlack(entry.row, requirement.name, requirement.is_lower_limit, SlackUnit(requirement));
  }

  void AddUsedRange(std::vector<double> fractions) {
    const bool stands = std::any_of(result_.limits.begin(), result_.limits.end(),
                                    [](const LimitRow& entry) { return entry.requirement.NeedsStanding(); });
    if (!stands) return;
    fractions.push_back(0);
    std::sort(fractions.begin(), fractions.end());
    fractions.erase(std::unique(fractions.begin(), fractions.end()), fractions.end());
    for (const double fraction : fractions) {
      const std::string name = fmt::format(" at {:.4g}", fraction);
      const PoseStart start = StartAt(problem_, start_, at_range_, fraction);
      const int stroke = nlp().AddVariable("d" + name, start.stroke_mm, kShortest_mm, kLongest_mm);
      result_.poses.push_back(AddPose(nlp(), name, result_.links, stroke, range_, fraction,
                                      RadiansFromDegrees(problem_.standing_deg), start.phi_rad));
    }
    for (const PoseVariables& pose : result_.poses) AddNoTurningRow(nlp(), pose);
    std::size_t family = 0;
    for (const LimitRow& entry : result_.limits) {
      if (entry.requirement.kind == Kind::kMaxStroke) AddScaledTerm(nlp(), entry.row, result_.poses[1].stroke, 1);
      if (!entry.requirement.IsFamily()) continue;
      for (const PoseVariables& pose : result_.poses)
        AddFamilyRow(nlp(), entry.requirement, pose, family_limits_[family], problem_.knee_torque_nm);
      ++family;
    }
  }

  const problem::SynthesisProblem& problem_;
  const linkage::Links start_;
  const Elasticity elasticity_;
  const double range_weight_;
  const PoseStart at_range_;
  SynthesisProgram result_;
  int stroke_ = -1, range_ = -1;
  std::vector<int> family_limits_;
};

}  // namespace

linkage::Links SynthesisProgram::LinksAt(const std::vector<double>& x) const {
  std::array<double, 6> values{};
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = x.at(links[i]);
  return linkage::Links::FromValues(values);
}

double SlackUnit(const problem::Requirement& requirement) {
  return requirement.kind == Kind::kForce ? requirement.limit / 100 : 1;
}

SynthesisProgram BuildProgram(const problem::SynthesisProblem& problem, const linkage::Links& start,
                              const std::vector<double>& fractions, Elasticity elasticity, double range_weight) {
  return Builder(problem, start, elasticity, range_weight).Build(fractions);
}

}  // namespace lake::synthesis
