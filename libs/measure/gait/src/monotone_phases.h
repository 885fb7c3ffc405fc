// Monotone phases of a signal: of the hip's height in rises, of the foot's place relative to the hip in walking.
#pragma once

#include <vector>

namespace lake::gait {

// Samples from `begin` to `end`, both included.
struct Span {
  std::size_t begin, end;
};

// Between two turning points.
struct MonotonePhase : Span {
  bool rising;
};

// Turning points that differ by at least `threshold`, smaller wiggles skipped; the phases between them.
std::vector<MonotonePhase> FindMonotonePhases(const std::vector<double>& values, double threshold);

}  // namespace lake::gait
