// Numbers of a summary as a report writes them: with their unit, rounded to their 95 % interval where it is known.
#pragma once

#include <cmath>
#include <string>

#include "lake/core/json.h"
#include "lake/core/uncertain_text.h"

namespace lake::report {

// A part of a summary by the path of its keys, "trial/offset_mm/0". Find(): null where it is absent. NumberAt(): null
// is NaN; throws where it is absent.
inline Json Find(const Json& of, const std::string& path) {
  return of.is_object() ? of.value(Json::json_pointer("/" + path), Json()) : Json();
}
inline double NumberAt(const Json& of, const std::string& path) {
  return NumberOrNaN(of.at(Json::json_pointer("/" + path)));
}

struct Uncertain {
  double value = std::nan(""), low = std::nan(""), high = std::nan("");  // NaN: not known
  int least_decimals = -1000;  // of a quantity whose values are compared, so that each has the same rounding

  double HalfWidth() const { return (high - low) / 2; }
  bool IsKnown() const { return HalfWidth() > 0; }
  // Of the value and of the interval's ends; `otherwise` where no interval is known.
  int Decimals(int otherwise = 1) const {
    return std::max(least_decimals, IsKnown() ? KnownDecimals(HalfWidth()) : otherwise);
  }
  std::string Text(int otherwise = 1) const { return RoundedText(value, Decimals(otherwise)); }
  // "8.1 to 9.0", "8.1–9.0".
  std::string IntervalText(int otherwise = 1, const char* between = " to ") const {
    return RoundedText(low, Decimals(otherwise)) + between + RoundedText(high, Decimals(otherwise));
  }
};

// Of what comparison.json has: a number and, if it has one, its interval, both times `factor`.
inline Uncertain UncertainOf(const Json& number, const Json& interval, double factor = 1) {
  Uncertain of{.value = factor * NumberOrNaN(number)};
  if (interval.is_array() && interval.size() == 2) {
    of.low = factor * NumberOrNaN(interval.at(0));
    of.high = factor * NumberOrNaN(interval.at(1));
  }
  return of;
}

inline constexpr int kPathDifferenceDecimals = 1;  // of a percentage of the shank length, at least

// A number of comparison.json, described once: where it and its 95 % interval stand, and how a report shows it. What is
// in % stands there as a fraction of the shank length.
struct Fact {
  const char *label, *unit, *value, *interval;
  const char* includes = "";  // of the interval
};

inline constexpr const char* kOfAllSources = ", all sources";
inline constexpr const char* kOfMarkers = ", of the markers alone";
inline constexpr const char* kOfSlip = ", of the slip between repetitions";
// Of the joint against the knee of the leg that wears it, with what moving it there leaves. The interval of all
// sources, the skin among them, is that on which a decision rests.
inline constexpr Fact kJointRms{"joint misalignment, RMS", "mm", "joint/rms_mm",
                                "uncertainty/joint_rms_mm/anatomical_interval", kOfAllSources};
inline constexpr Fact kJointMax{"joint misalignment, largest", "mm", "joint/max_mm", "joint/max_interval_mm",
                                kOfMarkers};
inline constexpr Fact kJointMoved{"joint misalignment, joint moved and put on anew", "mm", "best_placement/rms_mm",
                                  "best_placement/rms_interval_mm", kOfSlip};
inline constexpr Fact kPathMoved{"path difference, joint moved, of the shank", "%", "best_placement/path_relative_rms",
                                 "best_placement/path_relative_rms_interval"};
inline constexpr Fact kPathPercent{"path difference, RMS, of the shank", "%", "metrics/relative_rms",
                                   "intervals/relative_rms"};
inline constexpr Fact kPathMaxPercent{"path difference, largest, of the shank", "%", "metrics/relative_max",
                                      "intervals/relative_max"};
inline constexpr Fact kPathMm{"path difference, RMS", "mm", "metrics/rms_mm", "intervals/rms_mm"};
inline constexpr Fact kPathMaxMm{"path difference, largest", "mm", "metrics/max_mm", "intervals/max_mm"};
inline constexpr Fact kKneeRmse{"knee angles, RMS difference", "°", "metrics/knee_rmse_deg", "intervals/knee_rmse_deg"};
inline constexpr Fact kExoTime{"time with the exoskeleton", "s", "pace/exo_s", "pace/exo_interval_s"};

// NaN where the trial does not show it.
inline Uncertain FactOf(const Json& comparison, const Fact& fact) {
  const bool is_fraction = fact.unit == std::string("%");
  Uncertain of = UncertainOf(Find(comparison, fact.value), Find(comparison, fact.interval), is_fraction ? 100 : 1);
  if (is_fraction) of.least_decimals = kPathDifferenceDecimals;
  return of;
}

}  // namespace lake::report
