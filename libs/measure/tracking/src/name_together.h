// The likeliest names of several tracklets at once: where all of a leg begins anew, as behind a gap, a tracklet by
// itself may go on as more than one marker, and the markers seen with it decide.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace lake::tracking {

// A tracklet, by its index, that may be a marker, by its name's index.
struct NamedTracklet {
  std::size_t tracklet = 0, name = 0;
  double misfit = 0;  // the logarithm of the odds against it, by itself
};

// The logarithm of the odds against two tracklets having these names, by how they lie; nullopt: they cannot.
using PairMisfit = std::function<std::optional<double>(const NamedTracklet&, const NamedTracklet&)>;

// `choices` has those of each name. No tracklet gets two names, a name one tracklet or none, which costs nothing; the
// sum of all misfits is least. Every combination is looked at: the product of the numbers of choices should be small.
std::vector<NamedTracklet> LikeliestTogether(const std::vector<std::vector<NamedTracklet>>& choices,
                                             const PairMisfit& pair_misfit);

}  // namespace lake::tracking
