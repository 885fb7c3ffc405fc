// The design of the paper.
#pragma once

#include "lake/linkage/linkage.h"

namespace lake {

inline constexpr linkage::Links kOptimum{59.081, 68.840, 55.964, 71.849, 118.630, 287.310};  // Table 1

}  // namespace lake
