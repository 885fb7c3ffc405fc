#include "lake/redesign/redesign_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "lake/compare/pointwise_error.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/cuffs/cuff_course.h"

namespace lake::redesign {
namespace {

using Goal = RedesignProblem::Goal;

// Costs that decide only where the goal leaves a choice; each moves the optimum by less than its printed digits.
constexpr double kMisalignmentTie = 1e-5;   // deg (or s) per percent^2
constexpr double kRangeTie = 1e-5;          // percent^2 (or s) per deg
constexpr double kPlacementRidge = 1e-5;    // percent^2 per mm^2, as misalignment counts
constexpr double kDurationTie = 1e-6;       // per s
constexpr double kNearestWeight = 1e-2;     // per mm^2
constexpr double kLeastDistance_mm = 1e-3;  // RMS that a penalty takes as above zero, where its root has no derivative
constexpr double kLeanTie = 1e-5;           // per deg^2 of mean square
constexpr double kLeanBend = 1e-2;          // per deg^2 of each second difference of a lean: it changes smoothly
constexpr double kLongest_mm = 1e4, kLongest_s = 1e5, kShortest_s = 0.3;

// factor x v^2
auto SquareTerm(double factor) {
  return [factor](const auto* v) { return v[0] * v[0] * factor; };
}

// What one person adds.
class PersonExtender {
 public:
  // `weight` of the misalignment in the cost.
  PersonExtender(const RedesignProblem& problem, const RedesignPoint& start, ConstantStart constant_start,
                 std::size_t person, const std::string& name, double weight, synthesis::SynthesisProgram& synthesis)
      : problem_(problem),
        start_(start),
        constant_start_(constant_start),
        person_(static_cast<int>(person)),
        prefix_(name.empty() ? "" : name + ": "),
        whose_(name.empty() ? "" : " of " + name),
        weight_(weight),
        synthesis_(synthesis) {}

  void Extend() {
    variables_.links = synthesis_.links;
    AddKnots();
    AddPlacement();
    AddDuration();
    AddPoses();
    if (IsIn(kAngleMismatch)) AddAngleMismatch();
    if (IsIn(kCuffForce)) AddCuffForce();
    if (problem_.balance_mm) AddBalance();
  }

  // `factor` x the mean squared misalignment (of L) or squared distance (of 1), as terms of a row or the cost.
  void AddMeanSquare(int row, bool relative, double factor) {
    const auto [x, y] = variables_.placement;
    const double share = factor / static_cast<double>(problem_.human.size());
    for (std::size_t i = 0; i < problem_.human.size(); ++i) {
      const HumanSample& human = problem_.human[i];
      const double shank_mm = relative ? human.shank_mm : 1.0;
      const auto error = [human, shank_mm, share](const auto* v, const auto& sin_lean, const auto& cos_lean) {
        const auto knee = PredictKnee(human, sin_lean, cos_lean, v[0], v[1], v[2]);
        return compare::SquaredMisalignment(knee, human.knee, shank_mm) * share;
      };
      if (problem_.misalignment_of == MisalignmentOf::kJoint)  // |p + delta|^2
        nlp().AddTerm(row, std::array{x, y},
                      [slip_mm = human.slip_mm, scale = share / (shank_mm * shank_mm)](const auto* v) {
                        const auto off_x = v[0] + slip_mm.x(), off_y = v[1] + slip_mm.y();
                        return (off_x * off_x + off_y * off_y) * scale;
                      });
      else if (problem_.balance_mm)
        nlp().AddTerm(row, std::array{variables_.theta[i], x, y, variables_.leg_lean[i]},
                      [error, of_human = LeanOf(human)](const auto* v) {
                        using std::cos, std::sin;
                        const auto lean = v[3] + of_human;
                        return error(v, sin(lean), cos(lean));
                      });
      else
        nlp().AddTerm(row, std::array{variables_.theta[i], x, y},
                      [error, human](const auto* v) { return error(v, human.sin_lean, human.cos_lean); });
    }
  }

  // At the start; nullopt where the linkage cannot make the motion.
  std::optional<Prediction> Predicted() const { return PredictPoint(problem_, start_); }
  std::string Named(const std::string& name) const { return prefix_ + name; }
  int Person() const { return person_; }
  RedesignVariables& Variables() { return variables_; }

