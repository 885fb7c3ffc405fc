#include "measure_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "lake/core/deviation_text.h"
#include "lake/figure/trial_figures.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

// Each one's smallest, largest and mean.
std::string TextOf(const Json& measures) {
  std::string text;
  for (const auto& [name, of] : measures.items()) {
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

}  // namespace

void WriteMeasures(const motion::MarkerRecording& recording, const std::vector<gait::MarkerMeasure>& measures,
                   Json& results, Run& run) {
  if (measures.empty()) return;
  const std::vector<gait::MeasuredCourse> courses = gait::MeasureMarkers(recording, measures);
  gait::WriteMeasuresCsv(run.Result("measures.csv"), recording, courses);
  DrawPngAndSvg("measures", run,
                [&](const std::filesystem::path& path) { figure::DrawMeasures(path, recording, courses); });
  results["measures"] = gait::MeasuresJson(recording, courses);
  run.Report(TextOf(results["measures"]));
}

void WriteUncertaintyBudget(const gait::LegFitResult& leg, const compare::RecordingBudgetOptions& options,
                            Json& results, Run& run) {
  const std::vector<compare::Budget> budgets = compare::BudgetsOf(leg, options);
  if (budgets.empty()) return;
  compare::WriteUncertaintyBudgetCsv(run.Result("uncertainty_budget.csv"), budgets);
  results["uncertainty"] = compare::BudgetsJson(budgets);
  const auto knee = std::ranges::find(budgets, std::string("knee_angle"), &compare::Budget::quantity);
  run.Report("the joint beneath the skin: knee within {} (1 SD; uncertainty_budget.csv)\n",
             DeviationText(knee->Deviation(), 1, "°"));
}

}  // namespace lake::commands
