#include "lake/tracking/marker_physics.h"

#include <cmath>
#include <utility>

#include "lake/core/error.h"

namespace lake::tracking {

void MarkerPhysics::Check() const {
  for (const auto& [name, value] : {std::pair("radius, mm", radius_mm),
                                    {"acceleration, mm/s²", max_acceleration_mm_s2},
                                    {"speed, mm/s", max_speed_mm_s},
                                    {"spectral density of jerk, mm²/s⁵", quick_mm2_s5},
                                    {"time before it turns back, s", turns_after_s},
                                    {"first step, mm", fast_start_mm}})
    if (!(value > 0) || !std::isfinite(value))
      throw UsageError("a marker's {}: {} is not a positive number", name, value);
}

}  // namespace lake::tracking