 private:
  nlp::NonlinearProgram& nlp() { return synthesis_.program; }
  bool IsSought(const Quantity& quantity) const { return problem_.goal == quantity.goal; }
  double WeightOf(const Quantity& quantity) const {
    if (IsSought(quantity)) return 1;
    return problem_.goal == Goal::kRange && quantity.weight ? problem_.*quantity.weight : 0;
  }
  bool IsIn(const Quantity& quantity) const { return quantity.limit(problem_) || WeightOf(quantity) > 0; }

  // The worst value of a quantity is a variable, so that its bound has a multiplier. `tie`: its cost where it is not
  // sought.
  int AddWorst(const Quantity& quantity, double start, problem::Bounds bounds, double tie = 0) {
    const std::optional<double> limit = IsSought(quantity) ? std::nullopt : quantity.limit(problem_);
    if (limit) (quantity.is_lower ? bounds.lower : bounds.upper) = *limit;
    bounds.lower = std::min(bounds.lower, bounds.upper);
    const std::string name(quantity.name);
    const int worst =
        nlp().AddVariable(Named(name), std::clamp(start, bounds.lower, bounds.upper), bounds.lower, bounds.upper);
    const double weight = WeightOf(quantity), cost = weight > 0 ? weight : tie;
    if (cost > 0) synthesis::AddScaledTerm(nlp(), nlp::NlpTerm::kCost, worst, -quantity.Merit(cost));
    if (limit) synthesis_.limits.push_back({{quantity.name, person_}, quantity.unit, -1, worst});
    return worst;
  }

  bool IsFree() const { return problem_.program.kind == linkage::StrokeProgram::Kind::kFree; }
  double Standing_rad() const { return RadiansFromDegrees(problem_.design.standing_deg); }

  void AddKnots() {
    const double d_min = problem_.design.d_min_mm;
    for (std::size_t k = 0; k < start_.knots_mm.size(); ++k) {
      const bool fixed = !IsFree() && k == 0 && constant_start_ == ConstantStart::kAtShortestStroke;
      variables_.knots.push_back(nlp().AddVariable(
          Named(fmt::format("knot {}", k)), std::max(d_min, start_.knots_mm[k]), d_min, fixed ? d_min : kLongest_mm));
    }
  }

  void AddPlacement() {
    for (int axis = 0; axis < 2; ++axis) {
      const auto [lower, upper] = problem_.PlacementBounds(axis);
      const double start = std::clamp(start_.placement_mm[axis], lower, upper);
      // Clearances have it among the variables already.
      const bool is_there = synthesis_.placement[axis] >= 0;
      variables_.placement[axis] =
          is_there ? synthesis_.placement[axis] : nlp().AddVariable(Named(PlacementName(axis)), start, lower, upper);
      if (!problem_.fit_placement) continue;
      const double square = problem_.goal == Goal::kNearest ? kNearestWeight : kPlacementRidge * weight_;
      nlp().AddCost(std::array{variables_.placement[axis]}, SquareTerm(square));
      if (problem_.goal == Goal::kFarthest)
        synthesis::AddScaledTerm(nlp(), nlp::NlpTerm::kCost, variables_.placement[axis], -problem_.farthest[axis]);
      synthesis_.limits.push_back({{PlacementName(axis), person_}, "mm", -1, variables_.placement[axis]});
    }
  }

  void AddDuration() {
    const double speed = problem_.program.max_speed_mm_s;
    const double shortest = problem_.balance_mm ? kShortest_s : 0;
    variables_.duration = AddWorst(kDuration, start_.duration_s, {shortest, kLongest_s}, kDurationTie);
    const double share = speed / static_cast<double>(variables_.knots.size() - 1);
    const bool may_turn_back = IsFree() && !problem_.program.monotone;
    for (std::size_t k = 1; k < variables_.knots.size(); ++k) {
      // At one speed the duration is what the stroke takes, and balance depends on it.
      AddSpeedRow(k, 1, share, problem_.balance_mm && !IsFree() ? 0 : -nlp::kUnbounded);
      AddSpeedRow(k, -1, may_turn_back ? share : 0);
    }
    if (problem_.program.cyclic)
      synthesis::AddLinearRow(nlp(), Named("end at the beginning"), 0, 0,
                              {{variables_.knots.front(), 1}, {variables_.knots.back(), -1}});
  }

  // direction (d_k - d_k-1) <= share T.
  void AddSpeedRow(std::size_t knot, double direction, double share, double least = -nlp::kUnbounded) {
    const int row = nlp().AddRow(Named(fmt::format("speed {:+} at knot {}", direction, knot)), least, 0);
    synthesis::AddScaledTerm(nlp(), row, variables_.knots[knot], direction);
    synthesis::AddScaledTerm(nlp(), row, variables_.knots[knot - 1], -direction);
    if (share > 0) synthesis::AddScaledTerm(nlp(), row, variables_.duration, -share);
  }

