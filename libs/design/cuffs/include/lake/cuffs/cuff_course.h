// The forces at the cuffs over a rise, of a hinge beside the knee that its actuator holds at the knee's angle. They
// come from the misfit alone and are in proportion to it: neither the actuator's moment nor the device's weight is in
// them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lake/cuffs/cuff_model.h"

namespace lake::cuffs {

// N, with what the stiffness and the place's own uncertainty leave open (95 %).
struct CuffForce {
  double force_n = 0, low_n = 0, high_n = 0;
};

// Per sample; of a segment's cuffs the largest.
struct CuffCourse {
  std::vector<CuffForce> thigh_n, shank_n, knee_shear_n;
};

// The largest over the course.
CuffForce Largest(const std::vector<CuffForce>& course);

// Where the hinge is against the knee at standing: shank's frame (x anterior, y up the shank), standard deviation along
// the way there.
struct HingePlace {
  Eigen::Vector2d mm = Eigen::Vector2d::Zero();
  double sd_mm = 0;
};

// `flexion_deg`: the knee's, per sample; the last is standing, where the cuffs are free of stress. Of the stiffnesses
// the geometric mean is expected. Throws as LoadOnLeg.
CuffCourse CourseOf(const std::vector<double>& flexion_deg, const HingePlace& place, const CuffOptions& options);

}  // namespace lake::cuffs
