// What a marker on a leg can do, which is what following and naming it rest on.
#pragma once

namespace lake::tracking {

// In mm and s. Without a calibrated plane the marker's own radius is the only measure of length in the picture, so it
// is the radii that count: a marker twice as large is allowed twice as far.
struct MarkerPhysics {
  double radius_mm = 8;
  double max_acceleration_mm_s2 = 9600;  // about 1 g, while the leg stands up
  double max_speed_mm_s = 2000;          // of a quick rise
  double quick_mm2_s5 = 1e9;             // spectral density of jerk in a quick rise
  double turns_after_s = 0.3;            // s, in which a marker goes one way at most
  double fast_start_mm = 160;            // from one frame to the next, of what begins at a seed: a ball that is thrown

  double AccelerationRadii() const { return max_acceleration_mm_s2 / radius_mm; }  // per s²
  double SpeedRadii() const { return max_speed_mm_s / radius_mm; }                 // per s
  double FastStartRadii() const { return fast_start_mm / radius_mm; }

  // Throws UsageError naming the value that is not positive and finite.
  void Check() const;
};

// A seed is a click, which is not exact: px beyond the marker's rim.
inline constexpr double kSeedSlackPx = 10;

}  // namespace lake::tracking
