#include "lake/gait/neutral_pose.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "sizes.h"

namespace lake::gait {

motion::LegSample NeutralPose(const LegFitResult& leg, double from_s, double to_s) {
  constexpr double kMostSway_deg = 3, kMostBend_deg = 30;
  from_s = std::max(from_s, leg.motion.time_s.front());
  to_s = std::min(to_s, leg.motion.time_s.back());
  motion::LegSample pose;
  for (const motion::Angle& angle : motion::Angles()) {
    std::vector<double> deg, sigma_deg;
    for (std::size_t i = 0; i < leg.motion.samples.size(); ++i) {
      const motion::LegSample& sample = leg.motion.samples[i];
      if (leg.motion.time_s[i] < from_s || leg.motion.time_s[i] > to_s || !std::isfinite(sample.*angle.deg)) continue;
      deg.push_back(sample.*angle.deg);
      sigma_deg.push_back(sample.*angle.sigma_deg);
    }
    const bool is_of_leg = angle.deg == &motion::LegSample::knee_deg || angle.deg == &motion::LegSample::shank_deg;
    if (is_of_leg && deg.size() < kLeastFrames)
      throw Fail("no quiet standing from {:g} to {:g} s: {} frames show the leg there, at least {} are needed", from_s,
                 to_s, deg.size(), kLeastFrames);
    if (deg.size() < kLeastFrames) continue;
    const double sway_deg = StandardDeviation(deg);
    if (is_of_leg && sway_deg > kMostSway_deg)
      throw Fail("no quiet standing from {:g} to {:g} s: the {}'s angle sways by {:.1f} deg (SD) there, at most {:g}",
                 from_s, to_s, angle.name, sway_deg, kMostSway_deg);
    pose.*angle.deg = Mean(deg);
    pose.*angle.sigma_deg = std::hypot(sway_deg, RootMeanSquare(sigma_deg));
  }
  if (pose.knee_deg > kMostBend_deg)
    throw Fail("no quiet standing from {:g} to {:g} s: the knee is bent by {:.0f} deg there", from_s, to_s,
               pose.knee_deg);
  return pose;
}

}  // namespace lake::gait
