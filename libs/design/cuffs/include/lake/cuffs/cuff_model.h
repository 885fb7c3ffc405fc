// The cuffs that hold an exoskeleton's links to thigh and shank. Each yields in proportion to its slip, alike across
// its segment (compression) and along it (shear); one of length L resists a turn as a row of springs does: k L²/12.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lake/core/options.h"

namespace lake::cuffs {

// On one segment. Distances from the knee, along the segment, mm.
struct Cuff {
  double from_knee_mm = 0;
  double length_mm = 80;
};

struct CuffOptions {
  std::vector<Cuff> thigh{{200, 80}};
  std::vector<Cuff> shank{{200, 80}};
  // Of cuff and flesh, from the softest to the stiffest that is expected. Measured values depend on the strap's
  // pressure and on the flesh; measure your own. How misfit becomes force: Schiele & van der Helm 2009,
  // doi:10.1080/11762320902879961; that it loads the knee: Bessler-Etten et al. 2022, doi:10.1186/s12984-022-00990-z.
  double softest_n_mm = 1, stiffest_n_mm = 2;
  double thigh_link_kg = 0, shank_link_kg = 0;  // half way from the hinge to the outermost cuff
};

// All cuffs, those of the thigh first.
struct PlacedCuff : Cuff {
  bool on_thigh = true;
  std::size_t number = 0;  // on its segment, from 0

  const char* Segment() const { return on_thigh ? "thigh" : "shank"; }
};
std::vector<PlacedCuff> CuffsOf(const CuffOptions& options);

void Describe(CuffOptions& o, OptionList& options);
void DescribePlaces(CuffOptions& o, OptionList& options);  // of the cuffs, without their stiffness

// Throws UsageError where a segment has no cuff, or a number is out of range.
void CheckCuffs(const CuffOptions& o);

// Throws UsageError where the softest is stiffer than the stiffest, or not above 0.
void CheckStiffnesses(const CuffOptions& o);

// How far the hinge's place on the thigh is from its place on the shank, mm in the leg frame (x anterior, y up).
// |misfit| = 2 |place| sin(θ/2) after the knee has turned by θ from where the two places are one.
Eigen::Vector2d MisfitOf(const Eigen::Vector2d& place_shank_mm, const Eigen::Vector2d& place_thigh_mm, double thigh_deg,
                         double shank_deg);

}  // namespace lake::cuffs
