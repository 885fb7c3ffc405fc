#include "lake/redesign/group.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "group_parts.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/processes.h"
#include "lake/core/progress.h"
#include "point_json.h"

namespace lake::redesign {
namespace {

using Goal = ReoptimizeProblem::Goal;

// An end of a group's local solve, as it comes from another process.
struct End {
  std::vector<ReoptimizePoint> points;
  std::vector<double> prices, pulls;
  double objective = 0;
  bool is_usable = false;

  bool IsBetterThan(const End& other) const {
    constexpr double kBetter = 1e-5;  // of equals the first is kept
    return is_usable && (!other.is_usable || objective > other.objective + kBetter);
  }
};

End EndOf(GroupSolve solve) {
  const bool is_usable = solve.IsUsable();
  return {std::move(solve.points), std::move(solve.prices), std::move(solve.pulls), solve.objective, is_usable};
}

std::string Packed(const End& end) {
  nlohmann::json points = nlohmann::json::array();
  for (const ReoptimizePoint& point : end.points) points.push_back(JsonOf(point));
  const nlohmann::json packed = {{"points", points},
                                 {"prices", end.prices},
                                 {"pulls", end.pulls},
                                 {"objective", end.objective},
                                 {"is_usable", end.is_usable}};
  return packed.dump();
}

End Unpacked(const std::string& text) {
  const nlohmann::json packed = nlohmann::json::parse(text);
  End end;
  for (const nlohmann::json& point : packed.at("points")) end.points.push_back(PointOf(point));
  packed.at("prices").get_to(end.prices);
  packed.at("pulls").get_to(end.pulls);
  packed.at("objective").get_to(end.objective);
  packed.at("is_usable").get_to(end.is_usable);
  return end;
}

GroupProblem WithGoal(GroupProblem problem, Goal goal) {
  problem.shared = WithGoal(problem.shared, goal);
  return problem;
}

}  // namespace

std::vector<ReoptimizePoint> StartPoints(const GroupProblem& problem, const linkage::Links& links) {
  std::vector<ReoptimizePoint> points;
  for (std::size_t i = 0; i < problem.people.size(); ++i) points.push_back(StartPoint(problem.Of(i), links));
  return points;
}

namespace {

// A local solve that does not wait for another.
struct Piece {
  const GroupProblem* problem;
  std::vector<ReoptimizePoint> start;
  bool warm = false;
};

std::vector<End> SolveAll(const std::vector<Piece>& pieces, const synthesis::OptimizeOptions& options,
                          Progress& progress) {
  const std::vector<std::string> packed = InProcesses(
      pieces.size(),
      [&](std::size_t i, const std::function<void()>& step) {
        const End end = EndOf(SolveFrom(*pieces[i].problem, pieces[i].start, options, pieces[i].warm));
        step();
        return Packed(end);
      },
      progress);
  std::vector<End> ends;
  for (const std::string& text : packed) ends.push_back(Unpacked(text));
  return ends;
}

// The best of the ends from many starts.
struct Search {
  End best;
  int starts = 0, usable_starts = 0;
  Optima optima;