  void AddPoses() {
    for (std::size_t i = 0; i < problem_.human.size(); ++i) {
      const double percent = PercentOf(i, problem_.human);
      const std::string place = fmt::format(" at {:g} %", percent);
      const KnotSpan span = SpanOf(variables_.knots.size(), percent);
      const auto pose = linkage::SolvePose(start_.links, start_.StrokeAt(percent));
      const double human = problem_.human[i].knee_rad;
      const auto [lower, upper] = AngleBounds(i);
      const double theta_start = std::clamp(pose ? pose->theta_rad : human, lower, upper);
      constexpr double kPlausiblePhi_rad = 0.6;
      const double phi_start =
          pose ? pose->phi_rad : std::lerp(std::numbers::pi, kPlausiblePhi_rad, theta_start / std::numbers::pi);
      variables_.theta.push_back(nlp().AddVariable(Named("theta" + place), theta_start, lower, upper));
      synthesis::AddProgramPose(nlp(), place + whose_, synthesis_.links,
                                {variables_.knots[span.from], variables_.knots[span.from + 1], span.weight},
                                variables_.theta.back(), phi_start);
    }
  }

  void AddAngleMismatch() {
    constexpr double kFarthest_deg = 180;
    const double most_deg = IsSought(kAngleMismatch) ? kFarthest_deg : *problem_.max_angle_mismatch_deg;
    const int largest = AddWorst(kAngleMismatch, most_deg / 2, {0, kFarthest_deg});
    for (std::size_t i = 0; i < problem_.human.size(); ++i) {
      const double human_deg = DegreesFromRadians(problem_.human[i].knee_rad);
      for (const double side : {1.0, -1.0})
        synthesis::AddLinearRow(
            nlp(), Named(fmt::format("angle mismatch {:+} at {:g} %", side, PercentOf(i, problem_.human))),
            -nlp::kUnbounded, side * human_deg, {{variables_.theta[i], side * kDegreesPerRadian}, {largest, -1}});
    }
  }

  // At standing the cuffs are free of stress.
  void AddCuffForce() {
    constexpr double kMost_n = 1e5, kLeast_n = 1e-3, kScale_n2 = 100, kPlausible_n = 30;
    const auto predicted = Predicted();
    const int largest = AddWorst(kCuffForce, predicted ? predicted->cuff_force_n : kPlausible_n, {kLeast_n, kMost_n});
    const double stiff = problem_.cuffs.stiffest_n_mm;
    const auto [x, y] = variables_.placement;
    const std::vector<cuffs::PlacedCuff> placed = cuffs::CuffsOf(problem_.cuffs);
    for (std::size_t i = 0; i + 1 < problem_.human.size(); ++i)
      for (std::size_t k = 0; k < placed.size(); ++k) {
        const int row = nlp().AddRow(Named(fmt::format("force of {} cuff {} at {:g} %", placed[k].Segment(),
                                                       placed[k].number + 1, PercentOf(i, problem_.human))),
                                     -nlp::kUnbounded, 0);
        nlp().AddTerm(row, std::array{variables_.theta[i], variables_.theta.back(), x, y},
                      [cuffs = problem_.cuffs, k, slip_mm = problem_.human.back().slip_mm,
                       factor = stiff * stiff / kScale_n2]<typename T>(const T* v) {
                        const T at_x = v[2] + slip_mm.x(), at_y = v[3] + slip_mm.y();
                        const auto [slip_x, slip_y] = cuffs::SlipsOf(cuffs, v[0], v[1], at_x, at_y)[k];
                        return T((slip_x * slip_x + slip_y * slip_y) * factor);
                      });
        nlp().AddTerm(row, std::array{largest}, SquareTerm(-1 / kScale_n2));
      }
  }

