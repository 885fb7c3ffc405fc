// Which signals of two recordings are compared. Not part of the interface.
#pragma once

#include "lake/sync/lag.h"
#include "lake/sync/movement.h"

namespace lake::sync {

struct Pairing {
  std::string name = {};  // "speeds of knee, hip"
  Series y = {}, x = {};  // y is predicted from x
  bool y_is_a = false;    // else y is B's
  double model_sd_s = 0;  // of a time: the part that a linear map of x does not have; see README
};

// Throws Error where the two show nothing in common, or nothing moves.
Pairing PairingOf(const Movement& a, const Movement& b);

}  // namespace lake::sync
