// The rate at which a recording was made that another one shows with repeated frames. Not part of the interface.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace lake::tracking {

// Frame floor(ratio · i + phase) of the source is shown in frame i.
struct LowerRate {
  double ratio = 1, phase = 0;

  double Source(std::size_t i) const;
  bool Repeats(std::size_t i) const { return i > 0 && Source(i) == Source(i - 1); }
};

// A frame of which it can be told whether it repeats the one before.
struct ToldFrame {
  std::size_t frame = 0;
  bool is_repeated = false;
};

// The rate whose repetitions are those that were found (Beatty's sequence): the likeliest, where one in 33 frames is
// told wrongly and a ratio of denominator n has the odds 1/n². nullopt if there are too few, or it is likelier that
// they recur in no such way.
std::optional<LowerRate> FindLowerRate(const std::vector<ToldFrame>& told);

}  // namespace lake::tracking
