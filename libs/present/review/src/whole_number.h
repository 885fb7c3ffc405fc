// Whole numbers in messages; others would be cut to some number, or to none.
#pragma once

#include <cstdint>

#include "lake/core/error.h"
#include "lake/core/json.h"

namespace lake::review {

inline std::int64_t WholeNumber(const Json& json) {
  if (!json.is_number_integer()) throw Fail("a whole number is asked for, not {}", json.type_name());
  return json.get<std::int64_t>();
}

}  // namespace lake::review
