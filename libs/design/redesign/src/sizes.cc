#include "lake/redesign/sizes.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <random>
#include <utility>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/numbers.h"
#include "lake/core/processes.h"
#include "lake/core/progress.h"
#include "lake/core/statistics.h"

namespace lake::redesign {

// From one process to another.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Fit, holds, value, percent, range_deg)

namespace {

using Assignment = std::vector<std::size_t>;  // the size of each person
using Fits = std::vector<std::vector<Fit>>;   // per person and size

std::vector<std::size_t> MembersOf(const Assignment& sizes, std::size_t size) {
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < sizes.size(); ++i)
    if (sizes[i] == size) members.push_back(i);
  return members;
}

template <typename T>
std::vector<T> Picked(const std::vector<T>& all, const std::vector<std::size_t>& indices) {
  std::vector<T> picked;
  for (const std::size_t i : indices) picked.push_back(all[i]);
  return picked;
}

GroupProblem ProblemOf(const GroupProblem& all, const std::vector<std::size_t>& members) {
  GroupProblem problem = all;
  problem.people = Picked(all.people, members);
  return problem;
}

// Designs for an assignment, and what each is to each person.
struct Alternation {
  Assignment assignment;
  std::vector<GroupOutcome> designs;
  Fits fits;

  // Of the goal, mean over people.
  double Value() const {
    double sum = 0;
    for (std::size_t i = 0; i < fits.size(); ++i) sum += fits[i][assignment[i]].value;
    return sum / static_cast<double>(fits.size());
  }
};

// Designs and who wears them, assigned to each other in turn; what was solved is kept.
class SizeSearch {
 public:
  // `everybody`: `links` are where designs start.
  SizeSearch(DesignTask everybody, std::size_t sizes, const synthesis::OptimizeOptions& options)
      : problem_(std::move(everybody.problem)),
        human_(std::move(everybody.human)),
        links_(std::move(everybody.links)),
        sizes_(sizes),
        options_(options) {}

  // From few starts, each round from the one before, for as long as it gets better.
  Alternation Alternate(const Assignment& first) {
    constexpr int kFewStarts = 4;
    constexpr double kBetter_deg = 1e-3;
    Alternation best = DesignFor(first, {}, From::kAllStarts, std::min(kFewStarts, options_.starts));
    for (int round = 1; round < kMostRounds; ++round) {
      const Assignment next = BestOf(best);
      if (next == best.assignment) break;
      Alternation now = DesignFor(next, best, From::kFound, 1);
      if (now.Value() < best.Value() + kBetter_deg) break;
      best = std::move(now);
    }
    return best;
  }

  // Designs from all starts, or from those of `found`, and on from there until everybody wears the size that is best
  // for them; whether it came to that.
  enum class From { kAllStarts, kFound };
  bool Settle(From from, Alternation& found) {
    found = DesignFor(found.assignment, found, from, from == From::kFound ? 1 : options_.starts);
    for (int round = 1;; ++round) {
      const Assignment next = BestOf(found);
      if (next == found.assignment) return true;
      if (round == kMostRounds) return false;
      found = DesignFor(next, found, From::kFound, 1);
    }
  }

 private:
  using Members = std::vector<std::size_t>;

  static constexpr int kMostRounds = 10;

  Alternation DesignFor(const Assignment& assignment, const Alternation& before, From from, int starts) {
    ThrowIfInterrupted();
    std::vector<DesignTask> tasks;
    std::vector<Members> unknown;
    for (std::size_t k = 0; k < sizes_; ++k) {
      const Members members = MembersOf(assignment, k);
      if (designs_.contains({starts, members})) continue;
      tasks.push_back(TaskFor(members, k, before, from));
      unknown.push_back(members);
    }
    synthesis::OptimizeOptions options = options_;
    options.starts = starts;
    std::vector<GroupOutcome> designs = DesignGroups(std::move(tasks), options);
    for (std::size_t i = 0; i < designs.size(); ++i) designs_[{starts, unknown[i]}] = std::move(designs[i]);
    Alternation found{assignment, {}, {}};
    for (std::size_t k = 0; k < sizes_; ++k) found.designs.push_back(designs_.at({starts, MembersOf(assignment, k)}));
    FindFits(found);
    return found;
  }

