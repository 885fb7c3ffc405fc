// Free programs of the published linkage, and the duty table of the model actuator.
#pragma once

#include <utility>
#include <vector>

#include "lake/actuator/duty_table.h"
#include "lake/actuator/stroke_schedule.h"
#include "places.h"
#include "published_links.h"

namespace lake {

inline actuator::DutyTable ModelTable() {
  return actuator::ReadDutyTable(SourceDir() / "calibration/duty_table_model.csv");
}

inline linkage::Design PublishedDesign() {
  linkage::Design design;
  design.links = kPublishedLinks;
  return design;
}

// Knots (s, mm).
inline linkage::Design FreeDesign(std::vector<linkage::StrokeProgram::Knot> knots) {
  linkage::Design design = PublishedDesign();
  design.program.emplace().kind = linkage::StrokeProgram::Kind::kFree;
  design.program->knots = std::move(knots);
  return design;
}

inline actuator::StrokeSchedule FreeSchedule(std::vector<linkage::StrokeProgram::Knot> knots) {
  return actuator::MakeSchedule(FreeDesign(std::move(knots)), {});
}

// The program with which the firmware's portable part is compiled into the tests: up at 5 mm/s, up at 2, back at 4, a
// rest, up.
inline actuator::StrokeSchedule HostSchedule() {
  return FreeSchedule({{0, 300}, {0.5, 302.5}, {1, 303.5}, {1.5, 301.5}, {1.8, 301.5}, {2, 302.1}});
}

}  // namespace lake
