// What a motor with its screw does at a duty, a supply and a load, whatever runs the firmware.
#pragma once

#include <algorithm>
#include <cmath>

#include "lake/actuator/duty_table.h"

namespace lake {

// Without a load, mm/s, of a duty between -1 and 1: as the table has it at duty times supply (part of the nominal);
// beyond the table's end speed grows with the voltage.
inline double FreeSpeed(const actuator::DutyTable& table, double duty, double supply) {
  if (duty == 0) return 0;
  const double driven = std::abs(duty) * supply;
  return std::max(1.0, driven) * table.Curve(duty > 0 ? 1 : -1).SpeedFor(std::min(1.0, driven));
}

// Signed, under a load against extension. A screw that holds by itself has an efficiency below one half: what helps it
// gives back less than half.
inline double LoadedSpeed(double free_mm_s, double duty, double load_n, double mm_s_per_n) {
  if (duty == 0) return 0;
  const double direction = duty > 0 ? 1 : -1, against_n = direction * load_n;
  return direction * std::max(0.0, free_mm_s - (against_n < 0 ? 0.4 : 1) * against_n * mm_s_per_n);
}

}  // namespace lake
