#include "lake/redesign/group.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/processes.h"
#include "lake/core/threads.h"
#include "lake/core/uncertain_text.h"

namespace lake::redesign {

// From one process to another.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GroupDesign, nearest, reason, starts, usable_starts, counts)

namespace {

using Goal = RedesignProblem::Goal;
using Starts = std::vector<linkage::Links>;

GroupProblem WithGoal(GroupProblem problem, Goal goal) {
  problem.shared = WithGoal(problem.shared, goal);
  return problem;
}

// From these links, then from random ones, a few at a time: few enough that none is for nothing, and the same number
// whatever the machine, as what follows depends on all of them. Where no start of the first few is usable the limit
// cannot be held, or hardly: the least misalignment says more than further starts.
synthesis::MultiStart<RedesignEnd> FindBest(const GroupProblem& problem, const Starts& links,
                                            const synthesis::OptimizeOptions& options, const char* what) {
  constexpr std::size_t kBatch = 4;
  const Starts starts = synthesis::StartsOf(problem.shared.design, links, options.starts, options.seed);
  Progress progress(what, "starts", options.starts, options.quiet);
  synthesis::MultiStart<RedesignEnd> search;
  while (true) {
    const std::size_t first = search.starts.size(), count = std::min(kBatch, starts.size() - first);
    const bool is_hopeless = first > 0 && !search.IsSolved();
    if (count == 0 || is_hopeless || search.HasAllOptima()) return search;
    const auto solve = [&](std::size_t i) -> RedesignEnd {
      return SolveFrom(problem, StartPoints(problem, starts[first + i]), options);
    };
    for (RedesignEnd& end : ResultsInProcesses(count, solve, progress)) search.Add(std::move(end));
  }
}

std::vector<double> Misalignments_percent(const GroupProblem& problem, const std::vector<RedesignPoint>& points) {
  std::vector<double> of_people;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto prediction = PredictPoint(problem.Of(i), points[i]);
    of_people.push_back(prediction ? kMisalignment.value(*prediction) : kInfinity);
  }
  return of_people;
}

// Those whose misalignment costs most do not count any more; `count` of them.
void LeaveOut(std::size_t count, const RedesignEnd& end, GroupProblem& problem) {
  const std::vector<double> percent = Misalignments_percent(problem, end.points);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < problem.people.size(); ++i)
    if (problem.people[i].counts) order.push_back(i);
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) {
    constexpr double kNoMultiplier = 1e-6;  // of the solver's rounding
    return std::pair(end.multipliers[i] > kNoMultiplier ? end.multipliers[i] : 0, percent[i]);
  });
  for (std::size_t k = 0; k < count; ++k) problem.people[order[k]].counts = false;
}

// Whose misalignment counts in a quantile: of all, those are left out whose limits cost most (the greedy discarding of
// constraints of Campi & Garatti, J. Optim. Theory Appl. 148, 2011).
void ChooseCounting(const Starts& links, const synthesis::OptimizeOptions& options, GroupProblem& problem) {
  constexpr std::size_t kRounds = 10;
  std::size_t left = problem.people.size() - problem.Counting();
  if (left == 0) return;
  RedesignEnd all = FindBest(problem, links, options, "design for all").TakeBestOrFirst();
  for (std::size_t round = 0; left > 0; ++round) {
    ThrowIfInterrupted();
    RedesignEnd end = all;
    if (round > 0) end = SolveFrom(problem, all.points, options, true);
    if (!end.IsUsable()) end = SolveFrom(WithGoal(problem, Goal::kMisalignment), all.points, options);
    const std::size_t rounds = std::max<std::size_t>(1, kRounds - std::min(round, kRounds));
    const std::size_t count = (left + rounds - 1) / rounds;
    LeaveOut(count, end, problem);
    left -= count;
    if (end.IsUsable()) all = std::move(end);
  }
}

// Of the goal, for one person.
std::optional<double> ObjectiveFor(const RedesignProblem& problem, const DesignInMotion& design) {
  if (!design.prediction) return std::nullopt;
  return design.evaluation.range_deg - problem.penalty_deg_per_mm * design.prediction->Rms().mm;
}