  void Add(End end) {
    optima.Add(end.is_usable, end.objective);
    ++starts, usable_starts += end.is_usable;
    if (starts == 1 || end.IsBetterThan(best)) best = std::move(end);
  }
};

// Starts of one problem that are solved at the same time: few enough that none is for nothing, and the same number
// whatever the machine, as what follows depends on all of them.
constexpr std::size_t kBatch = 4;

// The next starts of a problem. Where no start of the first few is usable the limit cannot be held, or hardly: the
// least misalignment tells more than further starts.
std::vector<linkage::Links> NextStarts(const Search& search, const std::vector<linkage::Links>& starts) {
  const bool is_hopeless = search.starts > 0 && search.usable_starts == 0;
  if (is_hopeless || search.optima.AreAll()) return {};
  const auto first = starts.begin() + search.starts;
  return {first, first + std::min<std::ptrdiff_t>(kBatch, starts.end() - first)};
}

synthesis::OptimizeOptions WithIterations(synthesis::OptimizeOptions options, int most) {
  options.nlp.max_iterations = std::min(options.nlp.max_iterations, most);
  return options;
}

// Of each problem, from its own starts. They do not wait for each other.
std::vector<Search> FindBestOfEach(const std::vector<const GroupProblem*>& problems,
                                   const std::vector<std::vector<linkage::Links>>& starts,
                                   const synthesis::OptimizeOptions& options, const std::string& what) {
  std::size_t count = 0;
  for (const std::vector<linkage::Links>& of_one : starts) count += of_one.size();
  Progress progress(what, "starts", static_cast<std::int64_t>(count), options.quiet);
  std::vector<Search> searches(problems.size());
  for (;;) {
    std::vector<Piece> pieces;
    std::vector<std::size_t> of;
    for (std::size_t k = 0; k < problems.size(); ++k)
      for (const linkage::Links& start : NextStarts(searches[k], starts[k]))
        pieces.push_back({problems[k], StartPoints(*problems[k], start)}), of.push_back(k);
    if (pieces.empty()) return searches;
    std::vector<End> ends = SolveAll(pieces, options, progress);
    for (std::size_t i = 0; i < ends.size(); ++i) searches[of[i]].Add(std::move(ends[i]));
  }
}

Search FindBest(const GroupProblem& problem, const std::vector<linkage::Links>& links,
                const synthesis::OptimizeOptions& options, const std::string& what) {
  return FindBestOfEach({&problem}, {StartsOf(problem.shared, links, options)}, options, what).front();
}

std::vector<double> Misalignments_percent(const GroupProblem& problem, const std::vector<ReoptimizePoint>& points) {
  std::vector<double> of_people;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto prediction = PredictPoint(problem.Of(i), points[i]);
    of_people.push_back(prediction ? 100 * prediction->relative_rms : std::numeric_limits<double>::infinity());
  }
  return of_people;
}

// Those whose misalignment costs most do not count any more; `count` of them.
void LeaveOut(std::size_t count, const End& end, GroupProblem& problem) {
  const std::vector<double> percent = Misalignments_percent(problem, end.points);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < problem.people.size(); ++i)
    if (problem.people[i].counts) order.push_back(i);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    constexpr double kNoPrice = 1e-6;  // of the solver's rounding
    const double price_a = end.prices[a] > kNoPrice ? end.prices[a] : 0;
    const double price_b = end.prices[b] > kNoPrice ? end.prices[b] : 0;
    return std::pair(price_a, percent[a]) > std::pair(price_b, percent[b]);
  });
  for (std::size_t k = 0; k < count; ++k) problem.people[order[k]].counts = false;
}

// Whose misalignment counts in a quantile: of all, those are left out whose limits cost most (the greedy discarding of
// constraints of Campi & Garatti, J. Optim. Theory Appl. 148, 2011).
void ChooseCounting(const std::vector<linkage::Links>& links, const synthesis::OptimizeOptions& options,
                    GroupProblem& problem) {
  constexpr std::size_t kRounds = 10;
  std::size_t left = problem.people.size() - problem.Counting();
  if (left == 0) return;
  Search all = FindBest(problem, links, options, "design for all");
  for (std::size_t round = 0; left > 0; ++round) {
    ThrowIfInterrupted();
    End end = all.best;
    if (round > 0) end = EndOf(SolveFrom(problem, all.best.points, options, true));
    if (!end.is_usable) end = EndOf(SolveFrom(WithGoal(problem, Goal::kMisalignment), all.best.points, options));
    const std::size_t rounds = std::max<std::size_t>(1, kRounds - std::min(round, kRounds));
    const std::size_t count = (left + rounds - 1) / rounds;
    LeaveOut(count, end, problem);
    left -= count;
    if (end.is_usable) all.best = std::move(end);
  }
}

GroupDesign DesignOf(const GroupProblem& problem, Search search) {
  GroupDesign design;
  design.points = std::move(search.best.points), design.prices = std::move(search.best.prices);
  design.pulls = std::move(search.best.pulls);
  design.objective = search.best.objective, design.is_usable = search.best.is_usable;
  design.starts = search.starts, design.usable_starts = search.usable_starts;
  for (const Wearer& person : problem.people) design.counts.push_back(person.counts);
  return design;
}

// Of the goal, for one person.
std::optional<double> ObjectiveFor(const ReoptimizeProblem& problem, const DesignInMotion& design) {
  if (!design.prediction) return std::nullopt;
  return design.evaluation.range_deg - problem.penalty_deg_per_mm * design.prediction->rms_mm;
}

