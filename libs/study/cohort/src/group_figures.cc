#include "group_figures.h"

#include "lake/figure/group_figure.h"

namespace lake::cohort {
namespace {

figure::ConditionCurve CurveOf(const CurveRow& row) {
  figure::ConditionCurve curve;
  curve.with_exoskeleton = row.trial != "human";
  curve.people = row.participants.size();
  for (const reliability::MeanOfSubjects& of : row.percent) {
    curve.mean.push_back(of.mean.value);
    if (curve.people < 2) continue;
    curve.low.push_back(of.mean.interval.low);
    curve.high.push_back(of.mean.interval.high);
  }
  return curve;
}

}  // namespace

const std::vector<GroupFigure>& GroupFigures() {
  static const std::vector<GroupFigure> figures = {
      {"knee_angle", "knee angle", "knee_deg", "knee flexion (°)"},
      {"trunk_lean", "trunk lean", "trunk_deg", "trunk from the vertical (°)"},
      {"misalignment", "misalignment of the knees", "distance_mm", "distance of the knees (mm)"}};
  return figures;
}

std::vector<std::string> FileNames(const GroupFigure& figure) {
  return {std::string(figure.name) + ".png", std::string(figure.name) + ".svg"};
}

const CurveRow* FindCurve(const std::vector<CurveRow>& curves, const std::string& trial, const std::string& quantity) {
  for (const CurveRow& row : curves)
    if (row.trial == trial && row.quantity == quantity) return &row;
  return nullptr;
}

void DrawGroupFigures(const std::vector<CurveRow>& curves, Run& run) {
  for (const GroupFigure& figure : GroupFigures()) {
    std::vector<figure::ConditionCurve> conditions;
    for (const char* trial : {"human", "exo", "comparison"})
      if (const CurveRow* row = FindCurve(curves, trial, figure.quantity)) conditions.push_back(CurveOf(*row));
    if (conditions.empty()) continue;
    for (const std::string& file : FileNames(figure)) figure::DrawConditions(run.Result(file), conditions, figure.axis);
  }
}

}  // namespace lake::cohort
