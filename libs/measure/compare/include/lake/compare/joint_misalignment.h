// The joint misalignment: where the exoskeleton's joint is against the knee of the leg that wears it, at the same
// instants of the same trial. It depends neither on pace nor on posture, which the difference between two trials' paths
// holds as well.
#pragma once

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
  // RMS of what is left then at the next rise: how the place varies within a rise, and, of several rises, how it slips
  // from one to the next and how well the joint is put where it is meant to be. Of one rise it is the least that can be
  // left.
  double remainder_mm = 0;
  // RMS difference of the angles that ankle, joint and hip make and ankle, knee and hip.
  double angle_rms_deg = 0;
  struct Intervals {
    Interval rms_mm, max_mm, mean_x_mm, mean_y_mm, remainder_mm, angle_rms_deg;
  };
  std::optional<Intervals> intervals;
  int repetitions = 0;
};

struct JointOptions {
  double replacement_sd_mm = 0;  // per axis: how well a joint is put where it is meant to be
  bool intervals = true;
};

// nullopt if no repetition shows the leg's own knee. Intervals (95 %) are of the mean over many repetitions, by the
// jackknife and Student's t; one repetition has none, as it does not show how the joint slips from rise to rise.
// `spike`: samples to leave out.
std::optional<JointMisalignment> FindJointMisalignment(const RegisteredTrial& exo, const std::vector<bool>& spike,
                                                       const JointOptions& options = {});

// Standard deviation, per axis, of the mean place over a rise by its markers' noise, which is correlated over about two
// percent of the rise each way.
double MarkerNoiseOfMeanMm(const StsCurve& curve);

}  // namespace lake::compare
