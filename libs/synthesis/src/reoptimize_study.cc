#include "lake/synthesis/reoptimize_study.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/synthesis/study.h"

namespace lake {
namespace {

using Kind = StrokeProgram::Kind;

// The predicted path through the comparison's own code; both knees are known without noise.
Misalignment ComparePredicted(const StsCurve& human, const StsCurve& predicted) {
  MisalignmentOptions options;
  options.replacement_sd_mm = 0, options.resamples = 0;
  return CompareTrials({{human}, {}}, {{predicted}, {}}, options);
}

Design Before(const ReoptimizeProblem& problem, const MeasuredMotion& measured) {
  Design design;
  design.links = problem.design.start, design.d_min_mm = problem.design.d_min_mm;
  if (measured.worn) design = *measured.worn;
  if (!design.program) design.program = StrokeProgram{Kind::kConstant, problem.program.max_speed_mm_s, {}};
  return design;
}

double ProgramDuration(const Design& design, const Prediction& prediction) {
  if (!design.program) return 0;
  if (design.program->kind == Kind::kFree)
    return design.program->knots.back().time_s - design.program->knots.front().time_s;
  return std::abs(prediction.stroke_mm.back() - prediction.stroke_mm.front()) / design.program->speed_mm_s;
}

NamedFront FrontOf(ReoptimizeProblem problem, const std::vector<Links>& links, const ReoptimizeStudy& study) {
  NamedFront front;
  front.program = problem.program;
  const bool free = problem.program.kind == Kind::kFree;
  front.name = free ? "free" : "constant";
  if (problem.program.duration_s) front.name += fmt::format(" {:.4g} s", *problem.program.duration_s);
  front.points = ParetoFront(problem, *study.options.pareto_points, links, study.options.optimize);
  return front;
}

// The constant program, a short free one, and the problem's own if it is another.
std::vector<NamedFront> Fronts(const ReoptimizeStudy& study, const std::vector<Links>& links) {
  ReoptimizeProblem constant = study.problem, brief = study.problem;
  if (constant.program.kind == Kind::kFree) constant.program.duration_s.reset();
  constant.program.kind = Kind::kConstant;
  brief.program.kind = Kind::kFree;
  brief.program.duration_s = study.options.short_program_s;
  std::vector<NamedFront> fronts{FrontOf(constant, links, study), FrontOf(brief, links, study)};
  const ProgramLimits& own = study.problem.program;
  if (own.kind == Kind::kFree && own.duration_s != brief.program.duration_s)
    fronts.push_back(FrontOf(study.problem, links, study));
  return fronts;
}

// Where to start: the problem's start, the worn design, and the optimum without the human.
std::vector<Links> StartLinks(const ReoptimizeProblem& problem, const MeasuredMotion& measured,
                              const OptimizeOptions& options) {
  std::vector<Links> links{problem.design.start};
  if (measured.worn) links.push_back(measured.worn->links);
  if (const LocalSolve range = SolveFrom(problem.design, problem.design.start, options); range.IsUsable())
    links.push_back(range.end);
  return links;
}

// No start found a way, but the least misalignment holds the limit: one more start from there.
void StartFromNearest(ReoptimizeStudy& study) {
  ReoptimizeSolve solve = SolveFrom(study.problem, study.infeasible->nearest, study.options.optimize, true);
  if (!solve.IsUsable()) return;
  study.result.best = static_cast<int>(study.result.starts.size());
  study.result.starts.push_back(std::move(solve));
  study.infeasible.reset();
}

}  // namespace

void ReoptimizeOptions::Check() const {
  optimize.Check();
  if (pareto_points && (*pareto_points < 2 || *pareto_points > 1000))
    throw UsageError(fmt::format("--pareto {}: 2 to 1000 points", *pareto_points));
}

DesignInMotion PutInMotion(const ReoptimizeProblem& problem, const StsCurve& human, const Design& design) {
  DesignInMotion in_motion{design, Evaluate(design.links, problem.design), {}, {}, {}, 0};
  const double standing_deg = problem.design.standing_deg;
  const Eigen::Vector2d placement(design.placement_mm[0], design.placement_mm[1]);
  if (const auto strokes = ProgramStrokes(design, standing_deg, problem.human))
    in_motion.prediction = Predict(design.links, design.d_min_mm, standing_deg, placement, *strokes, problem.human);
  if (const auto tracking = TrackingStrokes(design.links, design.d_min_mm, standing_deg, problem.human))
    in_motion.tracking_time_s = TrackingTime(*tracking, problem.program.max_speed_mm_s);
  if (!in_motion.prediction) return in_motion;
  in_motion.duration_s = ProgramDuration(design, *in_motion.prediction);
  in_motion.prediction->exo.duration_s = in_motion.duration_s;
  in_motion.misalignment = ComparePredicted(human, in_motion.prediction->exo);
  return in_motion;
}

ReoptimizeStudy RunReoptimization(ReoptimizeProblem problem, const MeasuredMotion& measured,
                                  const ReoptimizeOptions& options) {
  options.Check();
  problem.human = MakeHumanMotion(measured.human);
  if (measured.worn) problem.placement_mm = {measured.worn->placement_mm[0], measured.worn->placement_mm[1]};
  if (measured.worn && measured.exo)
    SetRemainder(*measured.exo, *measured.worn, problem.design.standing_deg, problem.human);
  problem.Check();
  ReoptimizeStudy study;
  study.problem = problem, study.options = options, study.measured = measured;
  const std::vector<Links> links = StartLinks(problem, measured, options.optimize);
  study.before = PutInMotion(problem, measured.human, Before(problem, measured));
  study.result = Reoptimize(problem, links, options.optimize);
  if (!study.IsSolved()) study.infeasible = ExplainInfeasible(problem, links, options.optimize);
  if (study.infeasible && study.infeasible->within_reach) StartFromNearest(study);
  const ReoptimizePoint& end = study.IsSolved() ? study.result.Best().point : study.infeasible->nearest;
  study.after = PutInMotion(problem, measured.human, DesignOf(problem, end));
  if (study.IsSolved()) study.active = FindActiveSet(study.result.Best().local);
  if (options.pareto_points) study.fronts = Fronts(study, links);
  if (!study.IsSolved()) return study;
  if (options.certify_gap_deg)
    study.certificate = Certify(problem.design, study.result.Best().Range_deg(), *options.certify_gap_deg,
                                options.certify_boxes, options.quiet);
  if (options.yield_tolerance_mm)
    study.yield = EstimateYield(end.links, problem.design,
                                {.tolerance_mm = *options.yield_tolerance_mm, .seed = options.optimize.seed});
  return study;
}

}  // namespace lake
