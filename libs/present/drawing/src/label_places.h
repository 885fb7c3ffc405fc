// Where the labels of a picture stand, so that they stay there in the next picture of a series.
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace lake::drawing {

// One of the spots beside what is named, and how many steps away.
struct LabelPlace {
  std::size_t spot = 0;
  int steps = 0;
  bool operator==(const LabelPlace&) const = default;
};

using LabelPlaces = std::map<std::string, LabelPlace>;  // by the label's symbol

}  // namespace lake::drawing
