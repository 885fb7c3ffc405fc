#include "noise_from_differences.h"

#include <algorithm>
#include <array>

#include "lake/core/statistics.h"

namespace lake::gait {

double NoiseFromDifferences(const motion::MarkerTrack& track, const std::vector<char>& seen) {
  constexpr std::array<double, 7> kSixth = {1, -6, 15, -20, 15, -6, 1};
  constexpr double kGain = 30.397368307141326;  // √924
  constexpr double kLeast = 1e-3;
  std::vector<double> differences;
  for (std::size_t i = 0; i + kSixth.size() <= seen.size(); ++i) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    bool whole = true;
    for (std::size_t k = 0; k < kSixth.size() && whole; ++k) {
      whole = seen[i + k] != 0;
      if (whole) sum += kSixth[k] * track.samples[i + k].position;
    }
    if (whole) differences.insert(differences.end(), {sum.x(), sum.y()});
  }
  return differences.empty() ? kLeast : std::max(RobustDeviation(differences) / kGain, kLeast);
}

}  // namespace lake::gait
