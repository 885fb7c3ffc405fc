#include "filter_loss.h"

#include <cmath>

#include "lake/core/error.h"
#include "lake/core/statistics.h"

namespace lake::gait {

void AccountForFilterLoss(const std::vector<double>& taken_deg, double cutoff_hz, motion::LegMotion& motion) {
  // Real sit-to-stands lose this share of their variance at 0.6 to 0.8 Hz, and a millionth at 6 Hz.
  constexpr double kMostShare = 0.05;
  constexpr double kMovement_deg = 1;  // root mean square; less than that may be a still person's own jitter
  std::vector<double> taken, angles;
  for (std::size_t i = 0; i < taken_deg.size(); ++i) {
    if (!std::isfinite(taken_deg[i])) continue;
    taken.push_back(taken_deg[i]);
    angles.push_back(motion.samples[i].knee_deg - taken_deg[i]);
    motion.samples[i].knee_sigma_deg = std::hypot(motion.samples[i].knee_sigma_deg, taken_deg[i]);
  }
  const double rms_deg = RootMeanSquare(taken), share = std::pow(rms_deg / StandardDeviation(angles), 2);
  if (share > kMostShare && rms_deg > kMovement_deg)
    throw Fail(
        "leg fit: a cutoff of {} Hz takes {:.0f} % of the knee angle's variance, {:.1f} deg (RMS): that is the "
        "movement "
        "itself; give a higher --cutoff, or none",
        cutoff_hz, 100 * share, rms_deg);
}

}  // namespace lake::gait
