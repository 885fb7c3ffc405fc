// Free programs of the published linkage, and the duty table of the model actuator.
#pragma once

#include <utility>
#include <vector>

#include "lake/actuator/duty_table.h"
#include "lake/actuator/stroke_schedule.h"

namespace lake {

// Gautam, Singla & Singla, table 1.
inline constexpr Links kPublishedLinks = {59.081, 68.840, 55.964, 71.849, 118.630, 287.310};

inline DutyTable ModelTable() {
  return ReadDutyTable(LAKE_SOURCE_DIR "/calibration/duty_table_model.csv");
}

inline Design PublishedDesign() {
  Design design;
  design.links = kPublishedLinks;
  return design;
}

// Knots (s, mm).
inline Design FreeDesign(std::vector<StrokeProgram::Knot> knots) {
  Design design = PublishedDesign();
  design.program.emplace().kind = StrokeProgram::Kind::kFree;
  design.program->knots = std::move(knots);
  return design;
}

inline StrokeSchedule FreeSchedule(std::vector<StrokeProgram::Knot> knots) {
  return MakeSchedule(FreeDesign(std::move(knots)), {});
}

}  // namespace lake
