// Uniform cubic B-splines: a basis for what changes slowly.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace lake::loads {

// Uniform cubic B-splines over [start, start + step · (count − 3)].
struct SplineGrid {
  double start_s = 0;
  double step_s = 1;
  std::size_t count = 4;  // coefficients

  // What the four coefficients from `first` on contribute to the value at a time, and to the first and the second
  // derivative there (per s and s²).
  struct Place {
    std::size_t first = 0;
    std::array<double, 4> value, slope, curve;
  };
  Place At(double time_s) const;
};

// Covers the times. Throws Error if that takes more than 50 coefficients per sample (holes in the time stamps).
SplineGrid MakeSplineGrid(std::span<const double> time_s, double step_s);

double ValueAt(const SplineGrid::Place& place, std::span<const double> coefficients);
double SlopeAt(const SplineGrid::Place& place, std::span<const double> coefficients);
double CurveAt(const SplineGrid::Place& place, std::span<const double> coefficients);

}  // namespace lake::loads
