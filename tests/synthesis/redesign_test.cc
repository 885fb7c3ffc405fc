// Re-optimisation against the comparison's own code, other searches, difference quotients and its own limits.
#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include "compare/closed_form.h"
#include "lake/core/error.h"
#include "lake/redesign/redesign_outcome.h"
#include "synthesis/differential_evolution.h"
#include "synthesis/paper.h"

namespace lake {
namespace {

using Goal = redesign::RedesignProblem::Goal;
using Kind = linkage::StrokeProgram::Kind;
using testing::HasSubstr;

redesign::RedesignProblem Problem(const ClosedFormLeg& leg = {}, double margin_mm = 2) {
  redesign::RedesignProblem problem;
  problem.design = WithMargins(margin_mm);
  problem.human = redesign::MakeHumanMotion(MakeCurve(leg));
  return problem;
}

redesign::RedesignProblem Free(double duration_s, const ClosedFormLeg& leg = {}) {
  redesign::RedesignProblem problem = Problem(leg);
  problem.program.kind = Kind::kFree;
  problem.program.duration_s = duration_s;
  return problem;
}

redesign::RedesignResult Solve(const redesign::RedesignProblem& problem, int starts = 4) {
  return redesign::Redesign(problem, {problem.design.start, kPublishedLinks}, Starts(starts));
}

redesign::RedesignResult Least(redesign::RedesignProblem problem, int starts = 6) {
  problem.goal = Goal::kMisalignment;
  problem.max_misalignment_percent.reset();
  return Solve(problem, starts);
}

// Half-way from the least misalignment to that of the largest range: a limit that costs range and can be held. The
// known starts are enough for one that is near there.
double TightLimit(const redesign::RedesignProblem& problem) {
  const redesign::RedesignResult least = Least(problem, 2), widest = Solve(problem, 2);
  return (least.Best().Misalignment_percent() + widest.Best().Misalignment_percent()) / 2;
}

std::vector<ClosedFormLeg> Legs() {
  ClosedFormLeg tall, stiff;
  tall.shank_mm = 470;
  tall.thigh_mm = 450;
  tall.seated_knee_deg = 101;
  stiff.standing_knee_deg = 14;
  stiff.peak_shank_deg = 25;
  return {{}, tall, stiff};
}

TEST(Redesign, TheLimitHoldsWhenTheComparisonReEvaluatesThePredictedPath) {
  for (const ClosedFormLeg& leg : Legs())
    for (redesign::RedesignProblem problem : {Problem(leg), Free(14, leg)}) {
      problem.max_misalignment_percent = TightLimit(problem);
      const redesign::RedesignResult result = Solve(problem);
      ASSERT_TRUE(result.IsSolved());
      const redesign::DesignInMotion after =
          redesign::PutInMotion(problem, MakeCurve(leg), redesign::DesignOf(problem, result.Best().Point()));
      ASSERT_TRUE(after.misalignment);
      // The bound; the limit is active, so it is met from below and above.
      EXPECT_NEAR(100 * after.misalignment->metrics.relative_rms / *problem.max_misalignment_percent, 1, 1e-4);
      EXPECT_TRUE(after.evaluation.IsFeasible());
      EXPECT_LE(after.duration_s, problem.program.duration_s.value_or(1e9) * (1 + 1e-6));
    }
}

// Worn on a mount that sits 12 mm forward and 5 mm low, which a joint on the path must not follow.
redesign::RedesignProblem OnAMount(double duration_s = 14) {
  redesign::RedesignProblem problem = Free(duration_s);
  for (redesign::HumanSample& sample : problem.human) sample.slip_mm = {12, -5};
  problem.fit_placement = true;
  return problem;
}

// The comparison's own joint, in the path that was predicted, through the cuffs' model at the stiffest.
double CuffForceOfPath(const redesign::RedesignProblem& problem, const redesign::RedesignPoint& point) {
  const redesign::DesignInMotion design =
      redesign::PutInMotion(problem, MakeCurve({}), redesign::DesignOf(problem, point));
  cuffs::CuffOptions stiffest = problem.cuffs;
  stiffest.softest_n_mm = stiffest.stiffest_n_mm;
  const cuffs::CuffCourse course =
      cuffs::CourseOf(design.prediction->exo.knee_deg, {design.misalignment->joint->shank_mm.back(), 0}, stiffest);
  return std::max(cuffs::Largest(course.thigh_n).force_n, cuffs::Largest(course.shank_n).force_n);
}

TEST(Redesign, TheLimitOnCuffForcesHoldsInThePredictedPathAndHasAPrice) {
  redesign::RedesignProblem problem = OnAMount();
  problem.max_misalignment_percent = TightLimit(problem);
  const redesign::RedesignResult free = Solve(problem);
  ASSERT_TRUE(free.IsSolved());
  const double free_n = CuffForceOfPath(problem, free.Best().Point());
  EXPECT_NEAR(free.Best().Predicted()->cuff_force_n, free_n, 1e-9 * free_n);
  problem.max_cuff_force_n = 0.8 * free_n;
  const redesign::RedesignResult limited = Solve(problem);
  ASSERT_TRUE(limited.IsSolved());
  EXPECT_NEAR(CuffForceOfPath(problem, limited.Best().Point()) / *problem.max_cuff_force_n, 1, 1e-5);
  EXPECT_LT(limited.Best().Range_deg(), free.Best().Range_deg());
  const auto multiplier = limited.Best().local.MultiplierOf(synthesis::LimitId{"cuff force"});
  ASSERT_TRUE(multiplier);
  const auto range = [&](double step_n) {
    redesign::RedesignProblem near = problem;
    *near.max_cuff_force_n += step_n;
    return redesign::SolveFrom(near, limited.Best().Point()).Range_deg();
  };
  constexpr double kStep_n = 0.02;
  EXPECT_NEAR((range(kStep_n) - range(-kStep_n)) / (2 * kStep_n), *multiplier, 0.05 * *multiplier + 1e-3);
  // A penalty of that multiplier, instead of the limit, buys the same force.
  problem.max_cuff_force_n.reset();
  problem.cuff_penalty_deg_per_n = *multiplier;
  const redesign::RedesignResult penalised = Solve(problem);
  ASSERT_TRUE(penalised.IsSolved());
  EXPECT_NEAR(penalised.Best().Predicted()->cuff_force_n, 0.8 * free_n, 0.02 * free_n);
}

TEST(Redesign, SaysWhichForceAtTheCuffsIsPossible) {
  redesign::RedesignProblem problem = OnAMount(45);
  problem.max_angle_mismatch_deg = 10;  // a leg that need not bend has no misfit
  problem.fit_placement = false;
  problem.placement_mm = {8, 20};
  problem.max_cuff_force_n = 1;
  const std::vector<linkage::Links> links{problem.design.start, kPublishedLinks};
  const redesign::Infeasibility report = redesign::ExplainInfeasible(problem, links, Starts(2));
  ASSERT_EQ(report.quantity, &redesign::kCuffForce);
  EXPECT_GT(*report.best, 1);
  EXPECT_THAT(report.sentence, HasSubstr("(--max-cuff-force)"));
  EXPECT_THAT(report.sentence, HasSubstr("N can be held)"));
  EXPECT_THAT(report.sentence, HasSubstr("what would free it: fitting the placement within 40 mm (--fit-placement)"));
  ASSERT_EQ(report.ways.size(), 1u);
  EXPECT_TRUE(report.ways.front().enough);
  problem.fit_placement = true;
  const redesign::RedesignResult fitted = Solve(problem, 2);
  ASSERT_TRUE(fitted.IsSolved());
  EXPECT_LE(CuffForceOfPath(problem, fitted.Best().Point()), 1 + 1e-4);
}

// What a search may vary, as a point; a constant program's strokes follow from the links.
std::optional<double> Objective(const redesign::RedesignProblem& problem, const redesign::RedesignPoint& point) {
  const auto prediction = redesign::PredictPoint(problem, point);
  if (!prediction) return std::nullopt;
  if (problem.max_misalignment_percent && 100 * prediction->path.relative > *problem.max_misalignment_percent)
    return std::nullopt;
  if (problem.program.duration_s &&
      redesign::TrackingTime(point.knots_mm, problem.program.max_speed_mm_s) > *problem.program.duration_s)
    return std::nullopt;
  const problem::DesignEvaluation evaluation = problem::Evaluate(point.links, problem.design);  // takes longest
  if (!evaluation.IsFeasible()) return std::nullopt;
  return evaluation.range_deg - problem.penalty_deg_per_mm * prediction->path.mm;
}

// Links near the optimum and, of a free program, a program near the optimum's: pushed by its own mean change, so that
// the speed limit is not broken by every sample.
redesign::RedesignPoint RandomPoint(const redesign::RedesignProblem& problem, const redesign::RedesignPoint& best,
                                    double spread_mm, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  redesign::RedesignPoint point =
      redesign::StartPoint(problem, RandomFeasible(problem.design, random, &best.links, spread_mm));
  if (problem.fit_placement) {
    const Eigen::Vector2d middle = spread_mm > 10 ? problem.placement_mm : best.placement_mm;
    for (const int axis : {0, 1})
      point.placement_mm[axis] = std::clamp(middle[axis] + 2 * spread_mm * unit(random), -problem.placement_reach_mm,
                                            problem.placement_reach_mm);
  }
  if (problem.program.kind == Kind::kConstant) return point;
  const double shift = point.knots_mm.front() - best.knots_mm.front(), scale = 1 - 0.01 * std::abs(unit(random));
  for (std::size_t k = 0; k < point.knots_mm.size(); ++k)
    point.knots_mm[k] = best.knots_mm.front() + shift + scale * (best.knots_mm[k] - best.knots_mm.front());
  return point;
}

TEST(Redesign, NoRandomSearchFindsABetterObjective) {
  redesign::RedesignProblem constant = Problem(), penalty = Problem(), free = Free(14);
  constant.fit_placement = penalty.fit_placement = true;
  constant.max_misalignment_percent = TightLimit(constant);
  free.max_misalignment_percent = TightLimit(free);
  penalty.penalty_deg_per_mm = 2;
  for (const redesign::RedesignProblem& problem : {constant, penalty, free}) {
    const redesign::RedesignResult result = Solve(problem);
    ASSERT_TRUE(result.IsSolved());
    std::mt19937_64 random(5);
    int feasible = 0, tried = 0;
    double best = -1e9;
    constexpr int kFeasible = 1000;  // of each problem
    for (; feasible < kFeasible && tried < 100 * kFeasible; ++tried) {
      // Mostly near by, where most are feasible; from the whole of the bounds few are.
      constexpr double kSpreads_mm[] = {0.05, 0.5, 0.05, 3, 0.05, 0.5, 0.05, 100};
      const redesign::RedesignPoint point = RandomPoint(problem, result.Best().Point(), kSpreads_mm[tried % 8], random);
      if (const auto objective = Objective(problem, point)) ++feasible, best = std::max(best, *objective);
    }
    EXPECT_GE(feasible, kFeasible);
    EXPECT_LE(best, result.Best().objective + 1e-4);
    EXPECT_GE(best, result.Best().objective - 3);  // the samples come near enough to find a better one
  }
}

TEST(Redesign, NoDifferentialEvolutionFindsABetterObjective) {
  redesign::RedesignProblem problem = Problem();
  problem.fit_placement = true;
  problem.max_misalignment_percent = TightLimit(problem);
  const redesign::RedesignResult result = Solve(problem);
  ASSERT_TRUE(result.IsSolved());
  std::vector<problem::Bounds> bounds(problem.design.bounds.begin(), problem.design.bounds.end());
  bounds.insert(bounds.end(), 2, {-problem.placement_reach_mm, problem.placement_reach_mm});
  // Infeasible points rank below feasible ones, by how much they violate.
  const auto value = [&](const std::vector<double>& x) {
    const linkage::Links links = linkage::Links::FromValues({x[0], x[1], x[2], x[3], x[4], x[5]});
    if (!linkage::SolvePose(links, problem.design.d_min_mm)) return -1e6;
    redesign::RedesignPoint point = redesign::StartPoint(problem, links);
    point.placement_mm = {x[6], x[7]};
    const problem::DesignEvaluation evaluation = problem::Evaluate(links, problem.design);
    const auto prediction = redesign::PredictPoint(problem, point);
    if (!evaluation.IsFeasible() || !prediction) return -1e3 * (1 + std::min(evaluation.violation, 100.0));
    const double excess = 100 * prediction->path.relative - *problem.max_misalignment_percent;
    return excess > 0 ? -100 * excess : evaluation.range_deg;
  };
  for (const unsigned seed : {1u, 2u}) {
    const Evolved evolved = Evolve(bounds, value, 60, 300, seed);
    EXPECT_LE(evolved.value, result.Best().objective + 1e-6);
    EXPECT_GE(evolved.value, result.Best().objective - 5);  // it has come near: the comparison means something
  }
}

TEST(Redesign, ParetoFrontIsMonotoneAndEndsAtTheSingleObjectiveOptima) {
  redesign::RedesignProblem placed = Problem();
  placed.fit_placement = true;
  for (const redesign::RedesignProblem& problem : {placed, Free(14)}) {
    const std::vector<redesign::ParetoPoint> front =
        redesign::ParetoFront(problem, 6, {problem.design.start, kPublishedLinks}, Starts(6));
    ASSERT_EQ(front.size(), 6u);
    for (std::size_t i = 1; i < front.size(); ++i) {
      EXPECT_GT(front[i].range_deg, front[i - 1].range_deg - 1e-9);
      EXPECT_GE(front[i].misalignment_percent, front[i - 1].misalignment_percent - 1e-9);
    }
    EXPECT_NEAR(front.front().misalignment_percent, Least(problem).Best().Misalignment_percent(), 1e-6);
    // The largest range is that of the synthesis without a human: a certified number (certificate_test).
    EXPECT_NEAR(front.back().range_deg, 153.770, 1e-3);
    EXPECT_GT(front.back().misalignment_percent, front.front().misalignment_percent * 1.01);
    // A point in between is what its own constrained problem gives.
    redesign::RedesignProblem between = problem;
    between.max_misalignment_percent = front[3].misalignment_percent;
    const redesign::RedesignResult result = Solve(between);
    ASSERT_TRUE(result.IsSolved());
    EXPECT_NEAR(result.Best().Range_deg(), front[3].range_deg, 0.02);
  }
}

TEST(Redesign, AFreeProgramOfTheTrackingTimeCutsTheMisalignmentAtLeastFivefold) {
  for (const ClosedFormLeg& leg : Legs()) {
    const redesign::RedesignResult constant = Least(Problem(leg));
    ASSERT_TRUE(constant.IsSolved());
    const linkage::Links& links = constant.Best().Point().links;
    redesign::RedesignProblem free = Free(1, leg);
    free.program.duration_s =
        redesign::TrackingTime(*redesign::TrackingStrokes({links}, free.human), free.program.max_speed_mm_s);
    const redesign::RedesignResult result = Least(free);
    ASSERT_TRUE(result.IsSolved());
    EXPECT_GE(constant.Best().Misalignment_percent(), 5 * result.Best().Misalignment_percent());
  }
}

double MultiplierOf(const synthesis::ActiveSet& active, const synthesis::LimitId& id) {
  const synthesis::ActiveSet::Entry* entry = active.Find(id);
  return entry ? entry->multiplier : 0;
}

// The multiplier of the limit, taken as penalty, leads to the same design.
TEST(Redesign, PenaltyAndLimitAgree) {
  redesign::RedesignProblem limited = Free(14);
  limited.max_misalignment_percent = TightLimit(limited);
  const redesign::RedesignResult result = Solve(limited);
  ASSERT_TRUE(result.IsSolved());
  const synthesis::ActiveSet active = synthesis::FindActiveSet(result.Best().local);
  ASSERT_TRUE(active.multipliers_unique);
  redesign::RedesignProblem penalised = Free(14);
  const double mm_per_percent = limited.human.front().shank_mm / 100;  // this leg's shank is rigid
  penalised.penalty_deg_per_mm = MultiplierOf(active, {"misalignment"}) / mm_per_percent;
  const redesign::RedesignResult other = Solve(penalised);
  ASSERT_TRUE(other.IsSolved());
  // Along the front range and misalignment trade at this multiplier, so each may be off by what the other makes good.
  EXPECT_NEAR(other.Best().objective,
              result.Best().Range_deg() - penalised.penalty_deg_per_mm * result.Best().Predicted()->path.mm, 1e-3);
  EXPECT_NEAR(other.Best().Misalignment_percent(), result.Best().Misalignment_percent(), 0.02);
}

TEST(Redesign, MultipliersAreDifferenceQuotientsOfTheRange) {
  redesign::RedesignProblem problem = Free(14);
  problem.max_misalignment_percent = TightLimit(problem);
  const redesign::RedesignResult result = Solve(problem);
  ASSERT_TRUE(result.IsSolved());
  const synthesis::ActiveSet active = synthesis::FindActiveSet(result.Best().local);
  ASSERT_TRUE(active.multipliers_unique) << active.smallest_singular_value;
  const auto quotient = [&](const std::function<void(redesign::RedesignProblem&, double)>& change, double step) {
    redesign::RedesignProblem above = problem, below = problem;
    change(above, step);
    change(below, -step);
    const auto range = [&](const redesign::RedesignProblem& p) {
      return SolveFrom(p, result.Best().Point(), {}).Range_deg();
    };
    return (range(above) - range(below)) / (2 * step);
  };
  const double per_percent = quotient([](auto& p, double step) { *p.max_misalignment_percent += step; }, 1e-3);
  const double per_second = quotient([](auto& p, double step) { *p.program.duration_s += step; }, 1e-3);
  const double per_mm = quotient([](auto& p, double step) { p.design.grashof_margin_mm += step; }, 1e-3);
  // The small costs move multipliers by about 1e-4 of themselves.
  EXPECT_NEAR(MultiplierOf(active, {"misalignment"}), per_percent, 2e-3 * std::abs(per_percent));
  EXPECT_NEAR(MultiplierOf(active, {"duration"}), per_second, 2e-3 * std::abs(per_second));
  EXPECT_NEAR(MultiplierOf(active, synthesis::LimitId{"grashof"}), per_mm, 2e-3 * std::abs(per_mm));
  EXPECT_GT(per_percent, 0.1);
}

TEST(Redesign, ADesignThatBendsLessThanTheHumanStartsAtItsShortestStroke) {
  redesign::RedesignProblem problem = Problem();
  problem.design.limits["max_angle_deg"] = 80;  // the human sits at 92
  const redesign::RedesignResult result = Solve(problem);
  ASSERT_TRUE(result.IsSolved());
  EXPECT_NEAR(result.Best().Range_deg(), 80, 1e-5);
  EXPECT_NEAR(result.Best().Point().knots_mm.front(), 242, 1e-6);
  const linkage::Design design = redesign::DesignOf(problem, result.Best().Point());
  const auto strokes = redesign::ProgramStrokes(design, 0, problem.human);
  ASSERT_TRUE(strokes);
  EXPECT_NEAR(strokes->back(), result.Best().Point().knots_mm.back(), 1e-5);
}

// What is written as "constant" is read back as the very program that was optimised.
TEST(Redesign, AConstantProgramReadsBackAsTheSameStrokes) {
  redesign::RedesignProblem problem = Problem();
  problem.max_misalignment_percent = TightLimit(problem);
  const redesign::RedesignResult result = Solve(problem);
  ASSERT_TRUE(result.IsSolved());
  const auto strokes = redesign::ProgramStrokes(redesign::DesignOf(problem, result.Best().Point()), 0, problem.human);
  ASSERT_TRUE(strokes);
  for (int percent = 0; percent < compare::kPercentSamples; ++percent)
    EXPECT_NEAR((*strokes)[percent], result.Best().Point().StrokeAt(percent), 1e-6);
}

// Against a search over both ends on a grid, with the same links.
TEST(Redesign, TheEndsOfAConstantProgramMayBeSoughtToo) {
  redesign::RedesignProblem held = Problem({}, 0);  // which the published links meet
  held.goal = Goal::kMisalignment;
  held = redesign::WithLinks(held, kPublishedLinks);
  redesign::RedesignProblem free = held;
  free.program.free_ends = true;
  const redesign::RedesignPoint start = redesign::StartPoint(held, kPublishedLinks);
  const redesign::RedesignSolve solve = redesign::SolveFrom(free, start);
  ASSERT_TRUE(solve.IsUsable());
  EXPECT_LT(solve.Misalignment_percent(), redesign::SolveFrom(held, start).Misalignment_percent() - 0.1);
  double least = 1e9, best_from = 266, best_to = 355;
  for (const double step : {1.0, 0.1, 0.01})  // each grid about the best of the one before
    for (double center_from = best_from, center_to = best_to, i = -25; i <= 25; ++i)
      for (double k = -25; k <= 25; ++k) {
        redesign::RedesignPoint tried = solve.Point();
        tried.knots_mm = {center_from + i * step, center_to + k * step};
        const auto prediction = redesign::PredictPoint(free, tried);
        if (!prediction || 100 * prediction->path.relative >= least) continue;
        least = 100 * prediction->path.relative;
        best_from = tried.knots_mm.front();
        best_to = tried.knots_mm.back();
      }
  EXPECT_LE(solve.Misalignment_percent(), least + 1e-6);
  EXPECT_GE(solve.Misalignment_percent(), least - 0.02) << best_from << " to " << best_to;
  // It reads back as two knots at one speed.
  const linkage::Design design = redesign::DesignOf(free, solve.Point());
  ASSERT_EQ(design.program->knots.size(), 2u);
  EXPECT_NEAR(design.program->knots.back().stroke_mm - design.program->knots.front().stroke_mm,
              5 * design.program->knots.back().time_s, 1e-9);
}

TEST(Redesign, MonotoneForbidsTurningBackWhereTheHumanDoes) {
  // The knee bends a little before it straightens.
  redesign::RedesignProblem problem = Free(60);
  ClosedFormLeg bending;
  bending.seated_knee_deg = 85;
  compare::StsCurve curve = MakeCurve(bending);
  for (int i = 0; i < 40; ++i) {
    const double more_rad = 0.15 * std::sin(std::numbers::pi * i / 40.0);
    curve.hip[i] = curve.knee[i] + Eigen::Rotation2Dd(more_rad) * (curve.hip[i] - curve.knee[i]);
  }
  problem.human = redesign::MakeHumanMotion(curve);
  const auto turns_back = [](const redesign::RedesignSolve& solve) {
    for (std::size_t k = 1; k < solve.Point().knots_mm.size(); ++k)
      if (solve.Point().knots_mm[k] < solve.Point().knots_mm[k - 1] - 1e-3) return true;
    return false;
  };
  const redesign::RedesignResult free = Least(problem);
  problem.program.monotone = true;
  const redesign::RedesignResult monotone = Least(problem);
  ASSERT_TRUE(free.IsSolved() && monotone.IsSolved());
  EXPECT_TRUE(turns_back(free.Best()));
  EXPECT_FALSE(turns_back(monotone.Best()));
  EXPECT_GT(monotone.Best().Misalignment_percent(), 2 * free.Best().Misalignment_percent());
}

TEST(Redesign, SaysWhatBlocksAndWhatWouldFreeIt) {
  redesign::RedesignProblem problem = Problem();
  const double least = Least(problem).Best().Misalignment_percent();
  problem.max_misalignment_percent = least / 3;
  EXPECT_FALSE(Solve(problem).IsSolved());
  const std::vector<linkage::Links> links{problem.design.start, kPublishedLinks};
  const redesign::Infeasibility report = redesign::ExplainInfeasible(problem, links, Starts(6));
  ASSERT_EQ(report.quantity, &redesign::kMisalignment);
  EXPECT_NEAR(*report.best, least, 1e-5);
  EXPECT_FALSE(report.blocking.empty());
  EXPECT_THAT(report.sentence, HasSubstr("the constant program"));
  const std::size_t limit = report.sentence.find("(a limit of ");
  ASSERT_NE(limit, std::string::npos) << report.sentence;
  redesign::RedesignProblem wider = problem;
  wider.max_misalignment_percent = std::stod(report.sentence.substr(limit + 12));
  EXPECT_TRUE(Solve(wider, 6).IsSolved());
  const auto way =
      std::ranges::find_if(report.ways, [](const redesign::WayOut& w) { return w.duration_s.has_value(); });
  ASSERT_NE(way, report.ways.end());
  // What the text says is done: it is enough, and 2 % less is not.
  redesign::RedesignProblem free = problem;
  free.program.kind = Kind::kFree;
  free.program.duration_s = std::stod(way->text.substr(way->text.find("at least ") + 9));
  EXPECT_TRUE(Solve(free, 6).IsSolved());
  free.program.duration_s = *way->duration_s * 0.98;
  EXPECT_FALSE(Solve(free, 6).IsSolved());
  const redesign::Infeasibility brief = redesign::ExplainInfeasible(free, links, Starts(6));
  EXPECT_THAT(brief.sentence, HasSubstr("a duration of at least"));
}

TEST(Redesign, BlockingPricesAreDifferenceQuotients) {
  redesign::RedesignProblem problem = Free(14);
  const redesign::RedesignResult result = Least(problem);
  problem.max_misalignment_percent = result.Best().Misalignment_percent() / 2;
  const redesign::Infeasibility report =
      redesign::ExplainInfeasible(problem, {problem.design.start, kPublishedLinks}, Starts(6));
  const auto least_with = [&](double duration_s) {
    redesign::RedesignProblem changed = problem;
    changed.program.duration_s = duration_s;
    return Least(changed).Best().Misalignment_percent();
  };
  const synthesis::LimitId duration{"duration"};
  const auto entry = std::ranges::find(report.blocking, duration, &synthesis::ActiveSet::Entry::id);
  ASSERT_NE(entry, report.blocking.end()) << report.sentence;
  ASSERT_FALSE(std::isnan(entry->multiplier));
  EXPECT_NEAR(entry->multiplier, (least_with(13.99) - least_with(14.01)) / 0.02, 0.01 * std::abs(entry->multiplier));
  EXPECT_GT(entry->multiplier, 0);
}

TEST(Redesign, SaysThatTheTimeOrTheDesignIsWhatFails) {
  redesign::RedesignProblem hurried = Problem();
  hurried.program.duration_s = 0.4;
  hurried.max_misalignment_percent = 20;
  const std::vector<linkage::Links> links{hurried.design.start, kPublishedLinks};
  const redesign::Infeasibility time = redesign::ExplainInfeasible(hurried, links, Starts(4));
  EXPECT_THAT(time.sentence, HasSubstr("no design stands up within 0.4 s"));
  ASSERT_EQ(time.ways.size(), 1u);
  hurried.program.duration_s = std::stod(time.ways[0].text.substr(std::string("a duration of ").size()));
  EXPECT_TRUE(Solve(hurried).IsSolved());

  redesign::RedesignProblem impossible = Problem();
  impossible.design.limits["min_moment_arm_mm"] = 70;
  impossible.max_misalignment_percent = 20;
  EXPECT_THAT(redesign::ExplainInfeasible(impossible, links, Starts(2)).sentence, HasSubstr("moment arm"));
}

TEST(Redesign, RequirementsOverTheUsedRangeHoldTogetherWithTheLimit) {
  redesign::RedesignProblem problem = Free(16);
  problem.design.limits["min_moment_arm_mm"] = 15;
  problem.design.limits["max_force_n"] = 2500;
  problem.max_misalignment_percent = TightLimit(problem);
  const redesign::RedesignResult result = Solve(problem);
  ASSERT_TRUE(result.IsSolved());
  EXPECT_TRUE(problem::Evaluate(result.Best().Point().links, problem.design).IsFeasible());
  EXPECT_LE(result.Best().Misalignment_percent(), *problem.max_misalignment_percent * (1 + 1e-5));
}

// With time enough to follow the knee exactly, where the joint sits is a matter of taste within the limit: the knee.
TEST(Redesign, OfEqualDesignsTheJointNearestToTheKneeIsTaken) {
  redesign::RedesignProblem problem = Free(60);
  problem.fit_placement = true;
  problem.placement_mm = {18, 32};  // where it was worn
  problem.max_misalignment_percent = 4;
  const redesign::RedesignResult result = Solve(problem);
  ASSERT_TRUE(result.IsSolved());
  const redesign::RedesignPoint nearest = redesign::NearestToKnee(problem, result.Best());
  EXPECT_LT(nearest.placement_mm.norm(), 1);
  EXPECT_NEAR(problem::Evaluate(nearest.links, problem.design).range_deg, result.Best().Range_deg(),
              1.001 * redesign::kEqualRange_deg);
  const double percent = 100 * redesign::PredictPoint(problem, nearest)->path.relative;
  EXPECT_LE(percent, result.Best().Misalignment_percent() + 1.001 * redesign::kEqualMisalignment_percent);
  // 4 % of the shank of 420 mm: the joint alone may be 16.8 mm off, a little more or less as the program gives way.
  const auto range = redesign::FindPlacementRange(problem, nearest);
  ASSERT_TRUE(range);
  EXPECT_EQ(range->within_percent, 4);
  EXPECT_LT(range->x_mm.lower, -16);
  EXPECT_GT(range->x_mm.upper, 16);
  EXPECT_NEAR(range->y_mm.upper, 17, 2);
}

// A slipped mount on an unlike leg: no place on a grid about it is better.
TEST(Redesign, TheBestPlacementOfADesignHasTheLeastMisalignment) {
  for (const ClosedFormLeg& leg : Legs()) {
    redesign::RedesignProblem problem = Free(15, leg);
    problem.fit_placement = true;
    problem.max_misalignment_percent = 5;
    for (redesign::HumanSample& sample : problem.human) sample.slip_mm = {6, -3};
    const compare::StsCurve human = MakeCurve(leg);
    linkage::Design worn;
    worn.links = kPublishedLinks;
    worn.program = linkage::StrokeProgram{Kind::kConstant, 5, {}};
    worn.placement_mm = {15, 20};
    const auto misalignment = [&](const Eigen::Vector2d& placement) {
      linkage::Design design = worn;
      design.placement_mm = {placement.x(), placement.y()};
      return redesign::PutInMotion(problem, human, design).misalignment->metrics.relative_rms;
    };
    const auto best = redesign::BestPlacement(problem, redesign::PutInMotion(problem, human, worn));
    ASSERT_TRUE(best);
    const double least = misalignment(*best);
    EXPECT_LT(least, misalignment({15, 20}));
    for (const double x : {-2.0, -0.1, 0.0, 0.1, 2.0})
      for (const double y : {-2.0, -0.1, 0.0, 0.1, 2.0}) EXPECT_GE(misalignment(*best + Eigen::Vector2d(x, y)), least);
    problem.placement_reach_mm = 5;  // the optimum lies beyond
    const auto within = redesign::BestPlacement(problem, redesign::PutInMotion(problem, human, worn));
    EXPECT_LE(within->cwiseAbs().maxCoeff(), 5);
  }
}

TEST(Redesign, RefusesSenselessOptions) {
  const auto refuses = [](const std::function<void(redesign::RedesignProblem&)>& change) {
    redesign::RedesignProblem problem = Problem();
    change(problem);
    EXPECT_THROW(problem.Check(), UsageError);
  };
  refuses([](auto& p) { p.program.max_speed_mm_s = 0; });
  refuses([](auto& p) { p.program.duration_s = NAN; });
  refuses([](auto& p) { p.program.knots = 20; });
  refuses([](auto& p) { p.program.knots = 102; });
  refuses([](auto& p) { p.max_misalignment_percent = 0; });
  refuses([](auto& p) { p.penalty_deg_per_mm = -1; });
  refuses([](auto& p) { p.placement_reach_mm = INFINITY; });
  EXPECT_THROW(redesign::ParetoFront(Problem(), 1, {}, {}), UsageError);
}

}  // namespace
}  // namespace lake
