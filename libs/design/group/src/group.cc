#include "lake/group/group.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/processes.h"
#include "lake/core/progress.h"
#include "lake/core/uncertain_text.h"

namespace lake::group {

// From one process to another.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GroupDesign, points, multipliers, pulls, objective, is_usable)

namespace {

using redesign::GroupProblem;
using redesign::GroupSolve;
using redesign::RedesignPoint;
using redesign::RedesignProblem;
using Goal = RedesignProblem::Goal;
using Search = synthesis::MultiStart<GroupDesign>;
using Starts = std::vector<linkage::Links>;

// The end of a local solve.
GroupDesign EndOf(GroupSolve solve) {
  return {.points = std::move(solve.points),
          .multipliers = std::move(solve.multipliers),
          .pulls = std::move(solve.pulls),
          .objective = solve.objective,
          .is_usable = solve.IsUsable()};
}

GroupProblem WithGoal(GroupProblem problem, Goal goal) {
  problem.shared = redesign::WithGoal(problem.shared, goal);
  return problem;
}

Starts StartsOf(const GroupProblem& problem, const Starts& links, const synthesis::OptimizeOptions& options) {
  return synthesis::StartsOf(problem.shared.design, links, options.starts, options.seed);
}

// A local solve that does not wait for another.
struct Piece {
  const GroupProblem* problem;
  std::vector<RedesignPoint> start;  // empty: nothing to be solved
  bool warm = false;
};

// Of each piece; unusable where there was nothing to be solved.
std::vector<GroupDesign> SolveAll(const std::vector<Piece>& pieces, const synthesis::OptimizeOptions& options,
                                  Progress& progress) {
  std::vector<std::size_t> given;
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (!pieces[i].start.empty()) given.push_back(i);
  std::vector<GroupDesign> ends = ResultsInProcesses(
      given.size(),
      [&](std::size_t i) {
        const Piece& piece = pieces[given[i]];
        return EndOf(SolveFrom(*piece.problem, piece.start, options, piece.warm));
      },
      progress);
  std::vector<GroupDesign> designs(pieces.size());
  for (std::size_t i = 0; i < given.size(); ++i) designs[given[i]] = std::move(ends[i]);
  return designs;
}

std::vector<GroupDesign> SolveWarm(const std::vector<Piece>& pieces, const synthesis::OptimizeOptions& options,
                                   const char* what) {
  const auto count = std::ranges::count_if(pieces, [](const Piece& piece) { return !piece.start.empty(); });
  Progress progress(what, "solves", count, options.quiet);
  return SolveAll(pieces, options, progress);
}

// Starts of one problem that are solved at the same time: few enough that none is for nothing, and the same number
// whatever the machine, as what follows depends on all of them.
constexpr std::size_t kBatch = 4;

// The next starts of a problem. Where no start of the first few is usable the limit cannot be held, or hardly: the
// least misalignment tells more than further starts.
Starts NextStarts(const Search& search, const Starts& starts) {
  const bool is_hopeless = !search.starts.empty() && !search.IsSolved();
  if (is_hopeless || search.HasAllOptima()) return {};
  const auto first = starts.begin() + static_cast<std::ptrdiff_t>(search.starts.size());
  return {first, first + std::min<std::ptrdiff_t>(kBatch, starts.end() - first)};
}

// A problem with its own starts; none: nothing to be searched.
struct SearchTask {
  GroupProblem problem;
  Starts starts;
};

// The tasks do not wait for each other.
std::vector<Search> FindBestOfEach(const std::vector<SearchTask>& tasks, const synthesis::OptimizeOptions& options,
                                   const std::string& what) {
  std::size_t count = 0;
  for (const SearchTask& task : tasks) count += task.starts.size();
  Progress progress(what, "starts", static_cast<std::int64_t>(count), options.quiet);
  std::vector<Search> searches(tasks.size());
  for (;;) {
    std::vector<Piece> pieces;
    std::vector<std::size_t> of;
    for (std::size_t k = 0; k < tasks.size(); ++k)
      for (const linkage::Links& start : NextStarts(searches[k], tasks[k].starts)) {
        pieces.push_back({&tasks[k].problem, StartPoints(tasks[k].problem, start)});
        of.push_back(k);
      }
    if (pieces.empty()) return searches;
    std::vector<GroupDesign> ends = SolveAll(pieces, options, progress);
    for (std::size_t i = 0; i < ends.size(); ++i) searches[of[i]].Add(std::move(ends[i]));
  }
}

std::vector<double> Misalignments_percent(const GroupProblem& problem, const std::vector<RedesignPoint>& points) {
  std::vector<double> of_people;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto prediction = redesign::PredictPoint(problem.Of(i), points[i]);
    of_people.push_back(prediction ? redesign::kMisalignment.value(*prediction) : kInfinity);
  }
  return of_people;
}

// Those whose misalignment costs most do not count any more; `count` of them.
void LeaveOut(std::size_t count, const GroupDesign& end, GroupProblem& problem) {
  const std::vector<double> percent = Misalignments_percent(problem, end.points);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < problem.people.size(); ++i)
    if (problem.people[i].counts) order.push_back(i);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    constexpr double kNoMultiplier = 1e-6;  // of the solver's rounding
    const double multiplier_a = end.multipliers[a] > kNoMultiplier ? end.multipliers[a] : 0;
    const double multiplier_b = end.multipliers[b] > kNoMultiplier ? end.multipliers[b] : 0;
    return std::pair(multiplier_a, percent[a]) > std::pair(multiplier_b, percent[b]);
  });
  for (std::size_t k = 0; k < count; ++k) problem.people[order[k]].counts = false;
}

