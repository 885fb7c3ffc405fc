// What may be unknown, as JSON: null.
#pragma once

#include <cmath>
#include <optional>

#include "lake/core/json.h"

namespace lake {

// Null also for what is not finite.
inline Json NumberOrNull(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

inline Json NumberOrNull(std::optional<double> value) {
  return value ? NumberOrNull(*value) : Json();
}

template <typename T>
Json ValueOrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace lake
