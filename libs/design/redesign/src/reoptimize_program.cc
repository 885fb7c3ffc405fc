#include "lake/redesign/reoptimize_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/compare/pointwise_error.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"

namespace lake::redesign {
namespace {

using Goal = ReoptimizeProblem::Goal;
using On = synthesis::LimitId::On;

// Costs that decide only where the goal leaves a choice; each moves the optimum by less than its printed digits.
constexpr double kMisalignmentTie = 1e-5;   // deg (or s) per percent^2
constexpr double kRangeTie = 1e-5;          // percent^2 (or s) per deg
constexpr double kPlacementRidge = 1e-5;    // percent^2 per mm^2, as misalignment counts
constexpr double kDurationTie = 1e-6;       // per s
constexpr double kNearestWeight = 1e-2;     // per mm^2
constexpr double kLeastDistance_mm = 1e-3;  // RMS that a penalty tells from zero, where its root has no derivative
constexpr double kLongest_mm = 1e4, kLongest_s = 1e5;

// v = theta, p_x, p_y. `factor` x the comparison's squared relative error, or squared distance where `shank_mm` is 1.
struct SquaredErrorTerm {
  HumanSample human;
  double shank_mm, factor;
  template <typename T>
  T operator()(const T* v) const {
    return compare::SquaredRelativeError(PredictKnee(human, v[0], v[1], v[2]), human.knee, shank_mm) * factor;
  }
};

struct SquareTerm {
  double factor;
  template <typename T>
  T operator()(const T* v) const {
    return v[0] * v[0] * factor;
  }
};

class Extender {
 public:
  Extender(const ReoptimizeProblem& problem, const ReoptimizePoint& start, ConstantStart constant_start,
           synthesis::SynthesisProgram& synthesis)
      : problem_(problem), start_(start), constant_start_(constant_start), synthesis_(synthesis) {}

  ReoptimizeVariables Extend() {
    variables_.links = synthesis_.links;
    AddKnots();
    AddPlacement();
    AddDuration();
    AddPoses();
    AddMisalignmentLimit();
    AddPenalty();
    AddGoal();
    return std::move(variables_);
  }

 private:
  nlp::NonlinearProgram& nlp() { return synthesis_.program; }
  bool IsFree() const { return problem_.program.kind == linkage::StrokeProgram::Kind::kFree; }
  double MisalignmentWeight() const { return problem_.goal == Goal::kMisalignment ? 1 : kMisalignmentTie; }
  double Standing_rad() const { return RadiansFromDegrees(problem_.design.standing_deg); }

  void AddKnots() {
    const double d_min = problem_.design.d_min_mm;
    for (std::size_t k = 0; k < start_.knots_mm.size(); ++k) {
      const bool fixed = !IsFree() && k == 0 && constant_start_ == ConstantStart::kAtShortestStroke;
      variables_.knots.push_back(nlp().AddVariable(fmt::format("knot {}", k), std::max(d_min, start_.knots_mm[k]),
                                                   d_min, fixed ? d_min : kLongest_mm));
    }
  }

  void AddPlacement() {
    for (int axis = 0; axis < 2; ++axis) {
      const auto [lower, upper] = problem_.PlacementBounds(axis);
      const double start = std::clamp(start_.placement_mm[axis], lower, upper);
      // Clearances have it among the variables already.
      const bool is_there = synthesis_.placement[axis] >= 0;
      variables_.placement[axis] =
          is_there ? synthesis_.placement[axis] : nlp().AddVariable(PlacementName(axis), start, lower, upper);
      if (!problem_.fit_placement) continue;
      const double square = problem_.goal == Goal::kNearest ? kNearestWeight : kPlacementRidge * MisalignmentWeight();
      nlp().AddCost(std::array{variables_.placement[axis]}, SquareTerm{square});
      if (problem_.goal == Goal::kFarthest)
        synthesis::AddScaledTerm(nlp(), nlp::NlpTerm::kCost, variables_.placement[axis], -problem_.farthest[axis]);
      synthesis_.limits.push_back({{On::kPlacement, axis}, "mm", -1, variables_.placement[axis]});
    }
  }

  void AddDuration() {
    const double speed = problem_.program.max_speed_mm_s;
    const double longest = problem_.program.duration_s.value_or(kLongest_s);
    variables_.duration = nlp().AddVariable("duration", start_.duration_s, 0, longest);
    if (problem_.program.duration_s) synthesis_.limits.push_back({{On::kDuration}, "s", -1, variables_.duration});
    const double share = speed / static_cast<double>(variables_.knots.size() - 1);
    const bool may_turn_back = IsFree() && !problem_.program.monotone;
    for (std::size_t k = 1; k < variables_.knots.size(); ++k) {
      AddSpeedRow(k, 1, share);
      AddSpeedRow(k, -1, may_turn_back ? share : 0);
    }
    synthesis::AddScaledTerm(nlp(), nlp::NlpTerm::kCost, variables_.duration,
                             problem_.goal == Goal::kDuration ? 1 : kDurationTie);
  }

  // direction (d_k - d_k-1) <= share T.
  void AddSpeedRow(std::size_t knot, double direction, double share) {
    const int row = nlp().AddRow(fmt::format("speed {:+} at knot {}", direction, knot), -nlp::kUnbounded, 0);
    synthesis::AddScaledTerm(nlp(), row, variables_.knots[knot], direction);
    synthesis::AddScaledTerm(nlp(), row, variables_.knots[knot - 1], -direction);
    if (share > 0) synthesis::AddScaledTerm(nlp(), row, variables_.duration, -share);
  }

