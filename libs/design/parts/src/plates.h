// The plates of a linkage.
#pragma once

#include "lake/parts/mechanism.h"

namespace lake::parts {

std::array<Plate, kPlates> PlatesOf(const linkage::Links& links, const PartOptions& options, bool& has_thigh_holes);

}  // namespace lake::parts
