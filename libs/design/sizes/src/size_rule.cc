#include <algorithm>

#include "lake/core/numbers.h"
#include "lake/sizes/sizes.h"

namespace lake::sizes {
namespace {

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
          if (At(n, set, size).loss < kInfinity) Extend(n, set, size, sizes);
    return Trace(quantity, sizes, sets);
  }

 private:
  struct Step {
    double loss = kInfinity;
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
    double loss = kInfinity;
    for (std::size_t s = 1; s < sets; ++s)
      for (std::size_t k = 0; k < sizes; ++k)
        if (At(order_.size(), s, k).loss < loss) {
          loss = At(order_.size(), s, k).loss;
          set = s;
          size = k;
        }
    SizeRule rule{quantity, {{-kInfinity, kInfinity, size}}, loss / static_cast<double>(order_.size())};
    for (std::size_t n = order_.size(); n > 1; --n) {
      const Step step = At(n, set, size);
      if (step.size != size) {
        const double cut = (mm_[order_[n - 1]] + mm_[order_[n - 2]]) / 2;
        rule.ranges.front().from_mm = cut;
        rule.ranges.insert(rule.ranges.begin(), {-kInfinity, cut, step.size});
      }
      set = step.set;
      size = step.size;
    }
    return rule;
  }

  const std::vector<double>& mm_;
  const std::vector<std::vector<double>>& losses_;
  std::vector<std::size_t> order_;
  std::vector<std::vector<Step>> best_;
};

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
    SizeRule rule = RangesOfOneQuantity(quantity, losses, people).Find(quantity.name);
    constexpr double kBetter_deg = 1e-3;
    if (best.ranges.empty() || rule.loss_deg < best.loss_deg - kBetter_deg) best = std::move(rule);
  }
  return best;
}

}  // namespace lake::sizes
