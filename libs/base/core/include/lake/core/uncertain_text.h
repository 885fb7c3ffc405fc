// A number as far as it is known: rounded to its uncertainty, everywhere alike.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace lake {

// The decimals of a number that is known to ± `half_width` (of a 95 % interval): those of the uncertainty's first
// digit, or of its second where the first is 1. Negative: tens, hundreds. Finite and above 0.
inline int KnownDecimals(double half_width) {
  const double first = std::floor(std::log10(half_width));
  constexpr double kRoundsTo2 = 1.95;
  const bool is_one = half_width / std::pow(10, first) < kRoundsTo2;
  return static_cast<int>(is_one ? 1 - first : -first);
}

// "−20", "2.6"; a true minus sign, and "–" for NaN.
inline std::string RoundedText(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  const double unit = std::pow(10, -decimals), rounded = std::round(value / unit) * unit;
  return fmt::format("{}{:.{}f}", rounded < 0 ? "−" : "", std::abs(rounded), std::max(0, decimals));
}

// With so many significant digits and no zeros behind them: "0.0213", "2000", "35". Never as a power of ten.
inline std::string SignificantText(double value, int digits) {
  if (value == 0 || !std::isfinite(value)) return RoundedText(value, 0);
  std::string text = RoundedText(value, digits - 1 - static_cast<int>(std::floor(std::log10(std::abs(value)))));
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

// Where the uncertainty is not known (NaN or 0), with so many decimals.
inline std::string KnownText(double value, double half_width, int otherwise) {
  return RoundedText(value, half_width > 0 && std::isfinite(half_width) ? KnownDecimals(half_width) : otherwise);
}

// "2.62 ± 0.14": both with the decimals of the uncertainty, or with so many where it is not known.
inline std::string PlusMinusText(double value, double half_width, int otherwise) {
  return fmt::format("{} ± {}", KnownText(value, half_width, otherwise), KnownText(half_width, half_width, otherwise));
}

// What such a function wrote, with a plus where it has no minus: "+2.6", for differences and corrections.
inline std::string WithSign(const std::string& text) {
  return text.starts_with("−") || text == "–" ? text : "+" + text;
}

}  // namespace lake
