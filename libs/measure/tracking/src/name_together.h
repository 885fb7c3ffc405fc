// The likeliest names of several pieces at once: where all of a leg begins anew, as behind a gap, a piece by itself may
// go on as more than one marker, and what is seen with it tells.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace lake::tracking {

// A piece, by its index, that may be a marker, by its name's index.
struct NamedPiece {
  std::size_t piece = 0, name = 0;
  double misfit = 0;  // the logarithm of the odds against it, by itself
};

// The logarithm of the odds against two pieces having these names, by how they lie; nullopt: they cannot.
using PairMisfit = std::function<std::optional<double>(const NamedPiece&, const NamedPiece&)>;

// `choices` has those of each name. No piece gets two names, a name one piece or none, which costs nothing; the sum of
// all misfits is least. Every combination is looked at: the product of the numbers of choices should be small.
std::vector<NamedPiece> LikeliestTogether(const std::vector<std::vector<NamedPiece>>& choices,
                                          const PairMisfit& pair_misfit);

}  // namespace lake::tracking
