// The order in which the bodies of a linkage lie beside each other.
#pragma once

#include "lake/parts/mechanism.h"

namespace lake::parts {

// Of a mechanism that has its plates.
Stack FindStack(const Mechanism& mechanism);

}  // namespace lake::parts
