#include "lake/redesign/redesign_problem.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/cuffs/cuff_course.h"
#include "lake/problem/problem_file.h"

namespace lake::redesign {
namespace {

using Kind = linkage::StrokeProgram::Kind;

void CheckPositive(double value, const char* option, const char* unit) {
  if (!(std::isfinite(value) && value > 0)) throw UsageError("--{} {}: a number of {} above 0", option, value, unit);
}

// The strokes of a linkage that nobody can assemble: those of the paper's designs.
std::vector<double> PlausibleStrokes(const RedesignProblem& problem) {
  constexpr double kPlausibleSlope_mm = 80;  // per rad
  std::vector<double> strokes;
  for (const HumanSample& sample : problem.human)
    strokes.push_back(problem.design.d_min_mm +
                      kPlausibleSlope_mm * std::max(0.0, problem.human.front().knee_rad - sample.knee_rad));
  return strokes;
}

}  // namespace

void Describe(ProgramLimits& o, OptionList& options) {
  options.AddChoice("program", o.kind, OptionList::Choices<Kind>{{"constant", Kind::kConstant}, {"free", Kind::kFree}},
                    "Stroke program: constant (one speed) or free; of walking always free");
  options.Add("max-speed", o.max_speed_mm_s, "Speed of the actuator").Unit("mm/s").Positive();
  options.Add("duration", o.duration_s, "Longest duration of a rise, or of a stride")
      .Unit("s")
      .Positive()
      .Otherwise("no limit; of walking the person's stride");
  options.Add("free-ends", o.free_ends, "The ends of a constant program's stroke are sought too");
  options.Add("monotone", o.monotone, "A free program must not reverse");
  options.Add("knots", o.knots, "Number of knots of a free program");
}

RedesignProblem WithLinks(RedesignProblem problem, const linkage::Links& links) {
  constexpr double kSameLinks_mm = 0.01;
  for (std::size_t i = 0; i < 6; ++i) {
    problem::Bounds& bounds = problem.design.bounds[i];
    const double length = links.Values()[i];
    bounds = {std::max(bounds.lower, length - kSameLinks_mm), std::min(bounds.upper, length + kSameLinks_mm)};
  }
  return problem;
}

const char* PlacementName(int axis) {
  return axis == 0 ? "placement_x" : "placement_y";
}

std::string ProgramName(Kind kind) {
  return kind == Kind::kFree ? "free" : "constant";
}

problem::Bounds RedesignProblem::PlacementBounds(int axis) const {
  if (!fit_placement) return {placement_mm[axis], placement_mm[axis]};
  return {-placement_reach_mm, placement_reach_mm};
}

problem::SynthesisProblem RedesignProblem::DesignAt(const Eigen::Vector2d& placement) const {
  problem::SynthesisProblem placed = design;
  for (int axis = 0; axis < 2; ++axis) {
    const auto [lower, upper] = PlacementBounds(axis);
    placed.clearances.placement_mm[axis] = std::clamp(placement[axis], lower, upper);
  }
  placed.clearances.placement_reach_mm = fit_placement ? std::optional(placement_reach_mm) : std::nullopt;
  return placed;
}

void RedesignProblem::CheckOptions() const {
  CheckPositive(program.max_speed_mm_s, "max-speed", "mm/s");
  constexpr int kFewestKnots = 21;
  if (program.knots < kFewestKnots || program.knots > compare::kPercentSamples)
    throw UsageError("--knots {}: {} to {}", program.knots, kFewestKnots, compare::kPercentSamples);
  if (program.free_ends && program.kind == Kind::kFree)
    throw UsageError("--free-ends is for a constant program: a free one has ends of its own; omit it");
  CheckPositive(placement_reach_mm, "placement-reach", "mm");
  for (const Quantity& quantity : kQuantities) {
    if (const auto& limit = quantity.limit(*this); limit && !quantity.is_lower)
      CheckPositive(*limit, quantity.option, quantity.option_unit);
    if (quantity.weight && !(std::isfinite(this->*quantity.weight) && this->*quantity.weight >= 0))
      throw UsageError("--{} {}: a number, 0 or above", quantity.weight_option, this->*quantity.weight);
  }
  if (!balance_mm) return;
  if (!body)
    throw UsageError("--balance needs the person's body: give --body loads.json, which lake loads writes of the trial");
  const double room_mm = kMmPerM * body->body.sole.Length() / 2;
  if (!(*balance_mm >= 0 && *balance_mm < room_mm))
    throw UsageError("--balance {}: 0 to less than half the foot, {} mm", *balance_mm, SignificantText(room_mm, 4));
}

void RedesignProblem::Check() const {
  CheckOptions();
  design.Check();
  if (human.size() > compare::kPercentSamples || human.size() < static_cast<std::size_t>(program.knots))
    throw Fail("the human's motion has {} samples: {} to {} are needed", human.size(), program.knots,
               compare::kPercentSamples);
}

GroupProblem GroupProblem::OfOne(const RedesignProblem& problem) {
  return {problem, {{"", problem.human, problem.placement_mm}}};
}

RedesignProblem GroupProblem::Of(std::size_t person) const {
  RedesignProblem problem = shared;
  problem.human = people.at(person).human;
  problem.placement_mm = people[person].placement_mm;
  return problem;
}

std::size_t GroupProblem::Counting() const {
  if (across != Across::kQuantile) return people.size();
  constexpr double kRounding = 1e-9;  // 0.9 of 10 people are 9
  return static_cast<std::size_t>(std::ceil(quantile * static_cast<double>(people.size()) - kRounding));
}

double GroupProblem::Combine(const std::vector<double>& of_people) const {
  if (across == Across::kMean) return Mean(of_people);
  double largest = -kInfinity;
  for (std::size_t i = 0; i < of_people.size(); ++i)
    if (people[i].counts) largest = std::max(largest, of_people[i]);
  return largest;
}

void GroupProblem::CheckOptions() const {
  shared.CheckOptions();
  if (!(quantile > 0 && quantile <= 1)) throw UsageError("--quantile {}: above 0, at most 1", quantile);
}

void GroupProblem::Check() const {
  CheckOptions();
  if (people.empty()) throw Fail("a design for a group needs at least one person");
  if (people.size() > 1 && shared.design.clearances.AreAsked())
    throw Fail("clearances are from one person's body; omit them in a design for {} people", people.size());
  for (std::size_t i = 0; i < people.size(); ++i) Of(i).Check();
}

void to_json(nlohmann::json& json, const RedesignPoint& point) {
  json = {{"links", point.links.Values()},
          {"knots_mm", point.knots_mm},
          {"placement_mm", {point.placement_mm.x(), point.placement_mm.y()}},
          {"duration_s", point.duration_s},
          {"leg_lean_rad", point.lean.leg_rad},
          {"trunk_lean_rad", point.lean.trunk_rad}};
}

void from_json(const nlohmann::json& json, RedesignPoint& point) {
  point.links = linkage::Links::FromValues(json.at("links").get<std::array<double, 6>>());
  json.at("knots_mm").get_to(point.knots_mm);
  point.placement_mm = {json.at("placement_mm").at(0).get<double>(), json.at("placement_mm").at(1).get<double>()};
  json.at("duration_s").get_to(point.duration_s);
  json.at("leg_lean_rad").get_to(point.lean.leg_rad);
  json.at("trunk_lean_rad").get_to(point.lean.trunk_rad);
}

KnotSpan SpanOf(std::size_t knots, double percent) {
  const double place = percent / 100 * static_cast<double>(knots - 1);
  const std::size_t from = std::min(static_cast<std::size_t>(place), knots - 2);
  return {from, place - static_cast<double>(from)};
}

double RedesignPoint::StrokeAt(double percent) const {
  const KnotSpan span = SpanOf(knots_mm.size(), percent);
  return std::lerp(knots_mm[span.from], knots_mm[span.from + 1], span.weight);
}

RedesignPoint StartPoint(const RedesignProblem& problem, const linkage::Links& links) {
  RedesignPoint point{
      .links = links, .knots_mm = {}, .placement_mm = problem.placement_mm, .duration_s = 0, .lean = {}};
  const auto tracking = TrackingStrokes(problem.Driven(links), problem.human);
  const std::vector<double> strokes = tracking ? *tracking : PlausibleStrokes(problem);
  const int knots = problem.program.kind == Kind::kFree ? problem.program.knots : 2;
  for (int k = 0; k < knots; ++k)
    point.knots_mm.push_back(
        strokes[static_cast<std::size_t>(std::lround(static_cast<double>(strokes.size() - 1) * k / (knots - 1)))]);
  point.duration_s = TrackingTime(point.knots_mm, problem.program.max_speed_mm_s);
  if (problem.program.duration_s) point.duration_s = std::min(point.duration_s, *problem.program.duration_s);
  return point;
}

double DurationOf(const RedesignProblem& problem, const RedesignPoint& point) {
  const double needed_s = TrackingTime(point.knots_mm, problem.program.max_speed_mm_s);
  if (problem.program.cyclic) return std::max(needed_s, problem.program.duration_s.value_or(0));
  return problem.balance_mm && problem.program.kind == Kind::kFree ? std::max(needed_s, point.duration_s) : needed_s;
}

linkage::Design DesignOf(const RedesignProblem& problem, const RedesignPoint& point) {
  linkage::Design design = problem::DesignOf(problem.design, point.links);
  design.placement_mm = {point.placement_mm.x(), point.placement_mm.y()};
  linkage::StrokeProgram program;
  program.kind = problem.program.free_ends ? Kind::kFree : problem.program.kind;
  program.speed_mm_s = problem.program.max_speed_mm_s;
  const double duration_s = DurationOf(problem, point);
  if (program.kind == Kind::kFree)
    for (std::size_t k = 0; k < point.knots_mm.size(); ++k)
      program.knots.push_back(
          {duration_s * static_cast<double>(k) / static_cast<double>(point.knots_mm.size() - 1), point.knots_mm[k]});
  design.program = program;
  return design;
}

void Complete(const RedesignProblem& problem, const Eigen::Vector2d& placement_mm, const Lean& lean, double duration_s,
              Prediction& prediction) {
  const std::vector<double>& theta_rad = prediction.theta_rad;
  prediction.of = problem.misalignment_of;
  prediction.exo.duration_s = duration_s;
  const Eigen::Vector2d place_mm = placement_mm + problem.human.back().slip_mm;
  double largest_mm = 0;
  for (const double theta : theta_rad)
    for (const auto& [x, y] : cuffs::SlipsOf(problem.cuffs, theta, theta_rad.back(), place_mm.x(), place_mm.y()))
      largest_mm = LargerOrNaN(largest_mm, std::hypot(x, y));
  prediction.cuff_force_n = problem.cuffs.stiffest_n_mm * largest_mm;
  if (problem.body && duration_s > 0)
    prediction.balance = FindBalance(problem.human, *problem.body, theta_rad, lean, duration_s);
}

std::optional<Prediction> PredictPoint(const RedesignProblem& problem, const RedesignPoint& point) {
  std::vector<double> strokes;
  for (std::size_t i = 0; i < problem.human.size(); ++i) strokes.push_back(point.StrokeAt(PercentOf(i, problem.human)));
  auto prediction =
      Predict(problem.Driven(point.links), point.placement_mm, strokes, Leaning(problem.human, point.lean.leg_rad));
  if (!prediction) return std::nullopt;
  Complete(problem, point.placement_mm, point.lean, DurationOf(problem, point), *prediction);
  return prediction;
}

}  // namespace lake::redesign
