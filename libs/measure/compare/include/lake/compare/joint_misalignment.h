// The joint misalignment: where the exoskeleton's joint is against the knee of the leg that wears it, at the same
// instants of the same trial. It depends neither on pace nor on posture, which the difference between two trials' paths
// holds as well.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lake/compare/interval.h"
#include "lake/compare/registration.h"

namespace lake::compare {

struct JointMisalignment {
  // Joint less knee, mm, per percent: the mean over the repetitions. In the shank's frame (x anterior, y from ankle to
  // knee) and in the thigh's (y from knee to hip).
  std::vector<Eigen::Vector2d> shank_mm, thigh_mm;
  // Spikes left out.
  double rms_mm = 0, max_mm = 0;
  double relative_rms = 0;                            // of the worn leg's shank length
  Eigen::Vector2d mean_mm = Eigen::Vector2d::Zero();  // shank frame; moving the joint by −mean_mm removes it
  double remainder_mm = 0;                            // RMS of what is left then
  // RMS difference of the angles that ankle, joint and hip make and ankle, knee and hip.
  double angle_rms_deg = 0;
  struct Intervals {
    Interval rms_mm, max_mm, mean_x_mm, mean_y_mm, remainder_mm, angle_rms_deg;
  };
  std::optional<Intervals> intervals;
  int repetitions = 0;
};

struct JointNoise {
  int resamples = 300;  // of the intervals; 0: none
  std::uint64_t seed = 1;
  double width_percent = 2;  // over which a marker's noise is correlated
  double event_sd_s = 0.02;  // of onset and standing, beside what the fit says of their times
};

// nullopt if no repetition shows the leg's own knee. Intervals (95 %) are of the mean over repetitions like these: of
// several, they are as wide as Student's t asks for their number; of one, its markers' noise and the times of its
// events are all that is known. `spike`: samples to leave out.
std::optional<JointMisalignment> FindJointMisalignment(const RegisteredTrial& exo, const std::vector<bool>& spike,
                                                       const JointNoise& noise = {});

}  // namespace lake::compare