// Of those whose misalignment is the largest, or holds the design.
std::string NamesOfBlocking(const GroupOutcome& outcome) {
  std::vector<std::string> names;
  constexpr double kShare = 0.05;  // of all prices
  const std::vector<double>& prices = outcome.nearest.prices;
  const double all = std::accumulate(prices.begin(), prices.end(), 0.0);
  for (std::size_t i = 0; i < prices.size(); ++i)
    if (prices[i] > kShare * all) names.push_back(outcome.problem.people[i].name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string AcrossText(const GroupProblem& problem) {
  if (problem.across == Across::kMean) return "the mean misalignment";
  if (problem.across == Across::kWorst) return "the worst misalignment";
  return fmt::format("the worst misalignment of {} of {} people", problem.Counting(), problem.people.size());
}

std::string WhyNone(const GroupOutcome& outcome) {
  const GroupProblem& problem = outcome.problem;
  if (!outcome.nearest.is_usable)
    return fmt::format("no design was found that {} people can wear", problem.people.size());
  if (problem.shared.max_misalignment_percent &&
      outcome.Misalignment_percent() <= *problem.shared.max_misalignment_percent)
    return fmt::format(
        "the largest range of a design for {} people was not found, although {} can be as small as {:.4g} %; without "
        "margins an optimum need not be unique: set --grashof-margin and --singularity-margin, or more --starts",
        problem.people.size(), AcrossText(problem), outcome.Misalignment_percent());
  return fmt::format(
      "no design for {} people keeps {} within {:.6g} %: the least found is {:.4g} %, and {} hold it there; allow "
      "more, more time or a free program, fit the placement, or make more sizes",
      problem.people.size(), AcrossText(problem), problem.shared.max_misalignment_percent.value_or(0),
      outcome.Misalignment_percent(), NamesOfBlocking(outcome));
}

// The least misalignments, where no start held the limit; from there the designs once more.
void SolveFromNearest(const std::vector<GroupOutcome*>& outcomes, const std::vector<std::vector<linkage::Links>>& links,
                      const synthesis::OptimizeOptions& options) {
  std::vector<GroupProblem> least;
  std::vector<const GroupProblem*> problems;
  std::vector<std::vector<linkage::Links>> starts;
  for (const GroupOutcome* outcome : outcomes) least.push_back(WithGoal(outcome->problem, Goal::kMisalignment));
  for (std::size_t k = 0; k < least.size(); ++k)
    problems.push_back(&least[k]), starts.push_back(StartsOf(least[k].shared, links[k], options));
  std::vector<Search> searches = FindBestOfEach(problems, starts, options, "least misalignment");
  std::vector<Piece> pieces;
  for (std::size_t k = 0; k < outcomes.size(); ++k)
    pieces.push_back({&outcomes[k]->problem, searches[k].best.points, true});
  Progress progress("from the least misalignment", "solves", static_cast<std::int64_t>(pieces.size()), options.quiet);
  std::vector<End> ends = SolveAll(pieces, options, progress);
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    GroupOutcome& outcome = *outcomes[k];
    outcome.nearest = DesignOf(least[k], std::move(searches[k]));
    if (!ends[k].is_usable) {
      outcome.reason = WhyNone(outcome);
      continue;
    }
    outcome.nearest = DesignOf(outcome.problem, {std::move(ends[k]), outcome.nearest.starts + 1, 1, {}});
    outcome.design = outcome.nearest;
  }
}

GroupOutcome Begun(const DesignTask& task, GroupDesign design) {
  GroupOutcome outcome;
  outcome.problem = task.problem, outcome.human = task.human;
  outcome.nearest = std::move(design);
  for (std::size_t i = 0; i < task.human.size(); ++i) outcome.problem.people[i].counts = outcome.nearest.counts[i];
  if (outcome.nearest.is_usable) outcome.design = outcome.nearest;
  return outcome;
}

// The solution with few samples of the motions is close by. Of large groups from the given links alone: of all groups
// measured the starts that succeed met one optimum, and a random start that wanders fills gigabytes.
void FindCloseBy(const synthesis::OptimizeOptions& options, std::vector<DesignTask>& tasks) {
  constexpr std::size_t kLarge = 20;
  std::vector<GroupProblem> coarse;
  std::vector<DesignTask*> of;
  for (DesignTask& task : tasks) {
    const std::vector<Wearer>& people = task.problem.people;
    if (!task.close_by.empty() || people.size() < kLarge || people.front().human.size() < compare::kPercentSamples)
      continue;
    coarse.push_back(Coarse(task.problem)), of.push_back(&task);
  }
  std::vector<const GroupProblem*> problems;
  std::vector<std::vector<linkage::Links>> starts;
  for (std::size_t k = 0; k < of.size(); ++k) {
    synthesis::OptimizeOptions given = options;
    given.starts = std::min(options.starts, static_cast<int>(of[k]->links.size()));
    problems.push_back(&coarse[k]), starts.push_back(StartsOf(coarse[k].shared, of[k]->links, given));
  }
  std::vector<Search> searches = FindBestOfEach(problems, starts, options, "design for all");
  for (std::size_t k = 0; k < of.size(); ++k) {
    if (!searches[k].best.is_usable) continue;
    of[k]->close_by = std::move(searches[k].best.points);
    of[k]->starts = searches[k].starts, of[k]->usable_starts = searches[k].usable_starts;
  }
}

// Of the tasks that have one, where the solution of a problem close by leads.
std::vector<std::optional<GroupDesign>> DesignsFromCloseBy(const std::vector<DesignTask>& tasks,
                                                           const synthesis::OptimizeOptions& options) {
  std::vector<Piece> pieces;
  std::vector<std::size_t> of;
  for (std::size_t k = 0; k < tasks.size(); ++k)
    if (!tasks[k].close_by.empty()) pieces.push_back({&tasks[k].problem, tasks[k].close_by, true}), of.push_back(k);
  Progress progress("from the designs before", "solves", static_cast<std::int64_t>(pieces.size()), options.quiet);
  constexpr int kMostIterations = 60;  // those that lead to a solution take fewer; the rest begin anew: quicker
  std::vector<End> ends = SolveAll(pieces, WithIterations(options, kMostIterations), progress);
  std::vector<std::optional<GroupDesign>> designs(tasks.size());
  for (std::size_t i = 0; i < ends.size(); ++i)
    if (ends[i].is_usable) {
      const DesignTask& task = tasks[of[i]];
      designs[of[i]] = DesignOf(task.problem, {std::move(ends[i]), task.starts, task.usable_starts, {}});
    }
  return designs;
}

}  // namespace

