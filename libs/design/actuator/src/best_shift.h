// The shift of time that brings a program and what was measured of it together.
#pragma once

#include <boost/math/tools/minima.hpp>
#include <limits>

#include "lake/core/interrupt.h"

namespace lake::actuator {

// The shift within low .. high with the least error: on a grid of `coarse`, then about its best by Brent's method on
// `fine`, as precision is relative: some nanoseconds. Throws Interrupted on a signal.
template <typename Coarse, typename Fine>
double LeastErrorShift(double low, double high, const Coarse& coarse, const Fine& fine) {
  constexpr int kSteps = 1000;
  const double step = (high - low) / kSteps;
  double best = low, least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    ThrowIfInterrupted();
    const double shift = low + i * step;
    if (const double error = coarse(shift); error < least) {
      least = error;
      best = shift;
    }
  }
  constexpr int kBits = std::numeric_limits<double>::digits / 2;
  const auto fine_about = [&](double later) { return fine(best + later); };
  return best + boost::math::tools::brent_find_minima(fine_about, -step, step, kBits).first;
}

}  // namespace lake::actuator
