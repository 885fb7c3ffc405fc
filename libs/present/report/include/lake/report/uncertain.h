// A number with its 95 % interval, rounded to it wherever it is written.
#pragma once

#include <cmath>
#include <string>

#include "lake/core/json.h"
#include "lake/core/uncertain_text.h"

namespace lake::report {

struct Uncertain {
  double value = std::nan(""), low = std::nan(""), high = std::nan("");  // NaN: not known
  int least_decimals = -1000;  // of a quantity whose values are compared, so that each has the same rounding

  double HalfWidth() const { return (high - low) / 2; }
  bool IsKnown() const { return HalfWidth() > 0; }
  // Of the value and of the interval's ends; `otherwise` where no interval is known.
  int Decimals(int otherwise) const {
    return std::max(least_decimals, IsKnown() ? KnownDecimals(HalfWidth()) : otherwise);
  }
  std::string Text(int otherwise) const { return RoundedText(value, Decimals(otherwise)); }
};

// Of what comparison.json has: a number and, if it has one, its interval, both times `factor`.
inline Uncertain UncertainOf(const Json& number, const Json& interval, double factor = 1) {
  Uncertain of{.value = factor * NumberOrNaN(number)};
  if (interval.is_array() && interval.size() == 2) {
    of.low = factor * NumberOrNaN(interval.at(0));
    of.high = factor * NumberOrNaN(interval.at(1));
  }
  return of;
}

inline constexpr int kPathDifferenceDecimals = 1;  // of a percentage of the shank length, at least

// A path difference, which comparison.json has as a fraction of the shank length, in percent.
inline Uncertain PathDifferencePercent(const Json& fraction, const Json& interval) {
  Uncertain of = UncertainOf(fraction, interval, 100);
  of.least_decimals = kPathDifferenceDecimals;
  return of;
}

}  // namespace lake::report
