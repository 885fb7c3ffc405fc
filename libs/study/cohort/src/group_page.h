// group.html: what a cohort found, and links to each study.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "lake/cohort/group_statistics.h"
#include "lake/core/run.h"
#include "lake/report/report.h"
#include "workflow.h"

namespace lake::cohort {

struct GroupFindings {
  std::string repetition;  // what one of the movement is called
  std::vector<CurveRow> curves;
  std::vector<ReliabilityRow> reliability;
  std::vector<DifferenceRow> differences;
  std::vector<OutlierRow> outliers;
  std::vector<Failure> failures;
};

// A quantity's curves, on the page and as a figure for a paper.
struct GroupFigure {
  const char* name;  // of its files, without extension
  const char* title;
  const char* quantity;  // of the curves
  const char* axis;

  std::vector<std::string> Files() const { return {std::string(name) + ".png", std::string(name) + ".svg"}; }
};
inline constexpr std::array kGroupFigures = {
    GroupFigure{"knee_angle", "Knee angle", "knee_deg", "knee flexion (°)"},
    GroupFigure{"trunk_lean", "Trunk lean", "trunk_deg", "trunk from the vertical (°)"},
    GroupFigure{"misalignment", "Misalignment of the knees", "distance_mm", "distance of the knees (mm)"}};

// Draws those of which there is a curve.
void DrawGroupFigures(const GroupFindings& findings, Run& run);

report::Report MakeGroupPage(const Workflow& workflow, const GroupData& group, const GroupFindings& findings,
                             const Json& head);

}  // namespace lake::cohort
