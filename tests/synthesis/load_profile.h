// A rise from a chair as lake-loads would write it, made up: the knee bends a little before the seat is left, and its
// moment is not known until then.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "lake/problem/load_profile.h"

namespace lake {

inline problem::LoadProfile MadeUpProfile(double seated_deg = 92, double peak_nm = 55) {
  std::vector<double> percent, knee_deg, knee_nm;
  for (int i = 0; i <= 100; ++i) {
    const double s = i / 100.0, up = s * s * s * (10 - 15 * s + 6 * s * s);
    percent.push_back(i);
    knee_deg.push_back(6 + (seated_deg - 6) * (1 - up) + 4 * std::exp(-std::pow((s - 0.3) / 0.1, 2)));
    knee_nm.push_back(i < 35
                          ? std::numeric_limits<double>::quiet_NaN()
                          : peak_nm * std::sin(std::numbers::pi / 2 * std::pow(1 - s, 0.8) / std::pow(0.6, 0.8)) - 4);
  }
  return problem::MakeLoadProfile(percent, knee_deg, knee_nm, 1.6);
}

// The same moment at each of `count` angles from the first, evenly to the last.
inline problem::LoadProfile ConstantProfile(double first_deg, double last_deg, double knee_nm, int count) {
  std::vector<double> percent, knee_deg;
  for (int i = 0; i < count; ++i) {
    percent.push_back(100.0 * i / (count - 1));
    knee_deg.push_back(std::lerp(first_deg, last_deg, i / (count - 1.0)));
  }
  return problem::MakeLoadProfile(percent, knee_deg, std::vector<double>(count, knee_nm), 2);
}

}  // namespace lake
