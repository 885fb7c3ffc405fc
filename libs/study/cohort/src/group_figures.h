// The group's curves as figures for a paper.
#pragma once

#include <string>
#include <vector>

#include "lake/cohort/group_statistics.h"
#include "lake/core/run.h"

namespace lake::cohort {

struct GroupFigure {
  const char* name;  // of its files, without extension
  const char* what;
  const char* quantity;  // of the curves
  const char* axis;
};

const std::vector<GroupFigure>& GroupFigures();
std::vector<std::string> FileNames(const GroupFigure& figure);  // PNG and SVG

// nullptr where there is no such curve.
const CurveRow* FindCurve(const std::vector<CurveRow>& curves, const std::string& trial, const std::string& quantity);

// Draws those of which there is a curve.
void DrawGroupFigures(const std::vector<CurveRow>& curves, Run& run);

}  // namespace lake::cohort
