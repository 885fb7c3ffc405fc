// Load on the knee of one leg over a rise: angle and moment at each percent, as lake-loads writes them.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <vector>

namespace lake::problem {

struct LoadSample {
  double percent = 0;       // 0 the rise begins, 100 standing; equal steps of time
  double knee_rad = 0;      // flexion positive
  double rad_per_rise = 0;  // d knee / d (percent / 100), central differences: divided by a duration, the speed
  // Extension positive, of one leg; NaN where it is unknown because the seat bears a part.
  double knee_nm = std::numeric_limits<double>::quiet_NaN();
  // Of a rise so slow that nothing accelerates: that of the pose; NaN where it is not known.
  double slow_nm = std::numeric_limits<double>::quiet_NaN();
};

struct LoadProfile {
  std::vector<LoadSample> samples;
  double duration_s = 0;       // of the rise as it was measured
  double moments_s = 0;        // of the rise that knee_nm is of: the same, or another by AtPace()
  std::filesystem::path file;  // that it was read from; empty: none

  double LargestAngle() const;  // rad
  // Whether it says what accelerations add to the moment.
  bool HasPace() const;
};

// The same path gone along evenly in `duration_s`: of what accelerations add to the moment the part (moments_s /
// duration)^2 is left. Samples where that is not known are not known. nullopt where none is.
std::optional<LoadProfile> AtPace(const LoadProfile& profile, double duration_s);

// Throws Error: lists of different lengths, fewer than three samples, percents that do not ascend from 0 to 100, angles
// or a duration that cannot be, no known moment.
LoadProfile MakeLoadProfile(const std::vector<double>& percent, const std::vector<double>& knee_deg,
                            const std::vector<double>& knee_nm, double duration_s);

// loads.json, or the folder of lake-loads with it: the mean of its rises; "knee_slow_nm" may be missing. Throws Error
// naming file and key.
LoadProfile ReadLoadProfile(const std::filesystem::path& path);

}  // namespace lake::problem
