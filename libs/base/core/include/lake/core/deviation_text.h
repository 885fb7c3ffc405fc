// A standard deviation as text.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace lake {

// With this number of decimals and the unit: "0.012°". A value that would round to zero becomes "< 0.001°"; NaN becomes
// "unknown".
inline std::string DeviationText(double deviation, int decimals, const std::string& unit) {
  if (!std::isfinite(deviation)) return "unknown";
  const double last = std::pow(10.0, -decimals);
  return deviation < last / 2 ? fmt::format("< {:.{}f}{}", last, decimals, unit)
                              : fmt::format("{:.{}f}{}", deviation, decimals, unit);
}

}  // namespace lake
