// The slope of noisy points that some of them cannot spoil.
#pragma once

#include <span>

namespace lake::actuator {

// Least squares on the points that a first line by Theil & Sen (the median of the slopes of all pairs; Sen 1968,
// doi:10.1080/01621459.1968.10480934) leaves within four robust deviations, or within the step of the readings: the
// median alone would stick to multiples of that step. 29 % of the points may be wrong. Of more than `kMostSlopePoints`
// points, means of equal groups are taken. Slope and error are NaN for fewer than three points or one x.
struct RobustSlope {
  double slope = 0, standard_error = 0;
};
inline constexpr std::size_t kMostSlopePoints = 300;
RobustSlope FitRobustSlope(std::span<const double> x, std::span<const double> y);

}  // namespace lake::actuator
