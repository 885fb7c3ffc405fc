// How the trunk leans on the pelvis, where the recording has markers of it.
#pragma once

#include <string>
#include <vector>

#include "lake/gait/leg_fit.h"

namespace lake::gait {

// The markers of the pelvis: above its front and its back (spina iliaca anterior and posterior superior), each of the
// near side, or in three dimensions the middle of both sides.
inline constexpr const char *kAsis = "asis", *kPsis = "psis";

// One value per frame, NaN where not known: trunk_deg less the pelvis' forward tilt, which is the angle of the line
// from `psis` to `asis` below the horizontal; its SD. `warning`: why all of it is unknown, although one of the markers
// is in the recording (the other one is not, they are exchanged, or the waist marker is on the pelvis too); else empty.
struct TrunkOnPelvis {
  std::vector<double> deg, sd_deg;
  std::string warning;
};
TrunkOnPelvis FindTrunkOnPelvis(const LegFitResult& fit);

}  // namespace lake::gait
