#include "lake/sizes/sizes.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include "lake/core/error.h"
#include "lake/core/processes.h"
#include "lake/core/progress.h"
#include "lake/core/statistics.h"
#include "size_search.h"

namespace lake::sizes {

using group::GroupDesign;
using redesign::GroupSolve;
using redesign::RedesignProblem;
using redesign::RedesignSolve;

namespace {

std::vector<BodyQuantity> QuantitiesOf(const GroupProblem& problem, const std::vector<double>& heights_mm) {
  BodyQuantity leg{"leg_mm", {}}, shank{"shank_mm", {}}, thigh{"thigh_mm", {}};
  for (const redesign::Subject& person : problem.people) {
    const redesign::SegmentLengths lengths = redesign::SegmentsOf(person.human);
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
  std::vector<std::size_t> order(figure.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
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
  for (const redesign::Subject& person : problem.people) {
    double largest = 0;
    for (const redesign::HumanSample& sample : person.human) largest = std::max(largest, sample.knee_rad);
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
  std::vector<std::size_t> order(sizes), place(sizes);
  std::iota(order.begin(), order.end(), std::size_t{0});
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
  const GroupDesign& design = outcome.sizes[size].nearest;
  std::vector<std::size_t> others;
  std::vector<RedesignPoint> points;
  for (std::size_t k = 0; k < outcome.members[size].size(); ++k) {
    if (outcome.members[size][k] == person) continue;
    others.push_back(outcome.members[size][k]);
    points.push_back(design.points[k]);
  }
  if (others.empty()) return design.Links();
  const GroupProblem without = ProblemOf(problem, others);
  GroupSolve solve = SolveFrom(without, points, options, true);
  if (!solve.IsUsable()) solve = SolveFrom(without, group::StartPoints(without, design.Links()), options);
  return solve.IsUsable() ? solve.points.front().links : design.Links();
}

// What whoever is left out gets: the size that the rule of the others says, without them if it was theirs. A size that
// they do not hold is the same without them.
std::vector<LeftOut> LeaveEachOut(const SizesOutcome& outcome, const GroupProblem& problem, const Fits& fits,
                                  const synthesis::OptimizeOptions& options) {
  constexpr double kNoPull_deg_per_mm = 1e-3;
  const std::vector<std::vector<double>> losses = LossesOf(fits);
  std::vector<std::size_t> everybody(problem.people.size());
  std::iota(everybody.begin(), everybody.end(), std::size_t{0});
  std::vector<LeftOut> left_out;
  std::vector<std::size_t> hold;
  for (const std::size_t i : everybody) {
    std::vector<std::size_t> others = everybody;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const SizeRule rule = FindRule(outcome.quantities, losses, others);
    const std::size_t size =
        rule.SizeFor(std::ranges::find(outcome.quantities, rule.quantity, &BodyQuantity::name)->mm[i]);
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
  const std::vector<std::optional<RedesignPoint>> own = group::OwnPoints(problem, starts, options);
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
  for (const double mm : std::ranges::find(quantities, rule.quantity, &BodyQuantity::name)->mm)
    sizes.push_back(rule.SizeFor(mm));
  return sizes;
}

}  // namespace

Fit FitOf(const RedesignProblem& person, const linkage::Links& links, const synthesis::OptimizeOptions& options) {
  constexpr double kNotHeld_deg = 1000;
  const RedesignProblem fixed = WithLinks(person, links);
  const RedesignPoint start = StartPoint(fixed, links);
  Fit fit{
      .value = -2 * kNotHeld_deg, .percent = kInfinity, .range_deg = problem::Evaluate(links, person.design).range_deg};
  const auto hold = [&](const RedesignSolve& solve) {
    fit.holds = true;
    fit.percent = solve.Misalignment_percent();
    fit.value = fit.range_deg - person.penalty_deg_per_mm * solve.prediction->Rms().mm;
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
  if (shared.across != redesign::Across::kWorst)
    throw UsageError("--sizes: the limit holds for every person; omit --across");
  if (sizes < 2 || sizes > kMostSizes || people < 2 * static_cast<std::size_t>(sizes))
    throw UsageError("--sizes {}: 2 to {}, and at least two people for each; there are {}", sizes, kMostSizes, people);
}

SizesOutcome RunSizes(const GroupProblem& shared, const std::vector<group::PersonMeasured>& people, int sizes,
                      const std::vector<double>& heights_mm, const synthesis::OptimizeOptions& options) {
  shared.CheckOptions();
  CheckSizes(shared, sizes, people.size());
  const auto count = static_cast<std::size_t>(sizes);
  const GroupProblem problem = PutMotionsInto(shared, people);
  std::vector<compare::StsCurve> human;
  for (const group::PersonMeasured& person : people) human.push_back(person.motion.human);
  const std::vector<linkage::Links> links = StartLinks(problem, people, options);
  SizesOutcome outcome;
  outcome.quantities = QuantitiesOf(problem, heights_mm);
  const std::vector<double>& leg_mm = std::ranges::find(outcome.quantities, "leg_mm", &BodyQuantity::name)->mm;
  Alternation best;
  SizeSearch coarse(group::Coarse(problem), human, links, count, options);
  for (const Assignment& first : FirstAssignments(problem, leg_mm, count, options.seed)) {
    Alternation found = coarse.Alternate(first);
    if (best.assignment.empty() || found.Value() > best.Value()) best = std::move(found);
  }
  coarse.Settle(SizeSearch::From::kAllStarts, best);
  outcome.is_settled = SizeSearch(problem, human, links, count, options).Settle(SizeSearch::From::kFound, best);
  Sort(leg_mm, best);
  outcome.sizes = std::move(best.designs);
  outcome.size_of = best.assignment;
  outcome.mean_value_deg =
      NotHeld(best.fits, best.assignment) ? std::numeric_limits<double>::quiet_NaN() : best.Value();
  for (std::size_t k = 0; k < count; ++k) outcome.members.push_back(MembersOf(outcome.size_of, k));
  AddPeople(problem, links, options, outcome);
  std::vector<std::size_t> everybody(people.size());
  std::iota(everybody.begin(), everybody.end(), std::size_t{0});
  outcome.rule = FindRule(outcome.quantities, LossesOf(best.fits), everybody);
  outcome.rule_not_held = NotHeld(best.fits, SizesBy(outcome.rule, outcome.quantities));
  if (outcome.IsSolved()) outcome.left_out = LeaveEachOut(outcome, problem, best.fits, options);
  return outcome;
}

}  // namespace lake::sizes
