// The design of the paper, Table 1 of Gautam, Singla & Singla.
#pragma once

#include "lake/linkage/linkage.h"

namespace lake {

inline constexpr linkage::Links kPublishedLinks{59.081, 68.840, 55.964, 71.849, 118.630, 287.310};

}  // namespace lake
