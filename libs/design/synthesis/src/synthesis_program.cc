#include "lake/synthesis/synthesis_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/problem/assistance.h"
#include "lake/problem/evaluate.h"

namespace lake::synthesis {
namespace {

using problem::Place;
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
        at_range_(StartAtRange(problem, start)) {
    current_.links = start;
  }

  SynthesisProgram Build(const Collocation& poses) {
    AddLinksAndStroke();
    if (problem_.clearances.AreAsked()) AddPlacement();
    AddShortestPose();
    for (const problem::Requirement& requirement : problem::RequirementsOf(problem_)) AddRequirement(requirement);
    AddShortestRows();
    AddPoses(poses);
    for (const problem::BuildError& error : poses.builds) AddBuild(error, poses);
    if (!IsElastic()) AddGoal();
    return std::move(result_);
  }

 private:
  // What the poses that are added are of: the design as asked for, or a build.
  struct Current {
    linkage::Links links;  // where the program starts
    double d_min_off_mm = 0;
    std::array<double, 6> shift{};
    int range = -1;
    std::string name;
  };

  void AddPoses(const Collocation& poses) {
    AddUsedRange(poses.fractions);
    AddSeated();
    AddProfile(poses.samples);
  }

  // A build's own shortest stroke and range, and everything that poses have to satisfy.
  void AddBuild(const problem::BuildError& error, const Collocation& poses) {
    const problem::SynthesisProblem of_build = problem::ProblemOf(error, problem_);
    current_ = {.links = problem::LinksOf(error, start_),
                .d_min_off_mm = error.back(),
                .name = fmt::format(" of build {}", ++builds_)};
    std::copy_n(error.begin(), current_.shift.size(), current_.shift.begin());
    at_range_ = StartAtRange(of_build, current_.links);
    const std::string& name = current_.name;
    const int stroke = nlp().AddVariable("d_min" + name, of_build.d_min_mm, kShortest_mm, kLongest_mm);
    AddLinearRow(nlp(), "d_min" + name, error.back(), error.back(), {{stroke, 1}, {result_.shortest_stroke, -1}});
    current_.range = nlp().AddVariable("theta" + name, at_range_.theta_rad, -std::numbers::pi, std::numbers::pi);
    poses_ = {AddPose(nlp(), name, result_.links, stroke, current_.range, 1, RadiansFromDegrees(problem_.standing_deg),
                      at_range_.phi_rad, current_.shift)};
    AddLinearRow(nlp(), "range" + name, 0, nlp::kUnbounded, {{current_.range, 1}, {result_.worst_range, -1}});
    AddShortestRows();
    AddPoses(poses);
  }

  // What holds at the shortest stroke of the current build.
  void AddShortestRows() {
    for (const RequirementRow& entry : result_.requirements)
      if (entry.family_limit >= 0 && entry.requirement.Info().place == Place::kShortest)
        AddRows(entry, poses_.front(), problem_.ConstantLoad());
  }

  void AddRows(const RequirementRow& entry, const PoseVariables& pose, problem::PoseLoad load) {
    load.closed_error_mm = current_.d_min_off_mm;
    if (entry.requirement.IsClearance())
      AddClearance(entry, pose);
    else
      AddRatioRows(nlp(), entry.requirement, pose, entry.family_limit, load);
  }

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
    const std::string text = fmt::format("{} {} {} mm", name, is_lower_limit ? "≥" : "≤", SignificantText(limit, 6));
    const int row = AddLinearRow(nlp(), text, is_lower_limit ? limit : -nlp::kUnbounded,
                                 is_lower_limit ? nlp::kUnbounded : limit, {{variable, 1}});
    result_.elastic_bounds.push_back({text, limit, is_lower_limit, AddSlack(row, text, is_lower_limit, 1), row});
  }