  void AddBalance() {
    variables_.margin = AddWorst(kBalanceMargin, *problem_.balance_mm, {-kLongest_mm, kLongest_mm});
    variables_.leg_lean = AddLean("lean of the leg", problem_.lean_limits.leg_deg, start_.lean.leg_rad);
    variables_.trunk_lean = AddLean("lean of the trunk", problem_.lean_limits.trunk_deg, start_.lean.trunk_rad);
    const std::size_t first = FirstOnFeet(problem_.human, *problem_.body);
    for (std::size_t i = 0; i < first; ++i)
      nlp().AddConstraint(Named(fmt::format("hip on the seat at {:g} %", PercentOf(i, problem_.human))), -kSeatGives_mm,
                          kSeatGives_mm, std::array{variables_.theta[i], variables_.leg_lean[i]},
                          [human = problem_.human[i]](const auto* v) {
                            return HipHeight(human, v[0], v[1]) - HipHeight(human, human.knee_rad, 0.0);
                          });
    for (std::size_t i = first; i < problem_.human.size(); ++i) AddPressure(i);
  }

  // One angle per sample, near the person's own.
  std::vector<int> AddLean(const char* what, double most_deg, const std::vector<double>& start_rad) {
    constexpr double kSquareDegrees = kDegreesPerRadian * kDegreesPerRadian;
    const double most_rad = RadiansFromDegrees(most_deg);
    std::vector<int> leans;
    for (std::size_t i = 0; i < problem_.human.size(); ++i) {
      const std::string name = fmt::format("{} at {:g} %", what, PercentOf(i, problem_.human));
      leans.push_back(nlp().AddVariable(Named(name), start_rad.empty() ? 0 : start_rad[i], -most_rad, most_rad));
      nlp().AddCost(std::array{leans.back()},
                    SquareTerm(kLeanTie * kSquareDegrees / static_cast<double>(problem_.human.size())));
      if (i >= 2)
        nlp().AddCost(std::array{leans[i - 2], leans[i - 1], leans[i]}, [](const auto* v) {
          const auto bend = v[0] + v[2] - v[1] * 2.0;
          return bend * bend * (kLeanBend * kSquareDegrees);
        });
    }
    return leans;
  }

  // The centre of pressure at a sample, and that it is inside the foot by the margin.
  void AddPressure(std::size_t sample) {
    const loads::Foot& foot = problem_.body->body.sole;
    const std::string place = fmt::format(" at {:g} %", PercentOf(sample, problem_.human));
    const double heel_mm = -kMmPerM * foot.heel_m, toe_mm = kMmPerM * foot.toe_m;
    const int pressure = nlp().AddVariable(Named("centre of pressure" + place), std::midpoint(heel_mm, toe_mm),
                                           -kLongest_mm, kLongest_mm);
    const std::size_t last = problem_.human.size() - 1, reach = BalanceReach(problem_.human);
    const std::array at = {sample - std::min(sample, reach), sample, std::min(sample + reach, last)};
    const std::array human = {problem_.human[at[0]], problem_.human[at[1]], problem_.human[at[2]]};
    const double step = static_cast<double>(reach) / static_cast<double>(last);  // between them, of the rise
    // v = duration, centre of pressure in mm, then theta and the leans of leg and trunk of the sample before, the
    // sample and, unless the body stays there, the sample after. 0 where the ground's force acts at that centre; mm.
    const auto off = [body = problem_.body, human, at, step, stays = sample == last](const auto* v) {
      const auto pose = [&](std::size_t i) {
        const auto* w = v + 2 + 3 * (stays ? std::min<std::size_t>(i, 1) : i);
        return PoseOf(human[i], body->trunk[at[i]], body->body, w[0], w[1], w[2]);
      };
      const std::array poses = {pose(0), pose(1), pose(2)};
      const auto ground = loads::FindGroundSupport(poses, v[0] * step, *body);
      const double weight_n = loads::kGravity_m_s2 * (body->body.foot.mass_kg + body->body.shank.mass_kg +
                                                      body->body.thigh.mass_kg + body->body.trunk.mass_kg);
      return (ground.moment_nm * kMmPerM - ground.force_n * v[1]) / weight_n;
    };
    const int row = nlp().AddRow(Named("ground" + place), 0, 0);
    const auto of = [&](std::size_t k) {
      return std::array{variables_.theta[at[k]], variables_.leg_lean[at[k]], variables_.trunk_lean[at[k]]};
    };
    const auto [a, b, c] = std::array{of(0), of(1), of(2)};
    const int duration = variables_.duration;
    if (sample == last)
      nlp().AddTerm(row, std::array{duration, pressure, a[0], a[1], a[2], b[0], b[1], b[2]}, off);
    else
      nlp().AddTerm(row, std::array{duration, pressure, a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]}, off);
    synthesis::AddLinearRow(nlp(), Named("before the heel" + place), heel_mm, nlp::kUnbounded,
                            {{pressure, 1}, {variables_.margin, -1}});
    synthesis::AddLinearRow(nlp(), Named("behind the toe" + place), -nlp::kUnbounded, toe_mm,
                            {{pressure, 1}, {variables_.margin, 1}});
  }