  DesignTask TaskFor(const Members& members, std::size_t size, const Alternation& before, From from) const {
    DesignTask task{
        .problem = ProblemOf(problem_, members), .human = Picked(human_, members), .links = links_, .close_by = {}};
    if (before.designs.empty()) return task;
    task.links.insert(task.links.begin(), before.designs[size].nearest.Links());
    if (from == From::kFound) task.close_by = PointsBefore(members, size, before);
    return task;
  }

  // Whoever is new to the size begins with its links.
  std::vector<RedesignPoint> PointsBefore(const Members& members, std::size_t size, const Alternation& before) const {
    const RedesignEnd& design = before.designs[size].nearest;
    const Members earlier = MembersOf(before.assignment, size);
    std::vector<RedesignPoint> points;
    for (const std::size_t i : members) {
      const auto place = std::ranges::find(earlier, i);
      points.push_back(place == earlier.end() ? StartPoint(problem_.Of(i), design.Links())
                                              : design.points[static_cast<std::size_t>(place - earlier.begin())]);
    }
    return points;
  }

  void FindFits(Alternation& found) {
    const auto key = [&](std::size_t i, std::size_t k) {
      return std::pair(i, found.designs[k].nearest.Links().Values());
    };
    std::vector<std::pair<std::size_t, std::size_t>> unknown;
    for (std::size_t i = 0; i < problem_.people.size(); ++i)
      for (std::size_t k = 0; k < sizes_; ++k)
        if (!fits_.contains(key(i, k))) unknown.emplace_back(i, k);
    Progress progress("who wears which", "fits", static_cast<std::int64_t>(unknown.size()), options_.quiet);
    const std::vector<Fit> fits = ResultsInProcesses(
        unknown.size(),
        [&](std::size_t piece) {
          const auto& [i, k] = unknown[piece];
          return FitOf(problem_.Of(i), found.designs[k].nearest.Links(), options_);
        },
        progress);
    for (std::size_t piece = 0; piece < unknown.size(); ++piece)
      fits_[key(unknown[piece].first, unknown[piece].second)] = fits[piece];
    for (std::size_t i = 0; i < problem_.people.size(); ++i) {
      std::vector<Fit>& of = found.fits.emplace_back();
      for (std::size_t k = 0; k < sizes_; ++k) of.push_back(fits_.at(key(i, k)));
    }
  }

  // Each person's best size; of equals the present one. A size that nobody chose gets the person with the least value
  // of those who are not the only one of their size.
  Assignment BestOf(const Alternation& found) const {
    const Fits& fits = found.fits;
    constexpr double kEqual_deg = 1e-2;  // a fit is found within its links' tolerance
    Assignment best = found.assignment;
    for (std::size_t i = 0; i < fits.size(); ++i)
      for (std::size_t k = 0; k < sizes_; ++k)
        if (fits[i][k].value > fits[i][best[i]].value + kEqual_deg) best[i] = k;
    for (std::size_t k = 0; k < sizes_; ++k) {
      if (!MembersOf(best, k).empty()) continue;
      std::optional<std::size_t> least;
      for (std::size_t i = 0; i < best.size(); ++i)
        if (MembersOf(best, best[i]).size() > 1 &&
            (!least || fits[i][best[i]].value < fits[*least][best[*least]].value))
          least = i;
      best[*least] = k;
    }
    return best;
  }

