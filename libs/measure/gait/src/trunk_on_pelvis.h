// How the trunk leans on the pelvis, for the measures of a sit-to-stand.
#pragma once

#include <string>
#include <vector>

#include "lake/gait/leg_fit.h"

namespace lake::gait {

// One value per frame, NaN where not known: trunk_deg less the pelvis' forward tilt, which is the angle of the line
// from `psis` to `asis` below the horizontal; its SD. `warning`: why all of it is unknown, although one of the markers
// is in the recording; else empty.
struct TrunkOnPelvis {
  std::vector<double> deg, sd_deg;
  std::string warning;
};
TrunkOnPelvis FindTrunkOnPelvis(const LegFitResult& fit);

}  // namespace lake::gait
