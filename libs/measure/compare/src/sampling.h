// Values of sampled signals between their samples; NaN samples are gaps.
#pragma once

#include <cstddef>
#include <vector>

namespace lake::compare {

// The first frame at or after a time; the last one if there is none.
std::size_t FrameAfter(const std::vector<double>& time_s, double t);

// Cubic polynomial through the two known samples to each side (fewer at the ends).
double ValueAt(const std::vector<double>& time_s, const std::vector<double>& values, double t);

double LinearValueAt(const std::vector<double>& time_s, const std::vector<double>& values, double t);

// The longest time within [from, to] between neighbouring known samples that has a frame without a value in it;
// infinite if the interval is not enclosed by known samples.
double LongestGap(const std::vector<double>& time_s, const std::vector<double>& values, double from_s, double to_s);

}  // namespace lake::compare
