#include "lake/redesign/sizes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "group_parts.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/processes.h"
#include "lake/core/progress.h"
#include "lake/core/statistics.h"

namespace lake::redesign {
namespace {

using Assignment = std::vector<std::size_t>;  // the size of each person
using Fits = std::vector<std::vector<Fit>>;   // per person and size
constexpr double kInfinite = std::numeric_limits<double>::infinity();

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

std::vector<BodyQuantity> QuantitiesOf(const GroupProblem& problem, const std::vector<double>& heights_mm) {
  BodyQuantity leg{"leg_mm", {}}, shank{"shank_mm", {}}, thigh{"thigh_mm", {}};
  for (const Wearer& person : problem.people) {
    const SegmentLengths lengths = SegmentsOf(person.human);
    leg.mm.push_back(lengths.shank_mm + lengths.thigh_mm);
    shank.mm.push_back(lengths.shank_mm), thigh.mm.push_back(lengths.thigh_mm);
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
  for (const Wearer& person : problem.people) {
    double largest = 0;
    for (const HumanSample& sample : person.human) largest = std::max(largest, sample.knee_rad);
    bend.push_back(largest), chance.push_back(static_cast<double>(random() >> 11));
  }
  return {InEqualParts(leg_mm, sizes), InEqualParts(bend, sizes), InEqualParts(chance, sizes)};
}

std::string Packed(const Fit& fit) {
  const auto number = [](double value) { return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(); };
  return nlohmann::json{{"holds", fit.holds},
                        {"value", fit.value},
                        {"percent", number(fit.percent)},
                        {"range_deg", number(fit.range_deg)}}
      .dump();
}

Fit UnpackedFit(const std::string& text) {
  const nlohmann::json json = nlohmann::json::parse(text);
  const auto number = [&](const char* key) { return json[key].is_null() ? kInfinite : json[key].get<double>(); };
  return {json["holds"].get<bool>(), json["value"].get<double>(), number("percent"), number("range_deg")};
}

Fits FitsOf(const GroupProblem& problem, const std::vector<linkage::Links>& sizes,
            const synthesis::OptimizeOptions& options) {
  const std::size_t people = problem.people.size();
  Progress progress("who wears which", "fits", static_cast<std::int64_t>(people * sizes.size()), options.quiet);
  const std::vector<std::string> packed = InProcesses(
      people,
      [&](std::size_t i, const std::function<void()>& step) {
        nlohmann::json fits = nlohmann::json::array();
        for (const linkage::Links& links : sizes) fits.push_back(Packed(FitOf(problem.Of(i), links, options))), step();
        return fits.dump();
      },
      progress);
  Fits fits;
  for (const std::string& text : packed) {
    std::vector<Fit>& of = fits.emplace_back();
    for (const nlohmann::json& fit : nlohmann::json::parse(text)) of.push_back(UnpackedFit(fit.get<std::string>()));
  }
  return fits;
}

// Each person's best size; of equals the present one. A size that nobody chose gets the person with the least value of
// those who are not the only one of their size.
Assignment BestOf(const Fits& fits, const Assignment& present, std::size_t sizes) {
  constexpr double kEqual_deg = 1e-2;  // a fit is found within its links' tolerance
  Assignment best = present;
  for (std::size_t i = 0; i < fits.size(); ++i)
    for (std::size_t k = 0; k < sizes; ++k)
      if (fits[i][k].value > fits[i][best[i]].value + kEqual_deg) best[i] = k;
  for (std::size_t k = 0; k < sizes; ++k) {
    if (!MembersOf(best, k).empty()) continue;
    std::optional<std::size_t> least;
    for (std::size_t i = 0; i < best.size(); ++i)
      if (MembersOf(best, best[i]).size() > 1 && (!least || fits[i][best[i]].value < fits[*least][best[*least]].value))
        least = i;
    best[*least] = k;
  }
  return best;
}

std::vector<linkage::Links> LinksOf(const std::vector<GroupOutcome>& designs) {
  std::vector<linkage::Links> links;
  for (const GroupOutcome& design : designs) links.push_back(design.nearest.Links());
  return links;
}

// Designs for these sizes, each from the same size's design before, if there is one, then from `links`.
std::vector<GroupOutcome> DesignSizes(const GroupProblem& problem, const std::vector<compare::StsCurve>& human,
                                      const Assignment& assignment, const std::vector<GroupOutcome>& before,
                                      const std::vector<linkage::Links>& links, std::size_t sizes,
                                      const synthesis::OptimizeOptions& options) {
  std::vector<GroupOutcome> designs;
  for (std::size_t k = 0; k < sizes; ++k) {
    ThrowIfInterrupted();
    std::vector<linkage::Links> starts = links;
    if (!before.empty()) starts.insert(starts.begin(), before[k].nearest.Links());
    const std::vector<std::size_t> members = MembersOf(assignment, k);
    designs.push_back(DesignGroup(ProblemOf(problem, members), Picked(human, members), starts, options));
  }
  return designs;
}

struct Alternation {
  Assignment assignment;
  std::vector<GroupOutcome> designs;
  Fits fits;

  double Value() const {
    double sum = 0;
    for (std::size_t i = 0; i < fits.size(); ++i) sum += fits[i][assignment[i]].value;
    return sum / static_cast<double>(fits.size());
  }
};

// Designs for an assignment, an assignment for the designs, until nobody changes; from few starts, then from those
// before.
Alternation Alternate(const GroupProblem& problem, const std::vector<compare::StsCurve>& human, Assignment first,
                      const std::vector<linkage::Links>& links, std::size_t sizes,
                      const synthesis::OptimizeOptions& options) {
  constexpr int kMostRounds = 10, kFewStarts = 4;
  synthesis::OptimizeOptions few = options;
  Alternation best;
  for (int round = 0; round < kMostRounds; ++round) {
    few.starts = round == 0 ? std::min(kFewStarts, options.starts) : 1;
    Alternation now{first, DesignSizes(problem, human, first, best.designs, links, sizes, few), {}};
    now.fits = FitsOf(problem, LinksOf(now.designs), options);
    constexpr double kBetter_deg = 1e-3;
    if (round > 0 && now.Value() < best.Value() + kBetter_deg) break;
    first = BestOf(now.fits, now.assignment, sizes);
    const bool is_settled = first == now.assignment;
    best = std::move(now);
    if (is_settled) break;
  }
  return best;
}

// Designs from all starts, and on from there until everybody wears the size that is best for them; whether it came to
// that.
bool Settle(const GroupProblem& problem, const std::vector<compare::StsCurve>& human,
            const std::vector<linkage::Links>& links, std::size_t sizes, const synthesis::OptimizeOptions& options,
            Alternation& found) {
  constexpr int kMostRounds = 10;
  synthesis::OptimizeOptions search = options;
  for (int round = 1;; ++round) {
    found.designs = DesignSizes(problem, human, found.assignment, found.designs, links, sizes, search);
    found.fits = FitsOf(problem, LinksOf(found.designs), options);
    Assignment next = BestOf(found.fits, found.assignment, sizes);
    if (next == found.assignment) return true;
    if (round == kMostRounds) return false;
    found.assignment = std::move(next);
    search.starts = 1;  // the design before
  }
}

// Sizes in the order of their wearers' legs.
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

// Design of the person's size without the person, from where it is.
linkage::Links LinksWithout(const SizesOutcome& outcome, const GroupProblem& problem, std::size_t person,
                            const synthesis::OptimizeOptions& options) {
  const std::size_t size = outcome.size_of[person];
  const GroupDesign& design = outcome.sizes[size].nearest;
  std::vector<std::size_t> others;
  std::vector<ReoptimizePoint> points;
  for (std::size_t k = 0; k < outcome.members[size].size(); ++k) {
    if (outcome.members[size][k] == person) continue;
    others.push_back(outcome.members[size][k]), points.push_back(design.points[k]);
  }
  if (others.empty()) return design.Links();
  const GroupProblem without = ProblemOf(problem, others);
  GroupSolve solve = SolveFrom(without, points, options, true);
  if (!solve.IsUsable()) solve = SolveFrom(without, StartPoints(without, design.Links()), options);
  return solve.IsUsable() ? solve.points.front().links : design.Links();
}

std::vector<LeftOut> LeaveEachOut(const SizesOutcome& outcome, const GroupProblem& problem, const Fits& fits,
                                  const synthesis::OptimizeOptions& options) {
  const std::size_t people = problem.people.size();
  const std::vector<std::vector<double>> losses = LossesOf(fits);
  Progress progress("leaving one out", "people", static_cast<std::int64_t>(people), options.quiet);
  const std::vector<std::string> packed = InProcesses(
      people,
      [&](std::size_t i, const std::function<void()>& step) {
        std::vector<std::size_t> others(people);
        std::iota(others.begin(), others.end(), std::size_t{0});
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
        const SizeRule rule = FindRule(outcome.quantities, losses, others);
        const auto quantity = std::ranges::find(outcome.quantities, rule.quantity, &BodyQuantity::name);
        const std::size_t size = rule.SizeFor(quantity->mm[i]);
        const linkage::Links links = size == outcome.size_of[i] ? LinksWithout(outcome, problem, i, options)
                                                                : outcome.sizes[size].nearest.Links();
        const std::string fit = Packed(FitOf(problem.Of(i), links, options));
        step();
        return nlohmann::json{{"size", size}, {"fit", fit}}.dump();
      },
      progress);
  std::vector<LeftOut> left_out;
  for (const std::string& text : packed) {
    const nlohmann::json json = nlohmann::json::parse(text);
    left_out.push_back({json["size"].get<std::size_t>(), UnpackedFit(json["fit"].get<std::string>())});
  }
  return left_out;
}

void AddPeople(const GroupProblem& problem, const std::vector<linkage::Links>& links,
               const synthesis::OptimizeOptions& options, SizesOutcome& outcome) {
  std::vector<linkage::Links> starts = LinksOf(outcome.sizes);
  starts.insert(starts.end(), links.begin(), links.end());
  const std::vector<std::optional<ReoptimizePoint>> own = OwnPoints(problem, starts, options);
  for (std::size_t k = 0; k < outcome.sizes.size(); ++k)
    for (std::size_t i = 0; i < outcome.members[k].size(); ++i)
      outcome.sizes[k].people.push_back(OutcomeOf(outcome.sizes[k], i, own[outcome.members[k][i]]));
}

// The ranges of one quantity with the least loss: dynamic programming over people in its order and the sizes used.
class RangesOfOneQuantity {
 public:
  RangesOfOneQuantity(const BodyQuantity& quantity, const std::vector<std::vector<double>>& losses,
                      std::vector<std::size_t> people)
      : mm_(quantity.mm), losses_(losses), order_(std::move(people)) {
    std::ranges::stable_sort(order_, {}, [&](std::size_t i) { return mm_[i]; });
  }

  SizeRule Find(const std::string& quantity) {
    const std::size_t sizes = losses_.front().size(), sets = std::size_t{1} << sizes;
    best_.assign(order_.size() + 1, std::vector<Step>(sets * sizes));
    for (std::size_t k = 0; k < sizes; ++k) At(0, std::size_t{1} << k, k).loss = 0;
    for (std::size_t n = 0; n < order_.size(); ++n)
      for (std::size_t set = 1; set < sets; ++set)
        for (std::size_t size = 0; size < sizes; ++size)
          if (At(n, set, size).loss < kInfinite) Extend(n, set, size, sizes);
    return Trace(quantity, sizes, sets);
  }

 private:
  struct Step {
    double loss = kInfinite;
    std::size_t set = 0, size = 0;  // before this person
  };

  Step& At(std::size_t n, std::size_t set, std::size_t size) { return best_[n][set * losses_.front().size() + size]; }

  // The nth person with the same size as the one before, or the first of a range of another.
  void Extend(std::size_t n, std::size_t set, std::size_t size, std::size_t sizes) {
    for (std::size_t next = 0; next < sizes; ++next) {
      const std::size_t bit = std::size_t{1} << next;
      const bool may_cut = n > 0 && mm_[order_[n]] > mm_[order_[n - 1]] && !(set & bit);
      if (next != size && !may_cut) continue;
      const double loss = At(n, set, size).loss + losses_[order_[n]][next];
      Step& to = At(n + 1, set | bit, next);
      if (loss < to.loss) to = {loss, set, size};
    }
  }

  SizeRule Trace(const std::string& quantity, std::size_t sizes, std::size_t sets) {
    std::size_t set = 0, size = 0;
    double loss = kInfinite;
    for (std::size_t s = 1; s < sets; ++s)
      for (std::size_t k = 0; k < sizes; ++k)
        if (At(order_.size(), s, k).loss < loss) loss = At(order_.size(), s, k).loss, set = s, size = k;
    SizeRule rule{quantity, {{-kInfinite, kInfinite, size}}, loss / static_cast<double>(order_.size())};
    for (std::size_t n = order_.size(); n > 1; --n) {
      const Step step = At(n, set, size);
      if (step.size != size) {
        const double cut = (mm_[order_[n - 1]] + mm_[order_[n - 2]]) / 2;
        rule.ranges.front().from_mm = cut;
        rule.ranges.insert(rule.ranges.begin(), {-kInfinite, cut, step.size});
      }
      set = step.set, size = step.size;
    }
    return rule;
  }

  const std::vector<double>& mm_;
  const std::vector<std::vector<double>>& losses_;
  std::vector<std::size_t> order_;
  std::vector<std::vector<Step>> best_;
};

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

Fit FitOf(const ReoptimizeProblem& person, const linkage::Links& links, const synthesis::OptimizeOptions& options) {
  constexpr double kNotHeld_deg = 1000;
  const ReoptimizeProblem fixed = WithLinks(person, links);
  Fit fit{false, -2 * kNotHeld_deg, kInfinite, problem::Evaluate(links, person.design).range_deg};
  ReoptimizeSolve solve = SolveFrom(fixed, StartPoint(fixed, links), options);
  if (solve.IsUsable()) {
    fit.holds = true, fit.percent = solve.Misalignment_percent();
    fit.value = fit.range_deg - person.penalty_deg_per_mm * solve.prediction->rms_mm;
    return fit;
  }
  solve = SolveFrom(WithGoal(fixed, ReoptimizeProblem::Goal::kMisalignment), StartPoint(fixed, links), options);
  if (!solve.IsUsable()) return fit;
  fit.percent = solve.Misalignment_percent();
  fit.value = -kNotHeld_deg - fit.percent;
  // The limit may be met so closely that no interior point is left.
  constexpr double kTolerance = 1e-4;
  if (person.max_misalignment_percent && fit.percent <= *person.max_misalignment_percent * (1 + kTolerance))
    fit.holds = true, fit.value = fit.range_deg - person.penalty_deg_per_mm * solve.prediction->rms_mm;
  return fit;
}

std::size_t SizeRule::SizeFor(double quantity_mm) const {
  for (const RuleRange& range : ranges)
    if (quantity_mm <= range.to_mm) return range.size;
  return ranges.back().size;
}

SizeRule FindRule(const std::vector<BodyQuantity>& quantities, const std::vector<std::vector<double>>& losses,
                  const std::vector<std::size_t>& people) {
  SizeRule best;
  for (const BodyQuantity& quantity : quantities) {
    SizeRule rule = RangesOfOneQuantity(quantity, losses, people).Find(quantity.name);
    constexpr double kBetter_deg = 1e-3;
    if (best.ranges.empty() || rule.loss_deg < best.loss_deg - kBetter_deg) best = std::move(rule);
  }
  return best;
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
    throw UsageError(
        fmt::format("--sizes {}: 2 to {}, and at least two people for each; there are {}", sizes, kMostSizes, people));
}

SizesOutcome RunSizes(const GroupProblem& shared, const std::vector<PersonMeasured>& people, int sizes,
                      const std::vector<double>& heights_mm, const synthesis::OptimizeOptions& options) {
  shared.CheckOptions();
  CheckSizes(shared, sizes, people.size());
  const auto count = static_cast<std::size_t>(sizes);
  const GroupProblem problem = PutMotionsInto(shared, people);
  std::vector<compare::StsCurve> human;
  for (const PersonMeasured& person : people) human.push_back(person.motion.human);
  const std::vector<linkage::Links> links = StartLinks(problem, people, options);
  SizesOutcome outcome;
  outcome.quantities = QuantitiesOf(problem, heights_mm);
  const std::vector<double>& leg_mm = std::ranges::find(outcome.quantities, "leg_mm", &BodyQuantity::name)->mm;
  Alternation best;
  for (const Assignment& first : FirstAssignments(problem, leg_mm, count, options.seed)) {
    Alternation found = Alternate(problem, human, first, links, count, options);
    if (outcome.assignments++ == 0 || found.Value() > best.Value()) best = std::move(found);
  }
  outcome.is_settled = Settle(problem, human, links, count, options, best);
  Sort(leg_mm, best);
  outcome.sizes = std::move(best.designs), outcome.size_of = best.assignment;
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

}  // namespace lake::redesign
