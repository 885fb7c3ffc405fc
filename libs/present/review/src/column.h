// Numbers as the page wants them.
#pragma once

#include <cmath>
#include <functional>

#include "lake/core/json.h"

namespace lake::review {

// Four digits behind the point are far below what a page can show; null for what is not finite.
inline Json Rounded(double value) {
  constexpr double kSteps = 1e4;
  return std::isfinite(value) ? Json(std::round(value * kSteps) / kSteps) : Json();
}

inline Json Column(std::size_t rows, const std::function<double(std::size_t)>& value) {
  Json column = Json::array();
  for (std::size_t row = 0; row < rows; ++row) column.push_back(Rounded(value(row)));
  return column;
}

}  // namespace lake::review
