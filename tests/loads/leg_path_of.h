// The path of a leg as its fit found it.
#pragma once

#include "lake/gait/leg_fit.h"
#include "lake/loads/loads.h"

namespace lake {

inline loads::LegPathOptions PathOf(const gait::LegFitResult& fit) {
  loads::LegPathOptions path;
  path.facing = fit.motion.facing;
  path.up = fit.up;
  return path;
}

}  // namespace lake