// Whose misalignment counts in a quantile: of all, those are left out whose limits cost most (the greedy discarding of
// constraints of Campi & Garatti, J. Optim. Theory Appl. 148, 2011).
void ChooseCounting(const Starts& links, const synthesis::OptimizeOptions& options, GroupProblem& problem) {
  constexpr std::size_t kRounds = 10;
  std::size_t left = problem.people.size() - problem.Counting();
  if (left == 0) return;
  GroupDesign all = FindBestOfEach({{problem, StartsOf(problem, links, options)}}, options, "design for all")
                        .front()
                        .TakeBestOrFirst();
  for (std::size_t round = 0; left > 0; ++round) {
    ThrowIfInterrupted();
    GroupDesign end = all;
    if (round > 0) end = EndOf(SolveFrom(problem, all.points, options, true));
    if (!end.IsUsable()) end = EndOf(SolveFrom(WithGoal(problem, Goal::kMisalignment), all.points, options));
    const std::size_t rounds = std::max<std::size_t>(1, kRounds - std::min(round, kRounds));
    const std::size_t count = (left + rounds - 1) / rounds;
    LeaveOut(count, end, problem);
    left -= count;
    if (end.IsUsable()) all = std::move(end);
  }
}

GroupDesign DesignOf(GroupDesign end, int starts, int usable_starts) {
  end.starts = starts;
  end.usable_starts = usable_starts;
  return end;
}

GroupDesign DesignOf(Search search) {
  const int starts = static_cast<int>(search.starts.size());
  const int usable_starts = search.Usable();
  return DesignOf(search.TakeBestOrFirst(), starts, usable_starts);
}

// Of the goal, for one person.
std::optional<double> ObjectiveFor(const RedesignProblem& problem, const redesign::DesignInMotion& design) {
  if (!design.prediction) return std::nullopt;
  return design.evaluation.range_deg - problem.penalty_deg_per_mm * design.prediction->Rms().mm;
}

