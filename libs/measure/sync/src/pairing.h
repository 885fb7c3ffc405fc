// Which signals of two recordings are compared. Not part of the interface.
#pragma once

#include <string>
#include <vector>

#include "series.h"

namespace lake::sync {

// y is told from x by a linear map of its own.
struct Part {
  std::string name;
  Series y, x;
};

struct Pairing {
  std::vector<Part> parts = {};
  bool y_is_a = false;          // else y is B's
  double most_unexplained = 0;  // of a movement that both show
};

// Different ways to compare the two, of which the one that tells most is taken; y at a third of x's rate. Throws Error
// where there is none.
std::vector<Pairing> PairingsOf(const Movement& a, const Movement& b);

}  // namespace lake::sync