  const GroupProblem problem_;
  const std::vector<compare::StsCurve> human_;
  const std::vector<linkage::Links> links_;
  const std::size_t sizes_;
  const synthesis::OptimizeOptions options_;
  std::map<std::pair<int, Members>, GroupOutcome> designs_;            // by starts and who wears it
  std::map<std::pair<std::size_t, std::array<double, 6>>, Fit> fits_;  // by person and links
};

const std::vector<double>& LengthsOf(const std::vector<BodyQuantity>& quantities, std::string_view name) {
  return std::ranges::find(quantities, name, &BodyQuantity::name)->mm;
}

// 0, 1, …
std::vector<std::size_t> UpTo(std::size_t count) {
  std::vector<std::size_t> indices(count);
  std::iota(indices.begin(), indices.end(), std::size_t{0});
  return indices;
}

std::vector<BodyQuantity> QuantitiesOf(const GroupProblem& problem, const std::vector<double>& heights_mm) {
  BodyQuantity leg{"leg_mm", {}}, shank{"shank_mm", {}}, thigh{"thigh_mm", {}};
  for (const Subject& person : problem.people) {
    const SegmentLengths lengths = SegmentsOf(person.human);
    leg.mm.push_back(lengths.shank_mm + lengths.thigh_mm);
    shank.mm.push_back(lengths.shank_mm);
    thigh.mm.push_back(lengths.thigh_mm);
  }
  std::vector<BodyQuantity> quantities;
  if (!heights_mm.empty()) quantities.push_back({"height_mm", heights_mm});
  quantities.insert(quantities.end(), {leg, shank, thigh});
  return quantities;
}

// People in the order of a figure, cut into as many equal parts as there are sizes.
Assignment InEqualParts(const std::vector<double>& figure, std::size_t sizes) {
  std::vector<std::size_t> order = UpTo(figure.size());
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return figure[i]; });
  Assignment assignment(figure.size());
  for (std::size_t k = 0; k < order.size(); ++k) assignment[order[k]] = k * sizes / order.size();
  return assignment;
}

// By the length of the leg, by how far the knee bends, and at random.
std::vector<Assignment> FirstAssignments(const GroupProblem& problem, const std::vector<double>& leg_mm,
                                         std::size_t sizes, std::uint64_t seed) {
  std::vector<double> bend, chance;
  std::mt19937_64 random(seed);
  for (const Subject& person : problem.people) {
    double largest = 0;
    for (const HumanSample& sample : person.human) largest = std::max(largest, sample.knee_rad);
    bend.push_back(largest);
    chance.push_back(static_cast<double>(random() >> 11));
  }
  return {InEqualParts(leg_mm, sizes), InEqualParts(bend, sizes), InEqualParts(chance, sizes)};
}

std::vector<linkage::Links> LinksOf(const std::vector<GroupOutcome>& designs) {
  std::vector<linkage::Links> links;
  for (const GroupOutcome& design : designs) links.push_back(design.nearest.Links());
  return links;
}

// Sizes in the order of the legs that they are for.
void Sort(const std::vector<double>& leg_mm, Alternation& found) {
  const std::size_t sizes = found.designs.size();
  std::vector<std::size_t> order = UpTo(sizes), place(sizes);
  std::ranges::stable_sort(order, {},
                           [&](std::size_t k) { return Mean(Picked(leg_mm, MembersOf(found.assignment, k))); });
  for (std::size_t k = 0; k < sizes; ++k) place[order[k]] = k;
  found.designs = Picked(found.designs, order);
  for (std::size_t& size : found.assignment) size = place[size];
  for (std::vector<Fit>& fits : found.fits) fits = Picked(fits, order);
}

std::vector<std::vector<double>> LossesOf(const Fits& fits) {
  std::vector<std::vector<double>> losses;
  for (const std::vector<Fit>& of : fits) {
    const double best = std::ranges::max(of, {}, &Fit::value).value;
    std::vector<double>& own = losses.emplace_back();
    for (const Fit& fit : of) own.push_back(best - fit.value);
  }
  return losses;
}

