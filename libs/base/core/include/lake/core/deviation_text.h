// A standard deviation as a person reads it.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace lake {

// With so many decimals, and its unit behind it: "0.012°". One that would round to nothing is "< 0.001°", as none is
// zero; one that is not known is "unknown".
inline std::string DeviationText(double deviation, int decimals, const std::string& unit) {
  if (!std::isfinite(deviation)) return "unknown";
  const double last = std::pow(10.0, -decimals);
  return deviation < last / 2 ? fmt::format("< {:.{}f}{}", last, decimals, unit)
                              : fmt::format("{:.{}f}{}", deviation, decimals, unit);
}

}  // namespace lake
