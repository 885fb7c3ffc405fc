// What all models of a worn mechanism share: the person's segments, the cuffs, and where they are in the pose that the
// files hold: shank and trunk upright, the knee as bent as the mechanism's reference has it.
//
// The sagittal plane, m: x anterior, y up, origin at the ankle. Leans forward positive. A segment's own axes are x
// anterior and y up the segment, its origin the joint at its lower end.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "lake/model/coupled_model.h"
#include "rigid_bodies.h"

namespace lake::model {

inline constexpr double kBeside_m = 0.06;  // from the leg's middle to the plates, outwards on a left leg

struct WornSegment {
  const char* name;
  double mass_kg = 0, inertia_kg_m2 = 0;  // about the centre of mass, of a turn in the plane
  Eigen::Vector2d centre_m;               // own axes
  double length_m = 0, radius_m = 0;      // to be shown
  Eigen::Vector2d at_m;
  double lean_rad = 0;

  double LongInertia() const;  // about the long axis, which a planar motion does not feel
};

// Pads and joints of persons have no mass or damping of their own; a pad's damping keeps a simulation calm and leaves
// forces at rest as they are.
inline constexpr double kCuffDamping_n_s_m = 200, kCuffDamping_nm_s = 2;

struct WornCuff {
  std::string name;
  bool on_thigh = true;
  double up_m = 0;           // on its segment
  Eigen::Vector2d slip_m;    // in the file's pose, own axes of the segment
  double stiffness_n_m = 0;  // across and along
  double turn_nm = 0;        // per rad

  const char* Segment() const { return on_thigh ? "thigh" : "shank"; }
  const char* Link() const { return on_thigh ? "thigh_plate" : "shank_link"; }
};

struct WornBody {
  RigidBodies mechanism;
  double knee_rad = 0;
  WornSegment foot, shank, thigh, trunk;
  std::vector<WornCuff> cuffs;
  Eigen::Vector2d hinge_m;  // the thigh plate leans as the thigh does
};

// Throws UsageError for cuffs that LoadOnLeg refuses.
WornBody WornBodyOf(const parts::Mechanism& mechanism, const Subject& subject);

// The hip's angle: lean of the trunk less that of the thigh.
double HipDeg(const WornSample& sample);

}  // namespace lake::model