// Of those whose misalignment is the largest, or holds the design.
std::string NamesOfBlocking(const GroupOutcome& outcome) {
  std::vector<std::string> names;
  constexpr double kShare = 0.05;  // of all multipliers
  const std::vector<double>& multipliers = outcome.nearest.multipliers;
  const double all = std::accumulate(multipliers.begin(), multipliers.end(), 0.0);
  for (std::size_t i = 0; i < multipliers.size(); ++i)
    if (multipliers[i] > kShare * all) names.push_back(outcome.problem.people[i].name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string AcrossText(const GroupProblem& problem) {
  if (problem.across == redesign::Across::kMean) return "the mean misalignment";
  if (problem.across == redesign::Across::kWorst) return "the worst misalignment";
  return fmt::format("the worst misalignment of {} of {} people", problem.Counting(), problem.people.size());
}

std::string WhyNone(const GroupOutcome& outcome) {
  const GroupProblem& problem = outcome.problem;
  if (!outcome.nearest.IsUsable())
    return fmt::format("no design was found that {} people can wear", problem.people.size());
  if (problem.shared.max_misalignment_percent &&
      outcome.Misalignment_percent() <= *problem.shared.max_misalignment_percent)
    return fmt::format(
        "the largest range of a design for {} people was not found, although {} can be as small as {} %; without "
        "margins an optimum need not be unique: set --grashof-margin and --singularity-margin, or more --starts",
        problem.people.size(), AcrossText(problem), SignificantText(outcome.Misalignment_percent(), 4));
  return fmt::format(
      "no design for {} people keeps {} within {} %: the least found is {} %, and {} hold it there; allow "
      "more, more time or a free program, fit the placement, or make more sizes",
      problem.people.size(), AcrossText(problem),
      SignificantText(problem.shared.max_misalignment_percent.value_or(0), 6),
      SignificantText(outcome.Misalignment_percent(), 4), NamesOfBlocking(outcome));
}

// The least misalignments, where no start held the limit; from there the designs once more.
void SolveFromNearest(const std::vector<DesignTask>& tasks, const synthesis::OptimizeOptions& options,
                      std::vector<GroupOutcome>& outcomes) {
  if (std::ranges::all_of(outcomes, &GroupOutcome::IsSolved)) return;
  std::vector<SearchTask> least(outcomes.size());
  std::vector<Piece> pieces(outcomes.size());
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    if (outcomes[k].IsSolved()) continue;
    least[k].problem = WithGoal(outcomes[k].problem, Goal::kMisalignment);
    least[k].starts = StartsOf(least[k].problem, tasks[k].links, options);
  }
  std::vector<Search> searches = FindBestOfEach(least, options, "least misalignment");
  for (std::size_t k = 0; k < outcomes.size(); ++k)
    if (!outcomes[k].IsSolved()) pieces[k] = {&outcomes[k].problem, searches[k].BestOrFirst().points, true};
  std::vector<GroupDesign> ends = SolveWarm(pieces, options, "from the least misalignment");
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    GroupOutcome& outcome = outcomes[k];
    if (outcome.IsSolved()) continue;
    outcome.nearest = DesignOf(std::move(searches[k]));
    if (ends[k].IsUsable()) {
      outcome.nearest = DesignOf(std::move(ends[k]), outcome.nearest.starts + 1, 1);
      outcome.design = outcome.nearest;
    } else {
      outcome.reason = WhyNone(outcome);
    }
  }
}

// The solution with few samples of the motions is close by. Of large groups from the given links alone: of all groups
// measured the starts that succeed met one optimum, and a random start that wanders fills gigabytes.
void FindCloseBy(const synthesis::OptimizeOptions& options, std::vector<DesignTask>& tasks) {
  constexpr std::size_t kLarge = 20;
  std::vector<SearchTask> coarse(tasks.size());
  for (std::size_t k = 0; k < tasks.size(); ++k) {
    const std::vector<redesign::Subject>& people = tasks[k].problem.people;
    if (!tasks[k].close_by.empty() || people.size() < kLarge || people.front().human.size() < compare::kPercentSamples)
      continue;
    synthesis::OptimizeOptions given = options;
    given.starts = std::min(options.starts, static_cast<int>(tasks[k].links.size()));
    coarse[k].problem = Coarse(tasks[k].problem);
    coarse[k].starts = StartsOf(coarse[k].problem, tasks[k].links, given);
  }
  std::vector<Search> searches = FindBestOfEach(coarse, options, "design for all");
  for (std::size_t k = 0; k < tasks.size(); ++k) {
    if (!searches[k].IsSolved()) continue;
    tasks[k].starts = static_cast<int>(searches[k].starts.size());
    tasks[k].usable_starts = searches[k].Usable();
    tasks[k].close_by = searches[k].TakeBestOrFirst().points;
  }
}

// Where the solutions of problems close by lead.
std::vector<GroupDesign> DesignsFromCloseBy(const std::vector<DesignTask>& tasks, synthesis::OptimizeOptions options) {
  constexpr int kMostIterations = 60;  // those that lead to a solution take fewer; the rest begin anew: quicker
  options.nlp.max_iterations = std::min(options.nlp.max_iterations, kMostIterations);
  std::vector<Piece> pieces;
  for (const DesignTask& task : tasks) pieces.push_back({&task.problem, task.close_by, true});
  std::vector<GroupDesign> designs = SolveWarm(pieces, options, "from the designs before");
  for (std::size_t k = 0; k < tasks.size(); ++k)
    designs[k] = DesignOf(std::move(designs[k]), tasks[k].starts, tasks[k].usable_starts);
  return designs;
}

}  // namespace