std::vector<linkage::Links> StartLinks(const GroupProblem& problem, const std::vector<PersonMeasured>& people,
                                       const synthesis::OptimizeOptions& options) {
  std::vector<linkage::Links> links{problem.shared.design.start};
  const auto add = [&](const linkage::Links& more) {
    if (std::ranges::none_of(links, [&](const auto& known) { return known.Values() == more.Values(); }))
      links.push_back(more);
  };
  const synthesis::LocalSolve widest = SolveFrom(problem.shared.design, problem.shared.design.start, options);
  if (widest.IsUsable()) add(widest.end);
  for (const PersonMeasured& person : people)
    if (person.motion.worn) add(person.motion.worn->links);
  return links;
}

GroupProblem Coarse(GroupProblem problem) {
  constexpr std::size_t kSteps[] = {5, 4, 2};
  const auto knots = static_cast<std::size_t>(problem.shared.program.knots);
  const auto step = std::ranges::find_if(kSteps, [&](std::size_t of) { return 100 / of + 1 >= knots; });
  if (step == std::end(kSteps)) return problem;
  for (Wearer& person : problem.people) person.human = Thinned(person.human, *step);
  return problem;
}

GroupProblem PutMotionsInto(GroupProblem problem, const std::vector<PersonMeasured>& people) {
  problem.people.clear();
  for (const PersonMeasured& person : people) {
    try {
      const ReoptimizeProblem own = PutMotionInto(problem.shared, person.motion).problem;
      problem.people.push_back({person.name, own.human, own.placement_mm});
    } catch (const UsageError&) {
      throw;
    } catch (const Error& error) {
      throw Fail("{}: {}", person.name, error.what());
    }
  }
  return problem;
}

std::vector<std::optional<ReoptimizePoint>> OwnPoints(const GroupProblem& problem,
                                                      const std::vector<linkage::Links>& links,
                                                      const synthesis::OptimizeOptions& options) {
  Progress progress("design for each alone", "people", static_cast<std::int64_t>(problem.people.size()), options.quiet);
  const std::vector<std::string> packed = InProcesses(
      problem.people.size(),
      [&](std::size_t i, const std::function<void()>& step) {
        const auto optimum = FindOptimum(problem.Of(i), links, options);
        step();
        return optimum ? JsonOf(optimum->point).dump() : std::string();
      },
      progress);
  std::vector<std::optional<ReoptimizePoint>> points;
  for (const std::string& text : packed)
    points.push_back(text.empty() ? std::nullopt : std::optional(PointOf(nlohmann::json::parse(text))));
  return points;
}