double PullOf(const SizesOutcome& outcome, std::size_t person) {
  const std::vector<std::size_t>& members = outcome.members[outcome.size_of[person]];
  const auto place = std::ranges::find(members, person) - members.begin();
  return outcome.sizes[outcome.size_of[person]].nearest.pulls[static_cast<std::size_t>(place)];
}

// Design of the person's size without the person, from where it is.
linkage::Links LinksWithout(const SizesOutcome& outcome, const GroupProblem& problem, std::size_t person,
                            const synthesis::OptimizeOptions& options) {
  const std::size_t size = outcome.size_of[person];
  const RedesignEnd& design = outcome.sizes[size].nearest;
  std::vector<std::size_t> others;
  std::vector<RedesignPoint> points;
  for (std::size_t k = 0; k < outcome.members[size].size(); ++k) {
    if (outcome.members[size][k] == person) continue;
    others.push_back(outcome.members[size][k]);
    points.push_back(design.points[k]);
  }
  if (others.empty()) return design.Links();
  const GroupProblem without = ProblemOf(problem, others);
  RedesignSolve solve = SolveFrom(without, points, options, true);
  if (!solve.IsUsable()) solve = SolveFrom(without, StartPoints(without, design.Links()), options);
  return solve.IsUsable() ? solve.Links() : design.Links();
}

// What whoever is left out gets: the size that the rule of the others says, without them if it was theirs. A size that
// they do not hold is the same without them.
std::vector<LeftOut> LeaveEachOut(const SizesOutcome& outcome, const GroupProblem& problem, const Fits& fits,
                                  const synthesis::OptimizeOptions& options) {
  constexpr double kNoPull_deg_per_mm = 1e-3;
  const std::vector<std::vector<double>> losses = LossesOf(fits);
  const std::vector<std::size_t> everybody = UpTo(problem.people.size());
  std::vector<LeftOut> left_out;
  std::vector<std::size_t> hold;
  for (const std::size_t i : everybody) {
    std::vector<std::size_t> others = everybody;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const SizeRule rule = FindRule(outcome.quantities, losses, others);
    const std::size_t size = rule.SizeFor(LengthsOf(outcome.quantities, rule.quantity)[i]);
    left_out.push_back({size, fits[i][size]});
    if (size == outcome.size_of[i] && PullOf(outcome, i) > kNoPull_deg_per_mm) hold.push_back(i);
  }
  Progress progress("leaving one out", "people", static_cast<std::int64_t>(hold.size()), options.quiet);
  const std::vector<Fit> fits_without = ResultsInProcesses(
      hold.size(),
      [&](std::size_t piece) {
        const std::size_t i = hold[piece];
        return FitOf(problem.Of(i), LinksWithout(outcome, problem, i, options), options);
      },
      progress);
  for (std::size_t piece = 0; piece < hold.size(); ++piece) left_out[hold[piece]].fit = fits_without[piece];
  return left_out;
}

void AddPeople(const GroupProblem& problem, const std::vector<linkage::Links>& links,
               const synthesis::OptimizeOptions& options, SizesOutcome& outcome) {
  std::vector<linkage::Links> starts = LinksOf(outcome.sizes);
  starts.insert(starts.end(), links.begin(), links.end());
  const std::vector<RedesignEnd> own = OwnDesigns(problem, starts, options);
  for (std::size_t k = 0; k < outcome.sizes.size(); ++k)
    for (std::size_t i = 0; i < outcome.members[k].size(); ++i)
      outcome.sizes[k].people.push_back(OutcomeOf(outcome.sizes[k], i, own[outcome.members[k][i]]));
}

// How many people's limits the size that is theirs does not hold.
std::size_t NotHeld(const Fits& fits, const Assignment& size_of) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < fits.size(); ++i) count += !fits[i][size_of[i]].holds;
  return count;
}