  void AddLinksAndStroke() {
    const bool wide = elasticity_ == Elasticity::kEverything;
    std::array<problem::Bounds, 6> bounds = problem_.bounds;
    if (wide) bounds.fill({kShortest_mm, kLongest_mm});
    result_.links = AddLinks(nlp(), bounds, start_);
    const double d = problem_.d_min_mm;
    result_.shortest_stroke = nlp().AddVariable("d_min", d, wide ? kShortest_mm : d, wide ? kLongest_mm : d);
    for (int i = 0; i < 6; ++i) result_.limits.push_back({{LimitId::kLink, i}, "mm", -1, result_.links[i]});
    result_.limits.push_back({{LimitId::kShortestStroke}, "mm", -1, result_.shortest_stroke});
    if (!wide) return;
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      AddElasticBound(result_.links[i], problem::LinkName(i), problem_.bounds[i].lower, true);
      AddElasticBound(result_.links[i], problem::LinkName(i), problem_.bounds[i].upper, false);
    }
    AddElasticBound(result_.shortest_stroke, "d_min", d, true);
    AddElasticBound(result_.shortest_stroke, "d_min", d, false);
  }

  void AddPlacement() {
    const problem::Clearances& clearances = problem_.clearances;
    for (int axis = 0; axis < 2; ++axis) {
      const double start = clearances.placement_mm[axis];
      const double reach = clearances.placement_reach_mm.value_or(0);
      result_.placement[axis] = nlp().AddVariable(axis == 0 ? "placement_x" : "placement_y", start,
                                                  reach > 0 ? -reach : start, reach > 0 ? reach : start);
    }
  }

  void AddShortestPose() {
    result_.range = nlp().AddVariable("theta", at_range_.theta_rad, -std::numbers::pi, std::numbers::pi);
    current_.range = result_.range;
    if (problem_.robust_mm) AddWorstRange();
    poses_.push_back(AddPose(nlp(), "", result_.links, result_.shortest_stroke, result_.range, 1,
                             RadiansFromDegrees(problem_.standing_deg), at_range_.phi_rad));
  }

  void AddWorstRange() {
    result_.worst_range = nlp().AddVariable("worst theta", at_range_.theta_rad, -std::numbers::pi, std::numbers::pi);
    AddLinearRow(nlp(), "range as asked for", 0, nlp::kUnbounded, {{result_.range, 1}, {result_.worst_range, -1}});
  }

  // By how much the worst build is worse in a requirement on the links.
  double Loss(const problem::Requirement& requirement) const {
    double sum = 0;
    for (const double coefficient : requirement.Info().coefficients) sum += std::abs(coefficient);
    return sum * problem_.robust_mm.value_or(0);
  }

  void AddRequirement(const problem::Requirement& requirement) {
    const double limit = requirement.limit + (requirement.IsLinear() ? Loss(requirement) : 0);
    RequirementRow& entry = result_.requirements.emplace_back(RequirementRow{requirement});
    const bool is_on_links = requirement.IsOnLinks();
    // The loop implies it; as a row of its own it would have the loop's gradient and multipliers without bound.
    if (is_on_links && !requirement.IsLinear() && limit == 0 && !problem_.robust_mm && !IsElastic()) return;
    // A limit on poses is a variable of the program, so that its row carries the one multiplier of all poses.
    entry.row =
        nlp().AddRow(requirement.Text(), IsSought(requirement) ? 0 : limit, is_on_links ? nlp::kUnbounded : limit);
    result_.limits.push_back({{requirement.name}, requirement.unit, entry.row});
    if (requirement.IsLinear())
      AddLinearTerm(nlp(), entry.row, result_.links, requirement.Info().coefficients);
    else if (is_on_links)
      AddSingularityTerm(nlp(), entry.row, result_.links, result_.shortest_stroke, problem_.robust_mm.value_or(0));
    if (!is_on_links) {
      const double start = IsSought(requirement) ? StartDuration() : limit;
      entry.family_limit =
          nlp().AddVariable("limit of " + std::string(requirement.name), start, -nlp::kUnbounded, nlp::kUnbounded);
      AddScaledTerm(nlp(), entry.row, entry.family_limit, 1);
    }
    // Angles that the linkage does not reach have no force that could be held against a limit.
    const bool is_reach = requirement.Info().place == Place::kShortest && requirement.is_lower_limit;
    if (IsElastic() && !is_reach)
      entry.slack =
          AddSlack(entry.row, std::string(requirement.name), requirement.is_lower_limit, SlackUnit(requirement));
  }

  // It is what is minimised, and its limit no more than a bound.
  bool IsSought(const problem::Requirement& requirement) const { return requirement.is_sought && !IsElastic(); }

  // The links' own, where they can make the motion at all.
  double StartDuration() const {
    constexpr double kPlausible_s = 20, kLeast_s = 0.1, kMost_s = 600;
    for (const problem::Requirement& requirement : problem::RequirementsOf(problem_)) {
      if (!requirement.is_sought) continue;
      const auto worst = problem::UsedPoses(start_, problem_).WorstPoints(requirement);
      if (!worst.empty() && std::isfinite(worst.front().value))
        return std::clamp(worst.front().value, kLeast_s, kMost_s);
    }
    return kPlausible_s;
  }

  void AddGoal() {
    constexpr double kTie = 1e-6;  // s per deg
    const bool is_duration = problem_.SeeksDuration();
    AddScaledTerm(nlp(), nlp::NlpTerm::kCost, problem_.robust_mm ? result_.worst_range : result_.range,
                  -range_weight_ * (is_duration ? kTie : 1) * kDegreesPerRadian);
    for (const RequirementRow& entry : result_.requirements)
      if (IsSought(entry.requirement)) AddScaledTerm(nlp(), nlp::NlpTerm::kCost, entry.family_limit, 1);
  }

  // Poses at samples of the load profile, whose knee angles are given, with the families that hold there.
  void AddProfile(const std::vector<int>& samples) {
    for (const int i : samples) {
      const problem::LoadSample& sample = problem_.profile->samples[i];
      const std::string name = fmt::format(" at {} %{}", SignificantText(sample.percent, 4), current_.name);
      const PoseStart start = StartOf(sample.knee_rad);
      const int stroke = nlp().AddVariable("d" + name, start.stroke_mm, kShortest_mm, kLongest_mm);
      const PoseVariables pose = AddPose(nlp(), name, result_.links, stroke, current_.range, /*fraction=*/0,
                                         sample.knee_rad, start.phi_rad, current_.shift);
      AddNoTurningRow(nlp(), pose);
      const problem::PoseLoad load = problem_.LoadAt(sample);
      for (const RequirementRow& entry : result_.requirements)
        if (entry.requirement.along_profile && HoldsAt(entry.requirement, sample)) AddRows(entry, pose, load);
    }
  }

  bool HoldsAt(const problem::Requirement& requirement, const problem::LoadSample& sample) const {
    if (requirement.Info().place == Place::kProfile) return true;
    if (problem_.TorqueAt(sample) == 0) return false;
    return requirement.Info().place != Place::kAtRest || problem_.rests_anywhere ||
           &sample == &problem_.profile->samples[problem::SamplesInUse(problem_).back()];
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
      const std::string name = fmt::format(" at {}{}", SignificantText(fraction, 4), current_.name);
      const double standing = RadiansFromDegrees(problem_.standing_deg);
      const PoseStart start = StartOf(std::lerp(standing, at_range_.theta_rad, fraction));
      const int stroke = nlp().AddVariable("d" + name, start.stroke_mm, kShortest_mm, kLongest_mm);
      poses_.push_back(AddPose(nlp(), name, result_.links, stroke, current_.range, fraction, standing, start.phi_rad,
                               current_.shift));
    }
    for (const PoseVariables& pose : poses_) AddNoTurningRow(nlp(), pose);
    const PoseVariables& standing = *std::ranges::find(poses_, kStanding, &PoseVariables::fraction);
    for (const RequirementRow& entry : result_.requirements) {
      const problem::Requirement& requirement = entry.requirement;
      if (requirement.Info().place == Place::kStanding) AddRows(entry, standing, problem_.ConstantLoad());
      if (!requirement.IsFamily() || requirement.along_profile || requirement.Info().place == Place::kSeated) continue;
      for (const PoseVariables& pose : poses_) AddRows(entry, pose, problem_.ConstantLoad());
    }
  }

  // On the linkage that the current poses are of.
  PoseStart StartOf(double theta_rad) const {
    problem::SynthesisProblem of_build = problem_;
    of_build.d_min_mm += current_.d_min_off_mm;
    return StartAt(of_build, current_.links, at_range_, theta_rad);
  }

  void AddClearance(const RequirementRow& entry, const PoseVariables& pose) {
    const problem::Obstacle obstacle = entry.requirement.Info().obstacle;
    const person::Body body = person::BodyOf(problem_.clearances.body);
    const linkage::WearOptions wear = problem_.Wear();
    if (obstacle == problem::Obstacle::kSeat)
      AddSeatRows(nlp(), At(pose, entry), linkage::SeatOf(body, wear), wear);
    else
      AddLimbRows(nlp(), At(pose, entry),
                  obstacle == problem::Obstacle::kThigh ? linkage::Limb::kThigh : linkage::Limb::kShank, body, wear);
  }

  // The pose of sitting, with what holds there.
  void AddSeated() {
    const auto is_seated = [](const RequirementRow& row) { return row.requirement.Info().place == Place::kSeated; };
    if (std::ranges::none_of(result_.requirements, is_seated)) return;
    const double seated = problem_.SeatedAngle_rad();
    const PoseStart start = StartOf(seated);
    const std::string name = " seated" + current_.name;
    const int stroke = nlp().AddVariable("d" + name, start.stroke_mm, kShortest_mm, kLongest_mm);
    const PoseVariables pose = AddPose(nlp(), name, result_.links, stroke, current_.range, /*fraction=*/0, seated,
                                       start.phi_rad, current_.shift);
    AddNoTurningRow(nlp(), pose);
    for (const RequirementRow& entry : result_.requirements)
      if (is_seated(entry)) AddRows(entry, pose, problem_.ConstantLoad());
  }

  // The pose as the program starts, on the body.
  ClearancePose At(const PoseVariables& pose, const RequirementRow& entry) const {
    const auto start_of = [&](int variable) { return result_.program.Variables()[variable].start; };
    const double phi = start_of(pose.phi);
    linkage::Pose start;
    start.theta_rad = std::lerp(pose.standing_rad, start_of(pose.range), pose.fraction);
    start.knee = {0, 0};
    start.thigh_pin = {0, current_.links.l3};
    start.tip = start.thigh_pin + current_.links.l2 * Eigen::Vector2d(std::sin(phi), std::cos(phi));
    start.shank_pin = current_.links.l4 * Eigen::Vector2d(std::sin(start.theta_rad), -std::cos(start.theta_rad));
    start.mount = start.thigh_pin + Eigen::Vector2d(current_.links.l5, current_.links.l6);
    return {pose, entry.family_limit, result_.placement, linkage::PutOnBody(start, problem_.clearances.placement_mm)};
  }

  const problem::SynthesisProblem& problem_;
  const linkage::Links start_;
  const Elasticity elasticity_;
  const double range_weight_;
  PoseStart at_range_;  // of what the current poses are of
  Current current_;
  int builds_ = 0;
  SynthesisProgram result_;
  std::vector<PoseVariables> poses_;
};

}  // namespace

const Limit* SynthesisProgram::Find(const LimitId& id) const {
  const auto found = std::ranges::find(limits, id, &Limit::id);
  return found == limits.end() ? nullptr : &*found;
}

problem::SynthesisProblem Placed(problem::SynthesisProblem problem, const SynthesisProgram& program,
                                 const std::vector<double>& x) {
  if (program.placement[0] < 0) return problem;
  for (int axis = 0; axis < 2; ++axis) problem.clearances.placement_mm[axis] = x[program.placement[axis]];
  return problem;
}

double SlackUnit(const problem::Requirement& requirement) {
  return requirement.Info().is_relative ? requirement.limit / 100 : 1;
}

SynthesisProgram BuildProgram(const problem::SynthesisProblem& problem, const linkage::Links& start,
                              const Collocation& poses, Elasticity elasticity, double range_weight) {
  return Builder(problem, start, elasticity, range_weight).Build(poses);
}

}  // namespace lake::synthesis
