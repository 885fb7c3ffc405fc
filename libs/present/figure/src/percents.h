// The axis of all curves over a movement.
#pragma once

#include <vector>

namespace lake::figure {

// 0, 1, … count - 1.
inline std::vector<double> Percents(int count) {
  std::vector<double> percents;
  for (int percent = 0; percent < count; ++percent) percents.push_back(percent);
  return percents;
}

}  // namespace lake::figure