// What the rule gives to each.
Assignment SizesBy(const SizeRule& rule, const std::vector<BodyQuantity>& quantities) {
  Assignment sizes;
  for (const double mm : LengthsOf(quantities, rule.quantity)) sizes.push_back(rule.SizeFor(mm));
  return sizes;
}

// The ranges of one quantity with the least loss: dynamic programming over people in its order, by the set of sizes
// that are used so far and the last of them.
SizeRule RuleBy(const BodyQuantity& quantity, const std::vector<std::vector<double>>& losses,
                std::vector<std::size_t> people) {
  struct Step {
    double loss = kInfinity;
    std::size_t set = 0, size = 0;  // before this person
  };
  const std::vector<double>& mm = quantity.mm;
  std::ranges::stable_sort(people, {}, [&](std::size_t i) { return mm[i]; });
  const std::size_t sizes = losses.front().size(), sets = std::size_t{1} << sizes, count = people.size();
  std::vector best(count + 1, std::vector(sets, std::vector<Step>(sizes)));
  for (std::size_t k = 0; k < sizes; ++k) best[0][std::size_t{1} << k][k].loss = 0;
  for (std::size_t n = 0; n < count; ++n)
    for (std::size_t set = 1; set < sets; ++set)
      for (std::size_t size = 0; size < sizes; ++size)
        for (std::size_t next = 0; next < sizes; ++next) {
          // The same size as that of the person before, or the first of a range of another.
          const std::size_t with = set | std::size_t{1} << next;
          const bool may_cut = n > 0 && mm[people[n]] > mm[people[n - 1]] && with != set;
          const double loss = best[n][set][size].loss + losses[people[n]][next];
          Step& to = best[n + 1][with][next];
          if ((next == size || may_cut) && loss < to.loss) to = {loss, set, size};
        }
  std::size_t set = 0, size = 0;
  for (std::size_t s = 1; s < sets; ++s)
    for (std::size_t k = 0; k < sizes; ++k)
      if (best[count][s][k].loss < best[count][set][size].loss) set = s, size = k;
  SizeRule rule{
      quantity.name, {{-kInfinity, kInfinity, size}}, best[count][set][size].loss / static_cast<double>(count)};
  for (std::size_t n = count; n > 1; --n) {
    const Step step = best[n][set][size];
    if (step.size != size) {
      const double cut = (mm[people[n - 1]] + mm[people[n - 2]]) / 2;
      rule.ranges.front().from_mm = cut;
      rule.ranges.insert(rule.ranges.begin(), {-kInfinity, cut, step.size});
    }
    set = step.set;
    size = step.size;
  }
  return rule;
}

}  // namespace

std::size_t SizeRule::SizeFor(double quantity_mm) const {
  for (const RuleRange& range : ranges)
    if (quantity_mm <= range.to_mm) return range.size;
  return ranges.back().size;
}

SizeRule FindRule(const std::vector<BodyQuantity>& quantities, const std::vector<std::vector<double>>& losses,
                  const std::vector<std::size_t>& people) {
  SizeRule best;
  for (const BodyQuantity& quantity : quantities) {
    SizeRule rule = RuleBy(quantity, losses, people);
    constexpr double kBetter_deg = 1e-3;
    if (best.ranges.empty() || rule.loss_deg < best.loss_deg - kBetter_deg) best = std::move(rule);
  }
  return best;
}

