// What the leg bears of the actuator's moment and the device's weight: statics of the first order, in which the links
// have not moved against the leg. Sagittal plane, the hinge on the knee, every cuff as stiff per mm as every other,
// across and along, so that stiffness cancels out. No misfit: its forces are CourseOf's.
//
// Each link is a free body: cuffs, hinge, weight, and the actuator's moment. Where cuffs could share in many ways, they
// do so as springs, with the least energy. Of a cuff at a, L long, on either segment, at the flexion θ, no weight:
//
//   across  M/a · s/(s + L²/12),   along  cot(θ/2) · across,   couple  M · (L²/12)/(s + L²/12),   s = a² sin²(θ/2)
//
// The hinge rests on nothing, and passes on from link to link what the cuffs leave: near a straight knee, where both
// segments are pushed forward, there is nothing to lean on but the cuffs' length.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lake/cuffs/cuff_model.h"

namespace lake::cuffs {

// Angles from the vertical, positive when the upper end leans forward.
struct Posture {
  double thigh_deg = 0, shank_deg = 0;
};

// A cuff's on its segment.
struct CuffReaction {
  Eigen::Vector2d force_n = Eigen::Vector2d::Zero();  // across (anterior), along (up)
  double moment_nm = 0;                               // a couple by its length, forward
  // With which its more loaded side presses, and what it pulls along: a couple presses with both ends, and its force
  // is none.
  double pressed_n = 0;
};

struct LegStatics {
  std::vector<CuffReaction> thigh, shank;
  double largest_thigh_n = 0, largest_shank_n = 0;  // pressed_n of the cuffs
  // What the knee passes from thigh to shank of what the cuffs do to the thigh. The ground under the foot bears the
  // device's weight.
  double knee_shear_n = 0;        // across the shank
  double knee_compression_n = 0;  // along it; negative: the cuffs pull the knee apart
};

// `moment_nm`: the actuator's, extending the knee. NaN where the cuffs cannot bear it: they have no length, and the
// knee is straight. Throws UsageError as CheckCuffs.
LegStatics StaticsOf(const Posture& posture, double moment_nm, const CuffOptions& cuffs);

}  // namespace lake::cuffs
