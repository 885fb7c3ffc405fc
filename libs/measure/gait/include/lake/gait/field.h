// One measure of a result, described once: the CSV's header and cells, the summary and the reference of columns follow.
#pragma once

#include <cmath>
#include <string>

#include "lake/motion/marker_recording.h"

namespace lake::gait {

// A value with its standard deviation; NaN where not known.
struct Measured {
  double value = NAN, sd = NAN;
};

template <typename Row>
struct Field {
  const char* name;  // of the column, with its unit; lengths are in mm, which px replaces where there is no scale
  const char* unit;
  const char* meaning;
  const char* source;  // a publication, or lake where the definition is its own
  Measured Row::*value;
  int digits;  // decimals at the terminal

  std::string Column(motion::LengthUnit of_plane) const { return InUnit(name, of_plane); }
  std::string Unit(motion::LengthUnit of_plane) const { return InUnit(unit, of_plane); }

 private:
  static std::string InUnit(std::string text, motion::LengthUnit of_plane) {
    const auto mm = text.starts_with("mm") ? 0 : text.find("_mm");  // no part of a word
    if (mm != std::string::npos) text.replace(text.find("mm", mm), 2, ToString(of_plane));
    return text;
  }
};

}  // namespace lake::gait