  problem::Bounds AngleBounds(std::size_t sample) const {
    const double standing = Standing_rad(), human = std::max(standing, problem_.human[sample].knee_rad);
    if (IsFree() || problem_.program.free_ends) return {standing, std::numbers::pi};
    if (sample + 1 == problem_.human.size()) return {human, human};
    if (sample == 0) return {constant_start_ == ConstantStart::kAtHumanAngle ? human : standing, human};
    return {standing, std::numbers::pi};
  }

  const RedesignProblem& problem_;
  const RedesignPoint& start_;
  const ConstantStart constant_start_;
  const int person_;
  const std::string prefix_, whose_;
  const double weight_;
  synthesis::SynthesisProgram& synthesis_;
  RedesignVariables variables_;
};

// What holds of all: limit, penalty and goal.
class GroupExtender {
 public:
  GroupExtender(const GroupProblem& problem, std::vector<PersonExtender>& people,
                synthesis::SynthesisProgram& synthesis)
      : problem_(problem), shared_(problem.shared), people_(people), synthesis_(synthesis) {}

  void Extend() {
    for (PersonExtender& person : people_) person.Extend();
    AddMisalignmentLimit();
    AddPenalty();
    AddGoal();
  }

  static double MisalignmentWeight(const GroupProblem& problem) {
    return problem.shared.goal == Goal::kMisalignment && problem.people.size() == 1 ? 1 : kMisalignmentTie;
  }

 private:
  nlp::NonlinearProgram& nlp() { return synthesis_.program; }
  bool IsMean() const { return problem_.across == Across::kMean && people_.size() > 1; }

  void AddMisalignmentLimit() {
    if (!shared_.max_misalignment_percent) return;
    const double limit = *shared_.max_misalignment_percent;
    const std::string text = fmt::format("misalignment ≤ {} %", SignificantText(limit, 6));
    if (IsMean()) {
      const int row = nlp().AddRow("mean " + text, -nlp::kUnbounded, limit);
      for (const int root : Roots())
        synthesis::AddScaledTerm(nlp(), row, root, 1 / static_cast<double>(people_.size()));
      synthesis_.limits.push_back({{kMisalignment.name}, kMisalignment.unit, row});
      return;
    }
    for (PersonExtender& person : people_) {
      if (!Counts(person)) continue;
      const int row = nlp().AddRow(person.Named(text), -nlp::kUnbounded, limit * limit);
      person.AddMeanSquare(row, true, kPercentSquared);
      person.Variables().misalignment_row = row;
      // d(limit^2) = 2 limit d(limit): the multiplier is published per percent.
      synthesis_.limits.push_back({{kMisalignment.name, person.Person()}, kMisalignment.unit, row, -1, 2 * limit});
    }
  }

  void AddPenalty() {
    if (shared_.penalty_deg_per_mm == 0 || shared_.goal != Goal::kRange) return;
    constexpr double kPlausible_mm = 30, kScale_mm2 = 100;
    const auto start = [](const PersonExtender& person) {
      const auto prediction = person.Predicted();
      return prediction ? prediction->Rms().mm : kPlausible_mm;
    };
    AddRoots("rms distance", start, false, 1 / kScale_mm2, shared_.penalty_deg_per_mm);
  }

  void AddGoal() {
    for (PersonExtender& person : people_)
      person.AddMeanSquare(nlp::NlpTerm::kCost, true, kPercentSquared * MisalignmentWeight(problem_));
    if (shared_.goal == Goal::kMisalignment && people_.size() > 1) AddLeastMisalignment();
    if (!shared_.min_range_deg) return;
    const int row =
        synthesis::AddLinearRow(nlp(), fmt::format("range ≥ {} deg", SignificantText(*shared_.min_range_deg, 6)),
                                *shared_.min_range_deg, nlp::kUnbounded, {{synthesis_.range, kDegreesPerRadian}});
    synthesis_.limits.push_back({{"least range"}, "deg", row});
  }

  // The percentage itself is the cost.
  void AddLeastMisalignment() {
    if (IsMean())
      for (const int root : Roots())
        synthesis::AddScaledTerm(nlp(), nlp::NlpTerm::kCost, root, 1 / static_cast<double>(people_.size()));
    else
      AddRoots("misalignment", StartPercent, true, kPercentSquared, 1);
  }