PersonOutcome OutcomeOf(const GroupOutcome& outcome, std::size_t i, const std::optional<ReoptimizePoint>& own) {
  const ReoptimizeProblem problem = outcome.problem.Of(i);
  PersonOutcome person{outcome.problem.people[i].name,
                       PutInMotion(problem, outcome.human[i], DesignOf(problem, outcome.nearest.points[i])),
                       outcome.nearest.counts[i],
                       outcome.nearest.prices.empty() ? 0 : outcome.nearest.prices[i],
                       {},
                       {}};
  if (!own) return person;
  person.own = PutInMotion(problem, outcome.human[i], DesignOf(problem, *own));
  const auto with_group = ObjectiveFor(problem, person.with_group), alone = ObjectiveFor(problem, *person.own);
  if (with_group && alone) person.cost_deg = *alone - *with_group;
  return person;
}

double GroupOutcome::Misalignment_percent() const {
  GroupProblem counted = problem;
  for (std::size_t i = 0; i < counted.people.size(); ++i) counted.people[i].counts = nearest.counts[i];
  return counted.Combine(Misalignments_percent(counted, nearest.points));
}

GroupDesign FindGroupDesign(const GroupProblem& asked, const std::vector<linkage::Links>& links,
                            const synthesis::OptimizeOptions& options) {
  asked.Check();
  options.Check();
  GroupProblem problem = asked;
  ChooseCounting(links, options, problem);
  return DesignOf(problem, FindBest(problem, links, options, "design for all"));
}

std::vector<GroupOutcome> DesignGroups(std::vector<DesignTask> tasks, const synthesis::OptimizeOptions& options) {
  options.Check();
  for (DesignTask& task : tasks) {
    task.problem.Check();
    ChooseCounting(task.links, options, task.problem);
  }
  FindCloseBy(options, tasks);
  std::vector<std::optional<GroupDesign>> designs = DesignsFromCloseBy(tasks, options);
  std::vector<const GroupProblem*> problems;
  std::vector<std::vector<linkage::Links>> starts;
  std::vector<std::size_t> of;
  for (std::size_t k = 0; k < tasks.size(); ++k) {
    if (designs[k]) continue;
    problems.push_back(&tasks[k].problem), of.push_back(k);
    starts.push_back(StartsOf(tasks[k].problem.shared, tasks[k].links, options));
  }
  std::vector<Search> searches = FindBestOfEach(problems, starts, options, "design for all");
  for (std::size_t i = 0; i < of.size(); ++i) designs[of[i]] = DesignOf(*problems[i], std::move(searches[i]));
  std::vector<GroupOutcome> outcomes;
  for (std::size_t k = 0; k < tasks.size(); ++k) outcomes.push_back(Begun(tasks[k], std::move(*designs[k])));
  std::vector<GroupOutcome*> unsolved;
  std::vector<std::vector<linkage::Links>> links;
  for (std::size_t k = 0; k < tasks.size(); ++k)
    if (!outcomes[k].IsSolved()) unsolved.push_back(&outcomes[k]), links.push_back(tasks[k].links);
  if (!unsolved.empty()) SolveFromNearest(unsolved, links, options);
  for (GroupOutcome& outcome : outcomes)
    outcome.evaluation = problem::Evaluate(outcome.nearest.Links(), outcome.problem.shared.design);
  return outcomes;
}

GroupOutcome RunGroup(const GroupProblem& shared, const std::vector<PersonMeasured>& people,
                      const synthesis::OptimizeOptions& options) {
  shared.CheckOptions();
  const GroupProblem problem = PutMotionsInto(shared, people);
  std::vector<compare::StsCurve> human;
  for (const PersonMeasured& person : people) human.push_back(person.motion.human);
  std::vector<linkage::Links> links = StartLinks(problem, people, options);
  GroupOutcome outcome = DesignGroups({{problem, human, links, {}}}, options).front();
  links.insert(links.begin(), outcome.nearest.Links());
  const std::vector<std::optional<ReoptimizePoint>> own = OwnPoints(problem, links, options);
  for (std::size_t i = 0; i < people.size(); ++i) outcome.people.push_back(OutcomeOf(outcome, i, own[i]));
  return outcome;
}

}  // namespace lake::redesign
