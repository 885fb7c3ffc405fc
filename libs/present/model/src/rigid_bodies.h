// The mechanism as rigid bodies, in the thigh frame with z through the layers, SI units.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "lake/parts/mechanism.h"

namespace lake::model {

inline constexpr double kMetresPerMillimetre = 1e-3;

struct RigidBody {
  std::string name;                   // shank_link
  Eigen::Isometry3d thigh_from_body;  // in the reference pose
  double mass_kg = 0;
  Eigen::Vector3d centre_m;
  Eigen::Matrix3d inertia_kg_m2;  // about the centre of mass, in the body's axes
  // Its shape: a plate's outline as a polygon with the heights that it lies between, or a cylinder along x.
  std::vector<Eigen::Vector2d> outline_m;
  double low_m = 0, high_m = 0;
  double cylinder_from_m = 0, cylinder_to_m = 0, cylinder_radius_m = 0;

  bool IsCylinder() const { return cylinder_radius_m > 0; }
};

enum class BodyIndex { kThighPlate, kShankLink, kCoupler, kSlewingBar, kActuatorBody, kActuatorRod };

struct RigidBodies {
  linkage::Pose reference;
  std::array<RigidBody, 6> bodies;

  const RigidBody& operator[](BodyIndex index) const { return bodies[static_cast<std::size_t>(index)]; }
};
RigidBodies RigidBodiesOf(const parts::Mechanism& mechanism);

// Where the frame of the models is: model_from_thigh.
Eigen::Matrix3d ModelFromThigh();

}  // namespace lake::model