std::vector<RedesignPoint> StartPoints(const GroupProblem& problem, const linkage::Links& links) {
  std::vector<RedesignPoint> points;
  for (std::size_t i = 0; i < problem.people.size(); ++i) points.push_back(redesign::StartPoint(problem.Of(i), links));
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
      const RedesignProblem own = redesign::PutMotionInto(task.problem.shared, person.motion).problem;
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
  for (redesign::Subject& person : problem.people) person.human = Thinned(person.human, *step);
  return problem;
}

std::vector<std::optional<RedesignPoint>> OwnPoints(const GroupProblem& problem,
                                                    const std::vector<linkage::Links>& links,
                                                    const synthesis::OptimizeOptions& options) {
  Progress progress("design for each alone", "people", static_cast<std::int64_t>(problem.people.size()), options.quiet);
  const auto optima = ResultsInProcesses(
      problem.people.size(),
      [&](std::size_t i) {
        const auto optimum = redesign::FindOptimum(problem.Of(i), links, options);
        return optimum ? std::vector{optimum->point} : std::vector<RedesignPoint>();
      },
      progress);
  std::vector<std::optional<RedesignPoint>> points;
  for (const std::vector<RedesignPoint>& optimum : optima)
    points.push_back(optimum.empty() ? std::nullopt : std::optional(optimum.front()));
  return points;
}

PersonOutcome OutcomeOf(const GroupOutcome& outcome, std::size_t i, const std::optional<RedesignPoint>& own) {
  const RedesignProblem problem = outcome.problem.Of(i);
  const auto put_in_motion = [&](const RedesignPoint& point) {
    return redesign::PutInMotion(problem, outcome.human[i], redesign::DesignOf(problem, point));
  };
  PersonOutcome person{.name = outcome.problem.people[i].name,
                       .with_group = put_in_motion(outcome.nearest.points[i]),
                       .counts = outcome.problem.people[i].counts,
                       .multiplier = outcome.nearest.multipliers.empty() ? 0 : outcome.nearest.multipliers[i],
                       .own = {},
                       .cost_deg = {}};
  if (!own) return person;
  person.own = put_in_motion(*own);
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
  for (DesignTask& task : tasks) {
    task.problem.Check();
    ChooseCounting(task.links, options, task.problem);
  }
  FindCloseBy(options, tasks);
  std::vector<GroupDesign> designs = DesignsFromCloseBy(tasks, options);
  std::vector<SearchTask> searched(tasks.size());
  for (std::size_t k = 0; k < tasks.size(); ++k)
    if (!designs[k].IsUsable()) searched[k] = {tasks[k].problem, StartsOf(tasks[k].problem, tasks[k].links, options)};
  std::vector<Search> searches = FindBestOfEach(searched, options, "design for all");
  std::vector<GroupOutcome> outcomes(tasks.size());
  for (std::size_t k = 0; k < tasks.size(); ++k) {
    GroupOutcome& outcome = outcomes[k];
    outcome.problem = tasks[k].problem;
    outcome.human = tasks[k].human;
    outcome.nearest = designs[k].IsUsable() ? std::move(designs[k]) : DesignOf(std::move(searches[k]));
    if (outcome.nearest.IsUsable()) outcome.design = outcome.nearest;
  }
  SolveFromNearest(tasks, options, outcomes);
  for (GroupOutcome& outcome : outcomes)
    outcome.evaluation = problem::Evaluate(outcome.nearest.Links(), outcome.problem.shared.design);
  return outcomes;
}

GroupOutcome RunGroup(const GroupProblem& shared, const std::vector<PersonMeasured>& people,
                      const synthesis::OptimizeOptions& options) {
  const DesignTask task = TaskOf(shared, people, options);
  GroupOutcome outcome = DesignGroups({task}, options).front();
  std::vector<linkage::Links> links = task.links;
  links.insert(links.begin(), outcome.nearest.Links());
  const std::vector<std::optional<RedesignPoint>> own = OwnPoints(task.problem, links, options);
  for (std::size_t i = 0; i < people.size(); ++i) outcome.people.push_back(OutcomeOf(outcome, i, own[i]));
  return outcome;
}

}  // namespace lake::group
