// How one recording's clock runs against another's: sync.yaml.
#pragma once

#include <filesystem>
#include <string>

namespace lake::sync {

// Times of B on A's clock: t + offset_s + drift (t − from_s).
struct Clock {
  double offset_s = 0;      // to add to B's times, at from_s
  double drift_ppm = 0;     // how much faster A's clock runs, s in 10⁶ s
  double from_s = 0;        // B's first time
  double sd_s = 0;          // one standard deviation of a time that was brought over, at worst within the overlap
  std::string method = {};  // "motion" or "signal"
  std::filesystem::path a = {}, b = {};

  double FromB(double time_s) const { return time_s + offset_s + 1e-6 * drift_ppm * (time_s - from_s); }
};

// sync.yaml: offset_s, drift_ppm, from_s, sd_s, method, a, b. Reading needs offset_s alone, and throws Error naming
// file and line for what is no number and for keys that nobody knows.
void WriteClock(const std::filesystem::path& path, const Clock& clock);
Clock ReadClock(const std::filesystem::path& path);

// ReadClock for times of `b`. Throws Error where the file says that `b` is its A.
Clock ReadClockOf(const std::filesystem::path& path, const std::filesystem::path& b);

}  // namespace lake::sync
