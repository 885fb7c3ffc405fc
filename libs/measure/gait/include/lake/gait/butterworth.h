// The field's customary filter: a Butterworth low-pass run forward and backward.
#pragma once

#include <span>
#include <vector>

namespace lake::gait {

// Throws Error unless 0 < cutoff < 0.4 × rate: nearer to half the rate no filter has room for its slope.
void CheckCutoff(double cutoff_hz, double rate_hz);

// A second-order Butterworth run forward and backward: zero phase, order 4. `cutoff_hz` is where the whole filter is −3
// dB: each pass is designed for the cutoff divided by (√2 − 1)^(1/4) = 0.802 (D. A. Winter, Biomechanics and Motor
// Control of Human Movement, 4th ed., sec. 3.4.4.2). The ends are continued by point reflection. Throws Error unless 0
// < cutoff < 0.4 × rate, rate > 0 and all values are finite.
std::vector<double> ZeroPhaseButterworth(std::span<const double> values, double rate_hz, double cutoff_hz);

// The same for values at the given times (increasing): over a uniform grid of the median step, by cubic interpolation
// there and back where the steps are not all alike.
std::vector<double> ZeroPhaseButterworthAtTimes(std::span<const double> values, std::span<const double> time_s,
                                                double cutoff_hz);

// Cubic interpolation (Catmull–Rom on uneven steps) of at least two values at the times `from` to the times `to`; both
// increase.
std::vector<double> InterpolateCubic(std::span<const double> values, std::span<const double> from,
                                     std::span<const double> to);

}  // namespace lake::gait
