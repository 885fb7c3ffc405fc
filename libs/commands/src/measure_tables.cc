#include "measure_tables.h"

#include <fmt/format.h>

#include "lake/figure/measures_figure.h"
#include "png_and_svg.h"

namespace lake::commands {

void WriteMeasures(const motion::MarkerRecording& recording, const std::vector<gait::MarkerMeasure>& measures,
                   Json& results, Run& run) {
  if (measures.empty()) return;
  const std::vector<gait::MeasuredCourse> courses = gait::MeasureMarkers(recording, measures);
  gait::WriteMeasuresCsv(run.Result("measures.csv"), recording, courses);
  DrawPngAndSvg("measures", run,
                [&](const std::filesystem::path& path) { figure::DrawMeasures(path, recording, courses); });
  results["measures"] = gait::MeasuresJson(recording, courses);
}

std::string MeasuresText(const Json& summary) {
  std::string text;
  if (!summary.contains("measures")) return text;
  for (const auto& [name, of] : summary["measures"].items()) {
    if (of.is_null()) {
      text += fmt::format("{}  never seen\n", name);
      continue;
    }
    const std::string unit = gait::UnitForPeople(of["unit"].get<std::string>());
    text += fmt::format("{}  {:.1f} to {:.1f}{}{}, mean {:.1f}\n", name, of["smallest"]["value"].get<double>(),
                        of["largest"]["value"].get<double>(), unit == "°" ? "" : " ", unit, of["mean"].get<double>());
  }
  return text;
}

void WriteUncertaintyBudget(const gait::LegFitResult& leg, const compare::RecordingBudgetOptions& options,
                            Json& results, Run& run) {
  const std::vector<compare::Budget> budgets = compare::BudgetsOf(leg, options);
  if (budgets.empty()) return;
  compare::WriteUncertaintyBudgetCsv(run.Result("uncertainty_budget.csv"), budgets);
  results["uncertainty"] = compare::BudgetsJson(budgets);
}

}  // namespace lake::commands
