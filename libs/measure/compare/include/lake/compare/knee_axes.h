// How precise the axes of rotation are that stand for the knees' markers of a comparison.
#pragma once

#include <optional>

namespace lake::compare {

// Standard deviations, mm, along each direction across the axis; none: that trial's knee is its marker.
struct KneeAxes {
  std::optional<double> human_mm{}, exo_mm{};
};

}  // namespace lake::compare
