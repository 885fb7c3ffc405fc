// Strength of plates and the actuator's rod under the forces of the range: nominal stresses against the yield strength.
//
// - Bearing of a hole, F / (pin diameter x thickness), and net section of coupler and slewing bar,
//   F / ((width - hole) x thickness): Budynas & Nisbett, Shigley's Mechanical Engineering Design, 9th ed. 2011,
//   sec. 8-12. Held against the yield strength; stress concentrations, wear and
//   fatigue are left out.
// - Bending of the shank link at S, where its moment is the knee torque: torque x half width / second moment of the net
//   section (ibid., sec. 3-10).
// - Buckling of the actuator's rod: Euler's load of a steel rod that is pinned at M and R and as long as they are apart
//   (ibid., sec. 4-12). That leaves out that the cylinder stiffens it.
//
// Bending of the thigh plate, and bending of pins and plates by forces in different layers, are not checked.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lake/linkage/linkage.h"
#include "lake/parts/mechanism.h"

namespace lake::parts {

struct LoadedPose {
  linkage::Pose pose;
  double knee_torque_nm = 0;  // NaN: unknown, left out
  linkage::MemberForces forces;
};

// One check, at the pose with the least safety factor.
struct StrengthCheck {
  enum class Kind { kBearing, kNetSection, kBending, kBuckling };

  Kind kind = Kind::kBearing;
  std::string part, check;  // in words
  LoadedPose at;
  double load = 0;                   // N, or N m for bending
  std::optional<double> stress_mpa;  // not for buckling
  double allowed = 0;                // the load at the limit

  double Safety() const { return allowed / load; }
  double KneeAngle_deg() const;
  const char* Unit() const { return kind == Kind::kBending ? "N m" : "N"; }
};

// The loads at which the checks reach their limits, whatever the linkage and its pose.
struct Capacity {
  double coupler_n = 0, bar_n = 0, actuator_n = 0;  // bearing and net section
  double rod_nmm2 = 0;                              // of a rod that pushes: force x length^2
  double knee_torque_nm = 0;                        // bending of the shank link
};
Capacity CapacityOf(const PartOptions& options);

// Checks without any load (a rod that only pulls) are left out.
std::vector<StrengthCheck> CheckStrength(const Mechanism& mechanism, std::span<const LoadedPose> poses);

}  // namespace lake::parts