Fit FitOf(const RedesignProblem& person, const linkage::Links& links, const synthesis::OptimizeOptions& options) {
  constexpr double kNotHeld_deg = 1000;
  const RedesignProblem fixed = WithLinks(person, links);
  const RedesignPoint start = StartPoint(fixed, links);
  Fit fit{
      .value = -2 * kNotHeld_deg, .percent = kInfinity, .range_deg = problem::Evaluate(links, person.design).range_deg};
  const auto hold = [&](const RedesignSolve& solve) {
    fit.holds = true;
    fit.percent = solve.Misalignment_percent();
    fit.value = fit.range_deg - person.penalty_deg_per_mm * solve.Predicted()->Rms().mm;
  };
  if (person.penalty_deg_per_mm > 0) {
    const RedesignSolve best = SolveFrom(fixed, start, options);
    if (best.IsUsable()) {
      hold(best);
      return fit;
    }
  }
  // Without a penalty the links' range is all that counts, where they can be worn within the limit.
  const RedesignSolve nearest = SolveFrom(WithGoal(fixed, RedesignProblem::Goal::kMisalignment), start, options);
  if (!nearest.IsUsable()) return fit;
  fit.percent = nearest.Misalignment_percent();
  fit.value = -kNotHeld_deg - fit.percent;
  // The limit may be met so closely that no interior point is left.
  constexpr double kTolerance = 1e-4;
  if (!person.max_misalignment_percent || fit.percent <= *person.max_misalignment_percent * (1 + kTolerance))
    hold(nearest);
  return fit;
}

bool SizesOutcome::IsSolved() const {
  return std::ranges::all_of(sizes, [](const GroupOutcome& size) { return size.IsSolved(); });
}

std::string SizesOutcome::Reason() const {
  for (std::size_t k = 0; k < sizes.size(); ++k)
    if (!sizes[k].IsSolved()) return fmt::format("size {}: {}", k + 1, sizes[k].reason);
  return "";
}

void CheckSizes(const GroupProblem& shared, int sizes, std::size_t people) {
  constexpr int kMostSizes = 8;
  if (shared.across != Across::kWorst) throw UsageError("--sizes: the limit holds for every person; omit --across");
  if (sizes < 2 || sizes > kMostSizes || people < 2 * static_cast<std::size_t>(sizes))
    throw UsageError("--sizes {}: 2 to {}, and at least two people for each; there are {}", sizes, kMostSizes, people);
}

SizesOutcome RunSizes(const GroupProblem& shared, const std::vector<PersonMeasured>& people, int sizes,
                      const std::vector<double>& heights_mm, const synthesis::OptimizeOptions& options) {
  CheckSizes(shared, sizes, people.size());
  const auto count = static_cast<std::size_t>(sizes);
  const DesignTask task = TaskOf(shared, people, options);
  const GroupProblem& problem = task.problem;
  SizesOutcome outcome;
  outcome.quantities = QuantitiesOf(problem, heights_mm);
  const std::vector<double>& leg_mm = LengthsOf(outcome.quantities, "leg_mm");
  Alternation best;
  DesignTask coarse_task = task;
  coarse_task.problem = Coarse(problem);
  SizeSearch coarse(coarse_task, count, options);
  for (const Assignment& first : FirstAssignments(problem, leg_mm, count, options.seed)) {
    Alternation found = coarse.Alternate(first);
    if (best.assignment.empty() || found.Value() > best.Value()) best = std::move(found);
  }
  coarse.Settle(SizeSearch::From::kAllStarts, best);
  outcome.is_settled = SizeSearch(task, count, options).Settle(SizeSearch::From::kFound, best);
  Sort(leg_mm, best);
  outcome.sizes = std::move(best.designs);
  outcome.size_of = best.assignment;
  outcome.mean_value_deg = NotHeld(best.fits, best.assignment) ? kNaN : best.Value();
  for (std::size_t k = 0; k < count; ++k) outcome.members.push_back(MembersOf(outcome.size_of, k));
  AddPeople(problem, task.links, options, outcome);
  outcome.rule = FindRule(outcome.quantities, LossesOf(best.fits), UpTo(people.size()));
  outcome.rule_not_held = NotHeld(best.fits, SizesBy(outcome.rule, outcome.quantities));
  if (outcome.IsSolved()) outcome.left_out = LeaveEachOut(outcome, problem, best.fits, options);
  return outcome;
}

}  // namespace lake::redesign
