#include "lake/synthesis/synthesis_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/problem/assistance.h"
#include "lake/problem/evaluate.h"

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
                  double theta) {
  const double standing = RadiansFromDegrees(problem.standing_deg);
  if (linkage::SolvePose(start, problem.d_min_mm)) {
    const linkage::UsedRange range = linkage::FindUsedRange(start, problem.d_min_mm, std::nullopt, standing);
    const auto stroke = linkage::StrokeForAngle(start, range, theta);
    const auto pose = stroke ? linkage::SolvePose(start, *stroke) : std::nullopt;
    if (pose) return {*stroke, pose->phi_rad, theta};
  }
  constexpr double kPlausibleTravel_mm = 120;
  const double fraction = (theta - standing) / (at_range.theta_rad - standing);
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

  SynthesisProgram Build(const Collocation& poses) {
    AddLinksAndStroke();
    AddShortestPose();
    for (const problem::Requirement& requirement : problem::RequirementsOf(problem_)) AddRequirement(requirement);
    AddUsedRange(poses.fractions);
    AddProfile(poses.samples);
    if (!IsElastic()) AddGoal();
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
    const double least = IsSought(requirement) ? 0 : limit;
    entry.row = requirement.IsFamily()       ? nlp().AddRow(requirement.Text(), least, limit)
                : requirement.is_lower_limit ? nlp().AddRow(requirement.Text(), limit, nlp::kUnbounded)
                                             : nlp().AddRow(requirement.Text(), -nlp::kUnbounded, limit);
    result_.limits.push_back({LimitOn(requirement.id), requirement.unit, entry.row});
    if (requirement.IsLinear())
      AddLinearTerm(nlp(), entry.row, result_.links, requirement.coefficients);
    else if (requirement.id.kind == Kind::kSingularity)
      AddSingularityTerm(nlp(), entry.row, result_.links, result_.shortest_stroke);
    else if (requirement.id.kind == Kind::kMaxAngle || requirement.id.kind == Kind::kReach)
      AddScaledTerm(nlp(), entry.row, result_.range, kDegreesPerRadian);
    if (requirement.IsFamily()) {
      const double start = IsSought(requirement) ? StartDuration() : limit;
      entry.family_limit = nlp().AddVariable("limit of " + requirement.name, start, -nlp::kUnbounded, nlp::kUnbounded);
      AddScaledTerm(nlp(), entry.row, entry.family_limit, 1);
    }
    // Angles that the linkage does not reach have no force that could be held against a limit.
    if (IsElastic() && requirement.id.kind != Kind::kReach)
      entry.slack = AddSlack(entry.row, requirement.name, requirement.is_lower_limit, SlackUnit(requirement));
  }

  // The duration is what is minimised, and its limit no more than a bound.
  bool IsSought(const problem::Requirement& requirement) const {
    return requirement.id.kind == Kind::kDuration && problem_.SeeksDuration() && !IsElastic();
  }

  // The links' own, where they can make the motion at all.
  double StartDuration() const {
    constexpr double kPlausible_s = 20, kLeast_s = 0.1, kMost_s = 600;
    for (const problem::Requirement& requirement : problem::RequirementsOf(problem_)) {
      if (requirement.id.kind != Kind::kDuration) continue;
      const auto worst = problem::WorstPoints(start_, problem_, requirement);
      if (!worst.empty() && std::isfinite(worst.front().value))
        return std::clamp(worst.front().value, kLeast_s, kMost_s);
    }
    return kPlausible_s;
  }

  void AddGoal() {
    constexpr double kTie = 1e-6;  // s per deg
    const bool is_duration = problem_.SeeksDuration();
    AddScaledTerm(nlp(), nlp::NlpTerm::kCost, result_.range,
                  -range_weight_ * (is_duration ? kTie : 1) * kDegreesPerRadian);
    for (const RequirementRow& entry : result_.requirements)
      if (IsSought(entry.requirement)) AddScaledTerm(nlp(), nlp::NlpTerm::kCost, entry.family_limit, 1);
  }

  // Poses at samples of the load profile, whose knee angles are given, with the families that hold there.
  void AddProfile(const std::vector<int>& samples) {
    for (const int i : samples) {
      const problem::LoadSample& sample = problem_.profile->samples[i];
      const std::string name = fmt::format(" at {:.4g} %", sample.percent);
      const PoseStart start = StartAt(problem_, start_, at_range_, sample.knee_rad);
      const int stroke = nlp().AddVariable("d" + name, start.stroke_mm, kShortest_mm, kLongest_mm);
      const PoseVariables pose =
          AddPose(nlp(), name, result_.links, stroke, result_.range, /*fraction=*/0, sample.knee_rad, start.phi_rad);
      AddNoTurningRow(nlp(), pose);
      for (const RequirementRow& entry : result_.requirements)
        if (entry.requirement.along_profile) AddProfileRow(entry, sample, pose);
    }
  }

  void AddProfileRow(const RequirementRow& entry, const problem::LoadSample& sample, const PoseVariables& pose) {
    const double torque_nm = std::abs(problem_.TorqueAt(sample));
    if (entry.requirement.id.kind == Kind::kDuration) {
      for (const problem::SpeedLine& line : problem_.actuator->SpeedLines())
        AddDurationRow(nlp(), pose, entry.family_limit, line, torque_nm, std::abs(sample.rad_per_rise));
      return;
    }
    const bool may_rest = problem_.rests_anywhere || &sample == &LastSampleInUse();
    if (torque_nm > 0 && (entry.requirement.id.kind != Kind::kHolding || may_rest))
      AddFamilyRow(nlp(), entry.requirement, pose, entry.family_limit, torque_nm);
  }

  const problem::LoadSample& LastSampleInUse() const {
    return problem_.profile->samples[problem::SamplesInUse(problem_).back()];
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
      const double standing = RadiansFromDegrees(problem_.standing_deg);
      const PoseStart start = StartAt(problem_, start_, at_range_, std::lerp(standing, at_range_.theta_rad, fraction));
      const int stroke = nlp().AddVariable("d" + name, start.stroke_mm, kShortest_mm, kLongest_mm);
      poses_.push_back(AddPose(nlp(), name, result_.links, stroke, result_.range, fraction, standing, start.phi_rad));
    }
    for (const PoseVariables& pose : poses_) AddNoTurningRow(nlp(), pose);
    const PoseVariables& standing = *std::ranges::find(poses_, kStanding, &PoseVariables::fraction);
    for (const RequirementRow& entry : result_.requirements) {
      if (entry.requirement.id.kind == Kind::kMaxStroke) AddScaledTerm(nlp(), entry.row, standing.stroke, 1);
      if (!entry.requirement.IsFamily() || entry.requirement.along_profile) continue;
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
  const bool is_relative = requirement.id.kind == Kind::kForce || requirement.id.kind == Kind::kHolding ||
                           requirement.id.kind == Kind::kDuration;
  return is_relative ? requirement.limit / 100 : 1;
}

SynthesisProgram BuildProgram(const problem::SynthesisProblem& problem, const linkage::Links& start,
                              const Collocation& poses, Elasticity elasticity, double range_weight) {
  return Builder(problem, start, elasticity, range_weight).Build(poses);
}

}  // namespace lake::synthesis
