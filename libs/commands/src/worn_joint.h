// What seat and limbs allow of a worn linkage whose joint is moved onto the knee.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "lake/core/json.h"
#include "lake/linkage/design_file.h"
#include "lake/linkage/wear.h"

namespace lake::commands {

struct WornJoint {
  linkage::WearCheck as_worn, moved;  // on this person, the joint where it was and where it is best
  // Of the places nearer to the knee than as worn, and within 40 mm of it, at which linkage and actuator reach no
  // further into seat and limbs than as worn, the nearest to the knee, in steps of 2 mm, shank frame; absent: there is
  // none.
  std::optional<Eigen::Vector2d> nearest_mm;
};

// `offset_mm`: where the joint was from the knee, shank frame. Throws Error where the links cannot be assembled.
WornJoint CheckWornJoint(const linkage::Design& worn, const Eigen::Vector2d& offset_mm, const person::Body& body,
                         linkage::WearOptions wear);

// Sentences for people: what is in the way, and how near to the knee the joint may be instead. `unmoved_mm`: what
// moving leaves of the joint misalignment, RMS.
std::string WornJointText(const WornJoint& joint, double unmoved_mm);

Json WornJointJson(const WornJoint& joint);

}  // namespace lake::commands