  void AddPoses() {
    for (int percent = 0; percent < compare::kPercentSamples; ++percent) {
      const std::string name = fmt::format(" at {} %", percent);
      const KnotSpan span = SpanOf(variables_.knots.size(), percent);
      const auto pose = linkage::SolvePose(start_.links, start_.StrokeAt(percent));
      const double human = problem_.human[percent].knee_rad;
      const auto [lower, upper] = AngleBounds(percent);
      const double theta_start = std::clamp(pose ? pose->theta_rad : human, lower, upper);
      constexpr double kPlausiblePhi_rad = 0.6;
      const double phi_start =
          pose ? pose->phi_rad : std::lerp(std::numbers::pi, kPlausiblePhi_rad, theta_start / std::numbers::pi);
      variables_.theta.push_back(nlp().AddVariable("theta" + name, theta_start, lower, upper));
      synthesis::AddProgramPose(nlp(), name, synthesis_.links,
                                {variables_.knots[span.from], variables_.knots[span.from + 1], span.weight},
                                variables_.theta.back(), phi_start);
    }
  }

  problem::Bounds AngleBounds(int percent) const {
    const double standing = Standing_rad(), human = std::max(standing, problem_.human[percent].knee_rad);
    if (IsFree()) return {standing, std::numbers::pi};
    if (percent == compare::kPercentSamples - 1) return {human, human};
    if (percent == 0) return {constant_start_ == ConstantStart::kAtHumanAngle ? human : standing, human};
    return {standing, std::numbers::pi};
  }

  // `factor` x the mean squared relative error (of L) or squared distance (of 1), as terms of a row or the cost.
  void AddMeanSquare(int row, bool relative, double factor) {
    for (std::size_t i = 0; i < problem_.human.size(); ++i) {
      const HumanSample& human = problem_.human[i];
      nlp().AddTerm(row, std::array{variables_.theta[i], variables_.placement[0], variables_.placement[1]},
                    SquaredErrorTerm{human, relative ? human.shank_mm : 1.0, factor / compare::kPercentSamples});
    }
  }

  void AddMisalignmentLimit() {
    if (!problem_.max_misalignment_percent) return;
    const double limit = *problem_.max_misalignment_percent;
    const int row = nlp().AddRow(fmt::format("misalignment <= {:.6g} %", limit), -nlp::kUnbounded, limit * limit);
    AddMeanSquare(row, true, kPercentSquared);
    // d(limit^2) = 2 limit d(limit): the price is published per percent.
    synthesis_.limits.push_back({{On::kMisalignment}, "%", row, -1, 2 * limit});
  }

  void AddPenalty() {
    if (problem_.penalty_deg_per_mm == 0 || problem_.goal != Goal::kRange) return;
    const auto prediction = PredictPoint(problem_, start_);
    constexpr double kPlausible_mm = 30, kScale_mm2 = 100;
    const double rms = prediction ? prediction->rms_mm : kPlausible_mm;
    const int distance = nlp().AddVariable("rms distance", rms, kLeastDistance_mm, nlp::kUnbounded);
    const int row = nlp().AddRow("rms distance", -nlp::kUnbounded, 0);
    AddMeanSquare(row, false, 1 / kScale_mm2);
    nlp().AddTerm(row, std::array{distance}, SquareTerm{-1 / kScale_mm2});
    synthesis::AddScaledTerm(nlp(), nlp::NlpTerm::kCost, distance, problem_.penalty_deg_per_mm);
  }

  void AddGoal() {
    AddMeanSquare(nlp::NlpTerm::kCost, true, kPercentSquared * MisalignmentWeight());
    if (!problem_.min_range_deg) return;
    const int row = nlp().AddRow(fmt::format("range >= {:.6g} deg", *problem_.min_range_deg), *problem_.min_range_deg,
                                 nlp::kUnbounded);
    synthesis::AddScaledTerm(nlp(), row, synthesis_.range, kDegreesPerRadian);
    synthesis_.limits.push_back({{On::kLeastRange}, "deg", row});
  }

  static constexpr double kPercentSquared = 1e4;

  const ReoptimizeProblem& problem_;
  const ReoptimizePoint& start_;
  const ConstantStart constant_start_;
  synthesis::SynthesisProgram& synthesis_;
  ReoptimizeVariables variables_;
};

}  // namespace

synthesis::SynthesisProgram ReoptimizeBuilder::Build(const synthesis::Collocation& poses) {
  const double range_weight = problem_.goal == Goal::kRange ? 1 : kRangeTie;
  synthesis::SynthesisProgram program = synthesis::BuildProgram(problem_.DesignAt(point_.placement_mm), point_.links,
                                                                poses, synthesis::Elasticity::kNone, range_weight);
  variables_ = Extender(problem_, point_, constant_start_, program).Extend();
  return program;
}

void ReoptimizeBuilder::MoveTo(const std::vector<double>& x) {
  point_.links = synthesis::LinksAt(variables_.links, x);
  point_.knots_mm.clear();
  for (const int knot : variables_.knots) point_.knots_mm.push_back(x[knot]);
  point_.placement_mm = {x[variables_.placement[0]], x[variables_.placement[1]]};
  point_.duration_s = x[variables_.duration];
}

}  // namespace lake::redesign
