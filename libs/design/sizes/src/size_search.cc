#include "size_search.h"

#include <algorithm>

#include "lake/core/interrupt.h"
#include "lake/core/processes.h"
#include "lake/core/progress.h"

namespace lake::sizes {
namespace {

constexpr int kMostRounds = 10;

}  // namespace

std::vector<std::size_t> MembersOf(const Assignment& sizes, std::size_t size) {
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < sizes.size(); ++i)
    if (sizes[i] == size) members.push_back(i);
  return members;
}

GroupProblem ProblemOf(const GroupProblem& all, const std::vector<std::size_t>& members) {
  GroupProblem problem = all;
  problem.people = Picked(all.people, members);
  return problem;
}

double Alternation::Value() const {
  double sum = 0;
  for (std::size_t i = 0; i < fits.size(); ++i) sum += fits[i][assignment[i]].value;
  return sum / static_cast<double>(fits.size());
}

Alternation SizeSearch::Alternate(const Assignment& first) {
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

bool SizeSearch::Settle(From from, Alternation& found) {
  found = DesignFor(found.assignment, found, from, from == From::kFound ? 1 : options_.starts);
  for (int round = 1;; ++round) {
    const Assignment next = BestOf(found);
    if (next == found.assignment) return true;
    if (round == kMostRounds) return false;
    found = DesignFor(next, found, From::kFound, 1);
  }
}

Alternation SizeSearch::DesignFor(const Assignment& assignment, const Alternation& before, From from, int starts) {
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

DesignTask SizeSearch::TaskFor(const Members& members, std::size_t size, const Alternation& before, From from) const {
  DesignTask task{
      .problem = ProblemOf(problem_, members), .human = Picked(human_, members), .links = links_, .close_by = {}};
  if (before.designs.empty()) return task;
  task.links.insert(task.links.begin(), before.designs[size].nearest.Links());
  if (from == From::kFound) task.close_by = PointsBefore(members, size, before);
  return task;
}

// Whoever is new to the size begins with its links.
std::vector<RedesignPoint> SizeSearch::PointsBefore(const Members& members, std::size_t size,
                                                    const Alternation& before) const {
  const group::GroupDesign& design = before.designs[size].nearest;
  const Members earlier = MembersOf(before.assignment, size);
  std::vector<RedesignPoint> points;
  for (const std::size_t i : members) {
    const auto place = std::ranges::find(earlier, i);
    points.push_back(place == earlier.end() ? StartPoint(problem_.Of(i), design.Links())
                                            : design.points[static_cast<std::size_t>(place - earlier.begin())]);
  }
  return points;
}

void SizeSearch::FindFits(Alternation& found) {
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

// Each person's best size; of equals the present one. A size that nobody chose gets the person with the least value of
// those who are not the only one of their size.
Assignment SizeSearch::BestOf(const Alternation& found) const {
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
      if (MembersOf(best, best[i]).size() > 1 && (!least || fits[i][best[i]].value < fits[*least][best[*least]].value))
        least = i;
    best[*least] = k;
  }
  return best;
}

}  // namespace lake::sizes
