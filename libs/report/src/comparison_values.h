// Numbers of comparison.json, where null is a value that is not defined.
#pragma once

#include <limits>
#include <vector>

#include "lake/core/json.h"

namespace lake {

inline double NumberOf(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

inline std::vector<double> NumbersOf(const Json& values) {
  std::vector<double> numbers;
  for (const Json& value : values) numbers.push_back(NumberOf(value));
  return numbers;
}

}  // namespace lake
