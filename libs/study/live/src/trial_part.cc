#include "lake/live/trial_part.h"

#include <algorithm>
#include <iterator>

namespace lake::live {

TrialPart PartOfTrial(const TrialPart& asked, std::span<const double> moves_s, std::span<const double> onsets_s) {
  std::optional<double> last_s;
  for (const double onset_s : onsets_s)
    if ((!asked.begin_s || onset_s >= *asked.begin_s) && (!asked.end_s || onset_s <= *asked.end_s))
      last_s = last_s ? std::max(*last_s, onset_s) : onset_s;
  TrialPart part = asked;
  if (!last_s) return part;
  const auto next = std::ranges::upper_bound(moves_s, *last_s);
  if (next != moves_s.begin()) part.begin_s = std::max(asked.begin_s.value_or(0), *std::prev(next));
  if (next != moves_s.end()) part.end_s = asked.end_s ? std::min(*asked.end_s, *next) : *next;
  return part;
}

}  // namespace lake::live
