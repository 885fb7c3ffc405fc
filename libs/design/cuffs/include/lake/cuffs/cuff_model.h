// What an exoskeleton's cuffs do to the leg: its links are rigid and joined by a hinge, each is held to its segment by
// one or more cuffs, which yield in proportion to their slip. Sagittal plane, quasi-static.
//
//   energy = ½ Σ slipᵀ K slip − moment · turn − weights · movement,   least over the pose of both links
//
// A hinge that is free to turn lets two short cuffs have their way; one that an actuator holds does not.
// A cuff of length L resists a turn as a row of springs does: k L²/12.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "lake/core/options.h"

namespace lake::cuffs {

// On one segment. Distances from the knee, along the segment, mm.
struct Cuff {
  double from_knee_mm = 0;
  double length_mm = 80;
};

// Stiffness of cuff and flesh, N/mm, across the segment (compression) and along it (shear).
struct Stiffness {
  double across_n_mm = 1.5, along_n_mm = 1.5;
};

struct CuffOptions {
  std::vector<Cuff> thigh{{200, 80}};
  std::vector<Cuff> shank{{200, 80}};
  // From the softest to the stiffest that is expected. Measured values depend on the strap's pressure and on the flesh;
  // measure your own. How misfit becomes force: Schiele & van der Helm 2009, doi:10.1080/11762320902879961; that it
  // loads the knee: Bessler-Etten et al. 2022, doi:10.1186/s12984-022-00990-z.
  double softest_n_mm = 1, stiffest_n_mm = 2;
  double thigh_link_kg = 0, shank_link_kg = 0;  // half way from the hinge to the outermost cuff
};

// Which of the cuffs.
struct CuffPlace {
  bool on_thigh = true;
  std::size_t number = 0;  // on its segment, from 0
};

std::vector<CuffPlace> PlacesOf(const CuffOptions& options);
const Cuff& CuffAt(const CuffOptions& options, const CuffPlace& place);

void Describe(CuffOptions& o, OptionList& options);
void DescribePlaces(CuffOptions& o, OptionList& options);  // of the cuffs, without their stiffness

// Throws UsageError where a segment has no cuff, or a number is out of range.
void CheckCuffs(const CuffOptions& o);

// Throws UsageError where the softest is stiffer than the stiffest.
void CheckStiffnesses(const CuffOptions& o);

// The leg and what the device does at an instant. Angles from the vertical, positive when the upper end leans forward.
struct LegState {
  double thigh_deg = 0, shank_deg = 0;
  // Where the hinge is against the knee while its links have not moved: in the thigh's and in the shank's frame, mm
  // (x anterior, y along the segment, up). The two are one point at standing; as the knee bends they come apart.
  Eigen::Vector2d hinge_on_thigh_mm = Eigen::Vector2d::Zero(), hinge_on_shank_mm = Eigen::Vector2d::Zero();
  double moment_nm = 0;  // the actuator's, extending the knee; of a hinge that is free to turn
  // The hinge's angle less the knee's where the actuator holds it, as a stroke does: the moment is then what that
  // takes.
  std::optional<double> held_error_deg = {};
};

// On the leg.
struct CuffLoad {
  Eigen::Vector2d slip_mm = Eigen::Vector2d::Zero();  // of the cuff on the segment: across (anterior), along (up)
  Eigen::Vector2d force_n = Eigen::Vector2d::Zero();  // the cuff's on the segment, the same axes
  double moment_nm = 0;
};

struct LegLoad {
  std::vector<CuffLoad> thigh, shank;
  double largest_thigh_n = 0, largest_shank_n = 0;  // of the cuffs
  double knee_shear_n = 0;  // what the knee must pass on across the shank, of all that the cuffs do to the shank
};

// Throws UsageError as CheckCuffs, or where a stiffness is out of range. Forces of an unknown misfit (NaN) are
// NaN.
LegLoad LoadOnLeg(const LegState& leg, const CuffOptions& options, const Stiffness& stiffness);

// How far the hinge's place on the thigh is from its place on the shank, mm in the leg frame (x anterior, y up).
// |misfit| = 2 |place| sin(θ/2) after the knee has turned by θ from where the two places are one.
Eigen::Vector2d MisfitOf(const Eigen::Vector2d& place_shank_mm, const Eigen::Vector2d& place_thigh_mm, double thigh_deg,
                         double shank_deg);

}  // namespace lake::cuffs