  static double StartPercent(const PersonExtender& person) {
    constexpr double kPlausible_percent = 8;
    const auto prediction = person.Predicted();
    return prediction ? 100 * prediction->Rms().relative : kPlausible_percent;
  }

  // Each person's RMS misalignment in percent, of which the mean is taken.
  const std::vector<int>& Roots() {
    if (roots_.empty()) roots_ = AddRoots("misalignment", StartPercent, true, kPercentSquared, 0);
    return roots_;
  }

  // Variables r with factor x mean square <= factor_r r^2: one for all who count, of the mean one for each; `weight` x
  // the largest or the mean r is added to the cost.
  std::vector<int> AddRoots(const std::string& name, double (*start)(const PersonExtender&), bool relative,
                            double factor, double weight) {
    const double own_factor = relative ? factor / kPercentSquared : factor;
    std::vector<int> roots;
    const auto add = [&](const std::string& of, double value) {
      roots.push_back(nlp().AddVariable(of, value, kLeastDistance_mm, nlp::kUnbounded));
    };
    if (!IsMean()) {
      double largest = 0;
      for (const PersonExtender& person : people_)
        if (Counts(person)) largest = std::max(largest, start(person));
      add(name, largest);
    }
    for (PersonExtender& person : people_) {
      if (!IsMean() && !Counts(person)) continue;
      if (IsMean()) add(person.Named(name), start(person));
      const int row = nlp().AddRow(person.Named(name), -nlp::kUnbounded, 0);
      person.AddMeanSquare(row, relative, factor);
      nlp().AddTerm(row, std::array{roots.back()}, SquareTerm(-own_factor));
      if (person.Variables().misalignment_row < 0) person.Variables().misalignment_row = row;
    }
    if (weight > 0)
      for (const int root : roots)
        synthesis::AddScaledTerm(nlp(), nlp::NlpTerm::kCost, root, weight / static_cast<double>(roots.size()));
    return roots;
  }

  bool Counts(const PersonExtender& person) const {
    return problem_.people[static_cast<std::size_t>(person.Person())].counts;
  }

  static constexpr double kPercentSquared = 1e4;

  const GroupProblem& problem_;
  const RedesignProblem& shared_;
  std::vector<PersonExtender>& people_;
  synthesis::SynthesisProgram& synthesis_;
  std::vector<int> roots_;
};

}  // namespace

RedesignBuilder::RedesignBuilder(const GroupProblem& problem, std::vector<RedesignPoint> start,
                                 std::vector<ConstantStart> constant_start)
    : problem_(problem), constant_start_(std::move(constant_start)), points_(std::move(start)) {
  for (std::size_t i = 0; i < problem.people.size(); ++i) people_.push_back(problem.Of(i));
}

synthesis::SynthesisProgram RedesignBuilder::Build(const synthesis::Collocation& poses) {
  const double range_weight = problem_.shared.goal == Goal::kRange ? 1 : kRangeTie;
  // Clearances are on one person's body, at its placement.
  const problem::SynthesisProblem design =
      people_.size() == 1 ? people_.front().DesignAt(points_.front().placement_mm) : problem_.shared.design;
  synthesis::SynthesisProgram program =
      synthesis::BuildProgram(design, Links(), poses, synthesis::Elasticity::kNone, range_weight);
  std::vector<PersonExtender> people;
  people.reserve(people_.size());
  for (std::size_t i = 0; i < people_.size(); ++i)
    people.emplace_back(people_[i], points_[i], constant_start_[i], i, problem_.people[i].name,
                        GroupExtender::MisalignmentWeight(problem_), program);
  GroupExtender(problem_, people, program).Extend();
  variables_.clear();
  for (PersonExtender& person : people) variables_.push_back(std::move(person.Variables()));
  return program;
}

void RedesignBuilder::MoveTo(const std::vector<double>& x) {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const RedesignVariables& variables = variables_[i];
    points_[i].links = synthesis::LinksAt(variables.links, x);
    points_[i].knots_mm.clear();
    for (const int knot : variables.knots) points_[i].knots_mm.push_back(x[knot]);
    points_[i].placement_mm = {x[variables.placement[0]], x[variables.placement[1]]};
    points_[i].duration_s = x[variables.duration];
    points_[i].lean = {};
    for (const int lean : variables.leg_lean) points_[i].lean.leg_rad.push_back(x[lean]);
    for (const int lean : variables.trunk_lean) points_[i].lean.trunk_rad.push_back(x[lean]);
  }
}

}  // namespace lake::redesign
