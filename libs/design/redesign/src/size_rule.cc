#include <algorithm>

#include "lake/core/numbers.h"
#include "lake/redesign/sizes.h"

namespace lake::redesign {
namespace {

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

}  // namespace lake::redesign
