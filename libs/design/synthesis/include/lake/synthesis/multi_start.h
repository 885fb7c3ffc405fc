// Local solves from many starts: which is the best of them, and how many are enough.
#pragma once

#include <cmath>
#include <type_traits>
#include <utility>
#include <vector>

#include "lake/core/interrupt.h"
#include "lake/core/progress.h"
#include "lake/linkage/linkage.h"

namespace lake::synthesis {

// Whether an end with this objective (to be maximised) counts as better. Of equals the first is kept.
inline bool IsBetter(double objective, double other) {
  constexpr double kBetter = 1e-5;  // deg, s, mm or percent
  return objective > other + kBetter;
}

// Ends of local solves, in order of their starts. A `Solve` has IsUsable() and an `objective`; of the many that are
// neither the first nor the best, one with KeepOutcome() drops how it came to its end.
template <typename Solve>
struct MultiStart {
  std::vector<Solve> starts;
  int best = -1;  // index of the best usable start; -1: none

  bool IsSolved() const { return best >= 0; }
  const Solve& Best() const { return starts.at(best); }
  const Solve& BestOrFirst() const { return starts.at(IsSolved() ? best : 0); }
  Solve TakeBestOrFirst() { return std::move(starts.at(IsSolved() ? best : 0)); }

  int Usable() const {
    int count = 0;
    for (const Solve& solve : starts) count += solve.IsUsable();
    return count;
  }

  void Add(Solve solve) {
    const int last = static_cast<int>(starts.size());
    int dropped = last;  // of it and the best so far
    if (solve.IsUsable() && (!IsSolved() || IsBetter(solve.objective, Best().objective)))
      dropped = std::exchange(best, last);
    starts.push_back(std::move(solve));
    if constexpr (requires { starts.front().KeepOutcome(); })
      if (dropped > 0) starts[dropped].KeepOutcome();
  }

  static constexpr double kSame = 1e-3;  // deg, s or percent: ends of one optimum agree to 1e-6

  // Whether a second start has come to the best optimum so far.
  bool IsConfirmed() const {
    int ends = 0;
    for (const Solve& solve : starts)
      ends += IsSolved() && solve.IsUsable() && std::abs(solve.objective - Best().objective) < kSame;
    return ends > 1;
  }

  // Whether no further optimum is to be expected. With n usable ends at w different optima, the expected total is w (n
  // - 1) / (n - w - 2); the search is over when that exceeds w by less than one half (Boender & Rinnooy Kan, Math.
  // Program. 37, 1987).
  bool HasAllOptima() const {
    std::vector<double> optima;
    for (const Solve& solve : starts) {
      bool is_known = !solve.IsUsable();
      for (const double optimum : optima) is_known = is_known || std::abs(optimum - solve.objective) < kSame;
      if (!is_known) optima.push_back(solve.objective);
    }
    const int found = static_cast<int>(optima.size()), ends = Usable();
    return ends > found + 2 && found * (ends - 1) < (found + 0.5) * (ends - found - 2);
  }
};

// What ends a search before its last start.
enum class Until { kLastStart, kAllOptima, kConfirmed, kUsable };

// Solves from each of the starts in turn. Throws Interrupted on a signal, and what `solve` throws.
template <typename SolveFromLinks>
auto SolveFromEach(const std::vector<linkage::Links>& starts, const SolveFromLinks& solve,
                   Until until = Until::kLastStart, Progress* progress = nullptr) {
  MultiStart<std::invoke_result_t<SolveFromLinks, const linkage::Links&>> search;
  for (const linkage::Links& start : starts) {
    ThrowIfInterrupted();
    search.Add(solve(start));
    if (progress) progress->Advance();
    if (until == Until::kAllOptima && search.HasAllOptima()) break;
    if (until == Until::kConfirmed && search.IsConfirmed()) break;
    if (until == Until::kUsable && search.IsSolved()) break;
  }
  return search;
}

}  // namespace lake::synthesis
