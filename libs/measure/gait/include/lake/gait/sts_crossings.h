// Onset and standing between frames. The events are found frame by frame (sts_events.h); at 30 frames/s half a frame is
// 1 % of a sit-to-stand, and at full speed 3 mm of the knee's path, so where that matters the crossing itself is
// interpolated.
#pragma once

#include <cstddef>
#include <vector>

#include "lake/gait/sts_events.h"
#include "lake/motion/leg_motion.h"

namespace lake::gait {

class StsCrossings {
 public:
  // `motion` in mm; it must outlive this. The limits are those by which its events were found.
  explicit StsCrossings(const motion::LegMotion& motion, const StsOptions& limits = {});

  // When the signals leave the rest, in the step that ends at the onset's frame; its middle if none of them is seen to.
  double OnsetSeconds(std::size_t frame) const;

  // When the knee's extension has slowed down to the limit, in the step that ends at the frame of standing; its middle
  // if that is not seen. `onset`: the onset's frame.
  double StandingSeconds(std::size_t onset, std::size_t frame) const;

 private:
  const motion::LegMotion& motion_;
  StsOptions limits_;
  std::vector<double> hip_height_, trunk_deg_s_;
};

}  // namespace lake::gait
