#include "lake/redesign/redesign_outcome.h"

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/processes.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"

namespace lake::redesign {

// From one process to another.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ParetoPoint, point, least_range_deg, range_deg, misalignment_percent, rms_mm)

namespace {

using Eigen::Vector2d;
using Kind = linkage::StrokeProgram::Kind;

// The predicted path through the comparison's own code; both knees are known without noise.
compare::Misalignment ComparePredicted(const RedesignProblem& problem, const compare::StsCurve& human,
                                       const compare::StsCurve& predicted) {
  compare::MisalignmentOptions options;
  options.replacement_sd_mm = 0;
  options.intervals = false;
  const auto movement = problem.program.cyclic ? gait::MovementKind::kWalking : gait::MovementKind::kSitToStand;
  return compare::CompareTrials({{human}, {}, movement}, {{predicted}, {}, movement}, options);
}

Vector2d PlacementOf(const linkage::Design& design) {
  return {design.placement_mm[0], design.placement_mm[1]};
}

// The strokes at which the worn linkage has the knee angles of its own trial: without a program the leg moved it.
linkage::StrokeProgram ProgramOfTrial(const linkage::Design& worn, const compare::StsCurve& exo, double standing_deg) {
  std::vector<double> knee_rad;
  for (const double knee_deg : exo.knee_deg) knee_rad.push_back(RadiansFromDegrees(knee_deg));
  const auto strokes = StrokesForAngles(DrivenLinksOf(worn, standing_deg), knee_rad);
  if (!strokes)
    throw Fail("the worn design cannot be assembled at its d_min of {} mm", SignificantText(worn.d_min_mm, 6));
  linkage::StrokeProgram program{Kind::kFree, 0, {}};
  for (std::size_t i = 0; i < strokes->size(); ++i)
    program.knots.push_back({exo.duration_s * static_cast<double>(i) / (compare::kPercentSamples - 1), (*strokes)[i]});
  return program;
}

linkage::Design Before(const RedesignProblem& problem, const MeasuredMotion& measured) {
  linkage::Design design;
  design.links = problem.design.start;
  design.d_min_mm = problem.design.d_min_mm;
  design.mount = problem.design.mount;
  if (measured.worn) design = *measured.worn;
  if (!design.program && measured.worn && measured.exo)
    design.program = ProgramOfTrial(*measured.worn, *measured.exo, problem.design.standing_deg);
  if (!design.program) design.program = linkage::StrokeProgram{Kind::kConstant, problem.program.max_speed_mm_s, {}};
  return design;
}

bool LeavesTooMuch(const MountSlip& slip) {
  constexpr double kMostShare = 0.5;  // of what was measured between joint and knee …
  constexpr double kTold_mm = 10;     // … where it is more than markers that were put on anew and skin make
  return slip.slip_mm > std::max(kMostShare * slip.mount_mm, kTold_mm);
}

// Throws where the trial's joint was elsewhere than the worn design says.
void CheckWorn(const MeasuredMotion& measured, const MountSlip& slip, const HumanMotion& human) {
  if (!LeavesTooMuch(slip)) return;
  std::string text = fmt::format(
      "{}: the joint of its trial was {} mm RMS off the leg's knee, and {} mm RMS of that are not explained by "
      "placement_mm: [{}, {}]",
      measured.worn_file, SignificantText(slip.mount_mm, 3), SignificantText(slip.slip_mm, 3),
      SignificantText(measured.worn->placement_mm[0], 4), SignificantText(measured.worn->placement_mm[1], 4));
  HumanMotion other = human;
  if (const auto placed = SetSlip(*measured.exo, measured.spike, slip.placement_mm, other); !LeavesTooMuch(*placed))
    text +=
        fmt::format("; if this design was worn, write placement_mm: [{:.1f}, {:.1f}], where the joint was on average",
                    slip.placement_mm.x(), slip.placement_mm.y());
  throw Fail("{}; else name the design that was worn (--worn), or leave that trial out (--human-only)", text);
}

// RMS over the motion.
double AngleOff_deg(const Prediction& worn, const compare::StsCurve& exo) {
  std::vector<double> off;
  for (std::size_t i = 0; i < exo.knee_deg.size(); ++i) off.push_back(worn.exo.knee_deg[i] - exo.knee_deg[i]);
  return RootMeanSquare(off);
}

// By the exoskeleton trial: delta, and whether the worn design fits it.
void TakeTrial(RedesignOutcome& outcome) {
  const MeasuredMotion& measured = outcome.measured;
  if (!measured.exo || !measured.worn) return;
  outcome.slip = SetSlip(*measured.exo, measured.spike, PlacementOf(*measured.worn), outcome.problem.human);
  if (outcome.slip) CheckWorn(measured, *outcome.slip, outcome.problem.human);
  outcome.measured_percent =
      100 * ComparePredicted(outcome.problem, measured.human, *measured.exo).metrics.relative_rms;
}

double ProgramDuration(const linkage::Design& design, const Prediction& prediction) {
  if (!design.program) return 0;
  if (design.program->kind == Kind::kFree)
    return design.program->knots.back().time_s - design.program->knots.front().time_s;
  return std::abs(prediction.stroke_mm.back() - prediction.stroke_mm.front()) / design.program->speed_mm_s;
}

// The constant program, a short free one, and the problem's own if it is another.
std::vector<RedesignProblem> FrontProblems(const RedesignOutcome& outcome) {
  RedesignProblem constant = outcome.problem, brief = outcome.problem;
  if (constant.program.kind == Kind::kFree) constant.program.duration_s.reset();
  constant.program.kind = Kind::kConstant;
  brief.program.kind = Kind::kFree;
  brief.program.duration_s = outcome.options.short_program_s;
  std::vector<RedesignProblem> problems{constant, brief};
  const ProgramLimits& own = outcome.problem.program;
  if (own.kind == Kind::kFree && own.duration_s != brief.program.duration_s) problems.push_back(outcome.problem);
  return problems;
}

// The problem as it was given: with the profile of the person's own rise.
RedesignProblem AsMeasured(RedesignProblem problem, const RedesignOutcome& outcome) {
  if (outcome.moments) problem.design.profile = outcome.moments->measured;
  return problem;
}

// How far the moments along a point's program are off those that it was sought under.
double OffMomentsNm(const RedesignProblem& problem, const problem::LoadProfile& measured, const RedesignPoint& point) {
  return LargestDifferenceNm(ProfileOf(problem, measured, point), *problem.design.profile);
}

// Of the program's widest design where the program is not the problem's own; the front is sought under these.
std::optional<MomentsOfProgram> TakeFrontMoments(const RedesignOutcome& outcome,
                                                 const std::vector<linkage::Links>& links, RedesignProblem& front) {
  const ProgramLimits& own = outcome.problem.program;
  const bool is_own = front.program.kind == own.kind && front.program.duration_s == own.duration_s;
  if (!outcome.moments || is_own) return outcome.moments;
  const RedesignProblem widest = WithGoal(AsMeasured(front, outcome), RedesignProblem::Goal::kRange);
  MomentsOfProgram moments = FindMoments(widest, links, outcome.options.optimize);
  front.design.profile = moments.profile;
  return moments;
}

double OffAlongNm(const RedesignProblem& front, const problem::LoadProfile& measured,
                  const std::vector<ParetoPoint>& points) {
  double largest_nm = 0;
  for (const ParetoPoint& point : points) largest_nm = std::max(largest_nm, OffMomentsNm(front, measured, point.point));
  return largest_nm;
}

std::vector<NamedFront> Fronts(const RedesignOutcome& outcome, const std::vector<linkage::Links>& links) {
  std::vector<RedesignProblem> problems = FrontProblems(outcome);
  std::vector<std::optional<MomentsOfProgram>> moments;
  moments.reserve(problems.size());
  for (RedesignProblem& problem : problems) moments.push_back(TakeFrontMoments(outcome, links, problem));
  Progress progress("Pareto fronts", "solves",
                    static_cast<std::int64_t>(problems.size()) * SolvesOfSweeps(*outcome.options.pareto_points),
                    outcome.options.optimize.quiet);
  const auto points = ResultsInProcesses(
      problems.size(),
      [&](std::size_t i, const std::function<void()>& step) {
        return ParetoFront(problems[i], *outcome.options.pareto_points, links, outcome.options.optimize, step);
      },
      progress);
  std::vector<NamedFront> fronts;
  for (std::size_t i = 0; i < problems.size(); ++i) {
    const ProgramLimits& program = problems[i].program;
    std::string name = ProgramName(program.kind);
    if (program.duration_s) name += fmt::format(" {} s", SignificantText(*program.duration_s, 4));
    if (moments[i]) moments[i]->off_nm = OffAlongNm(problems[i], moments[i]->measured, points[i]);
    fronts.push_back({std::move(name), program, points[i], moments[i]});
  }
  return fronts;
}

// Where to start: the problem's start, the worn design, and the optimum without the human.
std::vector<linkage::Links> StartLinks(RedesignOutcome& outcome) {
  const problem::SynthesisProblem& design = outcome.problem.design;
  std::vector<linkage::Links> links{design.start};
  if (outcome.measured.worn) links.push_back(outcome.measured.worn->links);
  const synthesis::LocalSolve widest = SolveFrom(design, design.start, outcome.options.optimize);
  if (!widest.IsUsable()) return links;
  links.push_back(widest.end);
  return links;
}

// Where a design has the exoskeleton's knee.
problem::SynthesisProblem PlacedAs(const linkage::Design& design, problem::SynthesisProblem problem) {
  problem.clearances.placement_mm = design.placement_mm;
  return problem;
}

// The moments of the program that is sought, in place of those of the person's own rise.
void TakeMoments(MomentsOfProgram moments, RedesignOutcome& outcome) {
  outcome.problem.design.profile = moments.profile;
  outcome.moments = std::move(moments);
}

// Evaluated under the moments along its own program.
DesignInMotion UnderOwnMoments(const RedesignOutcome& outcome, DesignInMotion in_motion) {
  if (!outcome.moments) return in_motion;
  problem::SynthesisProblem under = PlacedAs(in_motion.design, outcome.problem.design);
  under.profile =
      ProfileAlong(outcome.problem.human, outcome.moments->measured, in_motion.prediction, in_motion.duration_s);
  in_motion.evaluation = problem::Evaluate(in_motion.design.links, under);
  return in_motion;
}

DesignInMotion PutBeside(const RedesignOutcome& outcome, const linkage::Design& design) {
  return UnderOwnMoments(outcome, PutInMotion(outcome.problem, outcome.measured.human, design));
}

// What the placement is worth, and how far it is free.
void AssessPlacement(const RedesignPoint& chosen, RedesignOutcome& outcome) {
  const synthesis::OptimizeOptions& options = outcome.options.optimize;
  outcome.placement_range = FindPlacementRange(outcome.problem, chosen, options);
  RedesignProblem at_knee = outcome.problem;
  at_knee.fit_placement = false;
  at_knee.placement_mm.setZero();
  if (const RedesignSolve solve = SolveFrom(at_knee, chosen, options); solve.IsUsable())
    outcome.range_at_knee_deg = solve.Range_deg();
}

// What could be had if the person need not be in balance.
void FindWithoutBalance(const std::vector<linkage::Links>& links, RedesignOutcome& outcome) {
  RedesignProblem problem = AsMeasured(outcome.problem, outcome);
  problem.balance_mm.reset();
  std::optional<MomentsOfProgram>& moments = outcome.moments_without_balance;
  if (outcome.moments) {
    moments = FindMoments(problem, links, outcome.options.optimize);
    problem.design.profile = moments->profile;
  }
  const auto optimum = FindOptimum(problem, links, outcome.options.optimize);
  if (!optimum) return;
  if (moments) moments->off_nm = OffMomentsNm(problem, moments->measured, optimum->Point());
  outcome.without_balance = PutBeside(outcome, DesignOf(problem, optimum->Point()));
}

// Of the range alone: the misalignment's limit holds the design's own range down, and a bound never comes near that.
void CertifyWidest(RedesignOutcome& outcome) {
  const synthesis::SynthesisResult widest = synthesis::Optimize(outcome.problem.design, outcome.options.optimize);
  outcome.widest_deg = outcome.result.Best().Range_deg();
  if (widest.best >= 0) outcome.widest_deg = std::max(*outcome.widest_deg, widest.Best().evaluation.range_deg);
  const linkage::Links links = widest.best >= 0 ? widest.Best().end : outcome.result.Best().Point().links;
  outcome.certificate = synthesis::CertifyOptimum(outcome.problem.design, links, *outcome.widest_deg,
                                                  {.gap_deg = *outcome.options.certify_gap_deg,
                                                   .time_s = outcome.options.certify_time_s,
                                                   .quiet = outcome.options.quiet},
                                                  outcome.options.optimize);
}

// No start found a way, but the least misalignment holds the limit: one more start from there.
void StartFromNearest(RedesignOutcome& outcome) {
  RedesignSolve solve = SolveFrom(outcome.problem, outcome.infeasible->nearest, outcome.options.optimize, true);
  if (!solve.IsUsable()) return;
  outcome.result.Add(std::move(solve));
  outcome.infeasible.reset();
}

void SearchOrExplain(const std::vector<linkage::Links>& links, RedesignOutcome& outcome) {
  const synthesis::OptimizeOptions& options = outcome.options.optimize;
  outcome.result = Redesign(outcome.problem, links, options);
  if (!outcome.IsSolved()) outcome.infeasible = ExplainInfeasible(outcome.problem, links, options);
  if (outcome.infeasible && outcome.infeasible->within_reach) StartFromNearest(outcome);
}

// Where the optimum of all starts is another than the one whose moments were found, those of its own program are
// found, and it is sought again.
void FindDesign(std::vector<linkage::Links> links, RedesignOutcome& outcome) {
  constexpr int kMostTimes = 3;
  SearchOrExplain(links, outcome);
  for (int i = 0; i < kMostTimes && outcome.moments && outcome.IsSolved(); ++i) {
    const MomentsOfProgram& before = *outcome.moments;
    const RedesignPoint optimum = outcome.result.Best().Point();
    if (OffMomentsNm(outcome.problem, before.measured, optimum) <= kOtherMoments_nm) return;
    MomentsOfProgram moments = FindMoments(AsMeasured(outcome.problem, outcome), {}, outcome.options.optimize, optimum);
    if (moments.rounds == 0) return;
    moments.rounds += before.rounds;
    TakeMoments(std::move(moments), outcome);
    links.insert(links.begin(), optimum.links);
    SearchOrExplain(links, outcome);
  }
}

// The worn links and joint with the best program that the problem's limits allow it. What else a design must satisfy is
// not asked: this one is there.
std::optional<DesignInMotion> WithOtherProgram(const RedesignOutcome& outcome) {
  const linkage::Design& worn = *outcome.measured.worn;
  RedesignProblem same = WithGoal(outcome.problem, RedesignProblem::Goal::kMisalignment);
  same.design = problem::SynthesisProblem{};
  same.design.standing_deg = outcome.problem.design.standing_deg;
  same.design.d_min_mm = worn.d_min_mm;
  same.design.mount = worn.mount;
  same.design.start = worn.links;
  constexpr double kAround_mm = 1;
  for (std::size_t i = 0; i < same.design.bounds.size(); ++i)
    same.design.bounds[i] = {worn.links.Values()[i] - kAround_mm, worn.links.Values()[i] + kAround_mm};
  same = WithLinks(same, worn.links);
  same.max_cuff_force_n.reset();
  same.fit_placement = false;
  same.placement_mm = PlacementOf(worn);
  const RedesignSolve solve = SolveFrom(same, StartPoint(same, worn.links), outcome.options.optimize);
  if (!solve.IsUsable()) return std::nullopt;
  linkage::Design design = DesignOf(same, solve.Point());
  design.links = worn.links;
  return PutBeside(outcome, design);
}

// The worn design with its joint on the knee, in its own trial: pace and lean are those measured, as neither links nor
// program change. Of a trial that shows no leg of its own, where the prediction is best.
std::optional<DesignInMotion> WithJointMoved(const RedesignOutcome& outcome) {
  linkage::Design moved = outcome.before.design;
  const auto place = [&](const Vector2d& placement) { moved.placement_mm = {placement.x(), placement.y()}; };
  if (!outcome.slip) {
    const auto best = BestPlacement(outcome.problem, outcome.before);
    if (!best) return std::nullopt;
    place(*best);
    return PutBeside(outcome, moved);
  }
  const Vector2d& way_mm = outcome.slip->placement_mm;
  place(PlacementOf(moved) - way_mm);
  DesignInMotion in_motion = PutBeside(outcome, moved);
  compare::StsCurve trial = *outcome.measured.exo;
  for (std::size_t i = 0; i < trial.knee.size(); ++i)
    trial.knee[i] -= compare::AxesAlong(trial.leg_knee[i] - trial.ankle[i]) * way_mm;
  in_motion.misalignment = ComparePredicted(outcome.problem, outcome.measured.human, trial);
  const compare::MisalignmentMetrics& metrics = in_motion.misalignment->metrics;
  if (in_motion.prediction) in_motion.prediction->path = {metrics.relative_rms, metrics.rms_mm};
  return in_motion;
}

void FindRepairs(RedesignOutcome& outcome) {
  if (!outcome.measured.worn) return;
  outcome.joint_moved = WithJointMoved(outcome);
  outcome.other_program = WithOtherProgram(outcome);
}

// The worn design must have been able to do what its trial shows.
void CheckBefore(RedesignOutcome& outcome) {
  const MeasuredMotion& measured = outcome.measured;
  if (!measured.exo || !measured.worn) return;
  if (!outcome.before.prediction)
    throw Fail(
        "{}: the worn design cannot be driven through the motion of its trial: its program leaves the strokes at which "
        "the knee bends and stands",
        measured.worn_file);
  outcome.worn_angle_off_deg = AngleOff_deg(*outcome.before.prediction, *measured.exo);
}

}  // namespace

void RedesignOptions::Check() const {
  SynthesisOptions::Check();
  if (pareto_points && (*pareto_points < 2 || *pareto_points > 1000))
    throw UsageError("--pareto {}: 2 to 1000 points", *pareto_points);
}

double ValueOf(const Quantity& quantity, const DesignInMotion& design) {
  return design.prediction ? quantity.value(*design.prediction) : kNaN;
}

DesignInMotion PutInMotion(const RedesignProblem& problem, const compare::StsCurve& human,
                           const linkage::Design& design, const Lean& lean) {
  DesignInMotion in_motion{.design = design,
                           .evaluation = problem::Evaluate(design.links, PlacedAs(design, problem.design)),
                           .prediction = {},
                           .misalignment = {},
                           .tracking_time_s = {},
                           .tracked_share = {},
                           .duration_s = 0};
  const double standing_deg = problem.design.standing_deg;
  const Vector2d placement = PlacementOf(design);
  if (const auto strokes = ProgramStrokes(design, standing_deg, problem.human))
    in_motion.prediction =
        Predict(DrivenLinksOf(design, standing_deg), placement, *strokes, Leaning(problem.human, lean.leg_rad));
  if (const auto tracking = TrackingStrokes(DrivenLinksOf(design, standing_deg), problem.human)) {
    in_motion.tracking_time_s = TrackingTime(*tracking, problem.program.max_speed_mm_s);
    in_motion.tracked_share = TrackedShare(*tracking, problem.program.max_speed_mm_s, human.duration_s);
  }
  if (!in_motion.prediction) return in_motion;
  in_motion.duration_s = ProgramDuration(design, *in_motion.prediction);
  Complete(problem, placement, lean, in_motion.duration_s, *in_motion.prediction);
  in_motion.misalignment = ComparePredicted(problem, human, in_motion.prediction->exo);
  return in_motion;
}

std::optional<cuffs::CuffCourse> CuffsOf(const RedesignProblem& problem, const DesignInMotion& design,
                                         double joint_sd_mm) {
  if (!design.prediction) return std::nullopt;
  const Vector2d place_mm = PlacementOf(design.design) + problem.human.back().slip_mm;
  return cuffs::CourseOf(design.prediction->exo.knee_deg, {place_mm, joint_sd_mm}, problem.cuffs);
}

std::optional<Vector2d> BestPlacement(const RedesignProblem& problem, const DesignInMotion& design) {
  if (!design.prediction) return std::nullopt;
  const Vector2d placement = PlacementOf(design.design);
  Vector2d sum = Vector2d::Zero();
  double weights = 0;
  for (std::size_t i = 0; i < problem.human.size(); ++i) {
    const HumanSample& human = problem.human[i];
    const auto knee_at = [&](const Vector2d& p) {
      return PredictKnee(human, design.prediction->theta_rad[i], p.x(), p.y());
    };
    const Vector2d knee = knee_at(placement);
    Eigen::Matrix2d axes;  // what a move along x and y adds
    axes << knee_at(placement + Vector2d::UnitX()) - knee, knee_at(placement + Vector2d::UnitY()) - knee;
    const double weight = 1 / (human.shank_mm * human.shank_mm);
    sum += weight * (axes.transpose() * (human.knee - knee));
    weights += weight;
  }
  const double reach = problem.placement_reach_mm;
  return (placement + sum / weights).cwiseMax(-reach).cwiseMin(reach);
}

RedesignOutcome PutMotionInto(RedesignProblem problem, const MeasuredMotion& measured) {
  problem.human = MakeHumanMotion(measured.human);
  if (measured.worn) problem.placement_mm = PlacementOf(*measured.worn);
  problem.design = problem.DesignAt(problem.placement_mm);
  problem.Check();
  RedesignOutcome outcome;
  outcome.problem = std::move(problem);
  outcome.measured = measured;
  TakeTrial(outcome);
  return outcome;
}

RedesignOutcome RunRedesign(RedesignProblem problem, const MeasuredMotion& measured, const RedesignOptions& options) {
  options.Check();
  RedesignOutcome outcome = PutMotionInto(std::move(problem), measured);
  outcome.options = options;
  const std::vector<linkage::Links> links = StartLinks(outcome);
  if (outcome.problem.design.HasLoadProfile())
    TakeMoments(FindMoments(outcome.problem, links, options.optimize), outcome);
  outcome.before = PutBeside(outcome, Before(outcome.problem, measured));
  CheckBefore(outcome);
  FindRepairs(outcome);
  FindDesign(links, outcome);
  problem = outcome.problem;
  const RedesignPoint end = outcome.IsSolved() ? NearestToKnee(problem, outcome.result.Best(), options.optimize)
                                               : outcome.infeasible->nearest;
  outcome.after = PutInMotion(problem, measured.human, DesignOf(problem, end), end.lean);
  outcome.lean = end.lean;
  if (outcome.moments) outcome.moments->off_nm = OffMomentsNm(problem, outcome.moments->measured, end);
  if (problem.balance_mm) FindWithoutBalance(links, outcome);
  if (outcome.IsSolved()) outcome.active = synthesis::FindActiveSet(outcome.result.Best().local);
  if (options.pareto_points) outcome.fronts = Fronts(outcome, links);
  if (!outcome.IsSolved()) return outcome;
  if (problem.fit_placement) AssessPlacement(end, outcome);
  if (options.certify_gap_deg) CertifyWidest(outcome);
  if (options.yield_tolerance_mm)
    outcome.yield = synthesis::YieldOf(end.links, PlacedAs(outcome.after.design, problem.design), options);
  return outcome;
}

}  // namespace lake::redesign
