// How a person's mass is distributed: tables of segments, and one person's masses and inertias from them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "lake/motion/person.h"

namespace lake::loads {

// One segment of a table. `centre` is from the segment's upper end (of the foot: from the heel; of head, arms and
// trunk: from the hip), `gyration` is about the centre, both as shares of the segment's length.
struct SegmentShare {
  double mass = 0;  // share of the body's mass
  double centre = 0;
  double gyration = 0;
};

// `trunk` is head, arms and trunk in one, its length from the hip joint to the shoulder joint.
struct Anthropometry {
  std::string name, source;
  SegmentShare foot, shank, thigh, trunk;
};

using motion::Sex;

inline constexpr const char* kDeLeva = "deleva";  // the table that is not the same for both

// "winter", "deleva" (by sex), else a YAML file: `source` and, for foot, shank, thigh and trunk each, {mass, centre,
// gyration}. Throws UsageError for deleva without a sex; Error naming file and line for shares out of range, or masses
// of both legs and the trunk that do not add up to 1 within 0.02.
Anthropometry FindAnthropometry(const std::string& name_or_file, std::optional<Sex> sex);
Anthropometry ReadAnthropometry(const std::filesystem::path& path);

// Where the foot's ends are from the ankle marker, along the ground, both positive.
struct Foot {
  double heel_m = 0, toe_m = 0;
  double Length() const { return heel_m + toe_m; }
};

// Of the stature (Drillis & Contini 1966, in Winter 2009, fig. 4.1): foot 0.152, ankle above the ground 0.039, hip to
// shoulder 0.288, shank and thigh together 0.491. A quarter of the foot lies behind the ankle.
Foot FootOfStature(double height_m);
double AnkleHeightOfStature(double height_m);
double TrunkOfStature(double height_m);
double StatureOfLeg(double leg_m);

}  // namespace lake::loads