// Of those whose misalignment is the largest, or holds the design.
std::string NamesOfBlocking(const GroupProblem& problem, const std::vector<double>& multipliers) {
  std::vector<std::string> names;
  constexpr double kShare = 0.05;  // of all multipliers
  const double all = std::accumulate(multipliers.begin(), multipliers.end(), 0.0);
  for (std::size_t i = 0; i < multipliers.size(); ++i)
    if (multipliers[i] > kShare * all) names.push_back(problem.people[i].name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string AcrossText(const GroupProblem& problem) {
  if (problem.across == Across::kMean) return "the mean misalignment";
  if (problem.across == Across::kWorst) return "the worst misalignment";
  return fmt::format("the worst misalignment of {} of {} people", problem.Counting(), problem.people.size());
}

// Why no design holds the limit, of which this one has the least misalignment.
std::string WhyNone(const GroupProblem& problem, const RedesignEnd& nearest) {
  const std::size_t people = problem.people.size();
  if (!nearest.IsUsable()) return fmt::format("no design was found that {} people can wear", people);
  const double least = problem.Combine(Misalignments_percent(problem, nearest.points));
  const std::optional<double>& limit = problem.shared.max_misalignment_percent;
  if (limit && least <= *limit)
    return fmt::format(
        "the largest range of a design for {} people was not found, although {} can be as small as {} %; without "
        "margins an optimum need not be unique: set --grashof-margin and --singularity-margin, or more --starts",
        people, AcrossText(problem), SignificantText(least, 4));
  return fmt::format(
      "no design for {} people keeps {} within {} %: the least found is {} %, and {} hold it there; allow "
      "more, more time or a free program, fit the placement, or make more sizes",
      people, AcrossText(problem), SignificantText(limit.value_or(0), 6), SignificantText(least, 4),
      NamesOfBlocking(problem, nearest.multipliers));
}

void TakeBest(synthesis::MultiStart<RedesignEnd> search, GroupDesign& design) {
  design.starts = static_cast<int>(search.starts.size());
  design.usable_starts = search.Usable();
  design.nearest = search.TakeBestOrFirst();
}

// The solution with few samples of the motions is close by. Of large groups from the given links alone: of all groups
// measured the starts that succeed met one optimum, and a random start that wanders fills gigabytes.
void FindCloseBy(synthesis::OptimizeOptions options, DesignTask& task) {
  constexpr std::size_t kLarge = 20;
  const std::vector<Subject>& people = task.problem.people;
  if (!task.close_by.empty() || people.size() < kLarge || people.front().human.size() < compare::kPercentSamples)
    return;
  options.starts = std::min(options.starts, static_cast<int>(task.links.size()));
  GroupDesign coarse;
  TakeBest(FindBest(Coarse(task.problem), task.links, options, "design for all"), coarse);
  if (!coarse.nearest.IsUsable()) return;
  task.starts = coarse.starts;
  task.usable_starts = coarse.usable_starts;
  task.close_by = std::move(coarse.nearest.points);
}

// Where the solution of a problem close by leads; unusable without one.
RedesignEnd SolveFromCloseBy(const DesignTask& task, synthesis::OptimizeOptions options) {
  constexpr int kMostIterations = 60;  // those that lead to a solution take fewer; the rest begin anew: quicker
  options.nlp.max_iterations = std::min(options.nlp.max_iterations, kMostIterations);
  if (task.close_by.empty()) return {};
  return SolveFrom(task.problem, task.close_by, options, true);
}

// From close by, or from all starts; where no start holds the limit from the least misalignment.
GroupDesign DesignOne(DesignTask task, const synthesis::OptimizeOptions& options) {
  ChooseCounting(task.links, options, task.problem);
  FindCloseBy(options, task);
  GroupDesign design{.nearest = SolveFromCloseBy(task, options),
                     .reason = "",
                     .starts = task.starts,
                     .usable_starts = task.usable_starts,
                     .counts = {}};
  for (const Subject& person : task.problem.people) design.counts.push_back(person.counts);
  if (!design.nearest.IsUsable()) TakeBest(FindBest(task.problem, task.links, options, "design for all"), design);
  if (design.nearest.IsUsable()) return design;
  TakeBest(FindBest(WithGoal(task.problem, Goal::kMisalignment), task.links, options, "least misalignment"), design);
  RedesignEnd end = SolveFrom(task.problem, design.nearest.points, options, true);
  if (!end.IsUsable()) {
    design.reason = WhyNone(task.problem, design.nearest);
    return design;
  }
  design.nearest = std::move(end);
  ++design.starts;
  design.usable_starts = 1;
  return design;
}

}  // namespace

std::vector<RedesignPoint> StartPoints(const GroupProblem& problem, const linkage::Links& links) {
  std::vector<RedesignPoint> points;
  for (std::size_t i = 0; i < problem.people.size(); ++i) points.push_back(StartPoint(problem.Of(i), links));
  return points;
}

DesignTask TaskOf(GroupProblem shared, const std::vector<PersonMeasured>& people,
                  const synthesis::OptimizeOptions& options) {
  shared.CheckOptions();
  shared.people.clear();
  DesignTask task{.problem = std::move(shared)};
  const problem::SynthesisProblem& design = task.problem.shared.design;
  task.links = {design.start};
  const auto start_at = [&](const linkage::Links& links) {
    if (std::ranges::none_of(task.links, [&](const auto& known) { return known.Values() == links.Values(); }))
      task.links.push_back(links);
  };
  for (const PersonMeasured& person : people) {
    try {
      const RedesignProblem own = PutMotionInto(task.problem.shared, person.motion).problem;
      task.problem.people.push_back({person.name, own.human, own.placement_mm});
    } catch (const UsageError&) {
      throw;
    } catch (const Error& error) {
      throw Fail("{}: {}", person.name, error.what());
    }
    task.human.push_back(person.motion.human);
  }
  if (const synthesis::LocalSolve widest = SolveFrom(design, design.start, options); widest.IsUsable())
    start_at(widest.end);
  for (const PersonMeasured& person : people)
    if (person.motion.worn) start_at(person.motion.worn->links);
  return task;
}

GroupProblem Coarse(GroupProblem problem) {
  constexpr std::size_t kSteps[] = {5, 4, 2};
  const auto knots = static_cast<std::size_t>(problem.shared.program.knots);
  const auto step = std::ranges::find_if(kSteps, [&](std::size_t of) { return 100 / of + 1 >= knots; });
  if (step == std::end(kSteps)) return problem;
  for (Subject& person : problem.people) person.human = Thinned(person.human, *step);
  return problem;
}

std::vector<RedesignEnd> OwnDesigns(const GroupProblem& problem, const std::vector<linkage::Links>& links,
                                    const synthesis::OptimizeOptions& options) {
  Progress progress("design for each alone", "people", static_cast<std::int64_t>(problem.people.size()), options.quiet);
  return ResultsInProcesses(
      problem.people.size(),
      [&](std::size_t i) -> RedesignEnd {
        auto optimum = FindOptimum(problem.Of(i), links, options);
        return optimum ? std::move(*optimum) : RedesignEnd{};
      },
      progress);
}

PersonOutcome OutcomeOf(const GroupOutcome& outcome, std::size_t i, const RedesignEnd& own) {
  const RedesignProblem problem = outcome.problem.Of(i);
  const auto put_in_motion = [&](const RedesignPoint& point) {
    return PutInMotion(problem, outcome.human[i], DesignOf(problem, point));
  };
  PersonOutcome person{.name = outcome.problem.people[i].name,
                       .with_group = put_in_motion(outcome.nearest.points[i]),
                       .counts = outcome.problem.people[i].counts,
                       .multiplier = outcome.nearest.multipliers.empty() ? 0 : outcome.nearest.multipliers[i],
                       .own = {},
                       .cost_deg = {}};
  if (!own.IsUsable()) return person;
  person.own = put_in_motion(own.Point());
  const auto with_group = ObjectiveFor(problem, person.with_group);
  const auto alone = ObjectiveFor(problem, *person.own);
  if (with_group && alone) person.cost_deg = *alone - *with_group;
  return person;
}

double GroupOutcome::Misalignment_percent() const {
  return problem.Combine(Misalignments_percent(problem, nearest.points));
}

std::vector<GroupOutcome> DesignGroups(std::vector<DesignTask> tasks, const synthesis::OptimizeOptions& options) {
  options.Check();
  for (const DesignTask& task : tasks) task.problem.Check();
  const auto count = static_cast<int>(tasks.size());
  synthesis::OptimizeOptions of_one = options;
  of_one.quiet = options.quiet || count > 1;
  const auto design_one = [&, threads = std::max(1, Threads() / std::max(1, count))](std::size_t k) {
    SetThreads(threads);
    return DesignOne(tasks[k], of_one);
  };
  Progress progress("design for all", "groups", count, options.quiet || count == 1);
  std::vector<GroupOutcome> outcomes;
  for (GroupDesign& design : ResultsInProcesses(tasks.size(), design_one, progress)) {
    DesignTask& task = tasks[outcomes.size()];
    for (std::size_t i = 0; i < design.counts.size(); ++i) task.problem.people[i].counts = design.counts[i];
    const problem::DesignEvaluation evaluation = problem::Evaluate(design.nearest.Links(), task.problem.shared.design);
    outcomes.push_back({std::move(design), std::move(task.problem), std::move(task.human), evaluation, {}});
  }
  return outcomes;
}

GroupOutcome RunGroup(const GroupProblem& shared, const std::vector<PersonMeasured>& people,
                      const synthesis::OptimizeOptions& options) {
  const DesignTask task = TaskOf(shared, people, options);
  GroupOutcome outcome = DesignGroups({task}, options).front();
  std::vector<linkage::Links> links = task.links;
  links.insert(links.begin(), outcome.nearest.Links());
  const std::vector<RedesignEnd> own = OwnDesigns(task.problem, links, options);
  for (std::size_t i = 0; i < people.size(); ++i) outcome.people.push_back(OutcomeOf(outcome, i, own[i]));
  return outcome;
}

}  // namespace lake::redesign
