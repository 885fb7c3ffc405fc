#include "actuator_front_tables.h"

#include <fmt/ranges.h>

#include <cmath>

#include "lake/core/csv.h"
#include "optimum_tables.h"

namespace lake::commands {
namespace {

using problem::AssistanceRow;

const char* StatusOf(const synthesis::ActuatorCurve& curve, const synthesis::FrontPoint& point) {
  if (!point.solved) return "no design";
  if (!curve.Actuator().HasSpeed()) return "speed not known";
  return curve.Actuator().HasForceSpeedLaw() ? "solved" : "lower bound";
}

double Magnitude(const problem::Assistance& assistance, double AssistanceRow::*column) {
  const AssistanceRow* row = assistance.Largest(column);
  return row ? std::abs(row->*column) : AssistanceRow::kUnknown;
}

void AddSolved(const synthesis::ActuatorCurve& curve, const synthesis::FrontPoint& point, CsvWriter& table) {
  const problem::Assistance& assistance = point.assistance;
  table.Add(assistance.shortest_s).Add(assistance.bound_s);
  table.Add(assistance.limiting_percent).Add(point.is_on_front ? 1 : 0).Add(point.range_deg);
  table.Add(Magnitude(assistance, &AssistanceRow::force_n));
  if (curve.Actuator().HasSpeed())
    table.Add(Magnitude(assistance, &AssistanceRow::speed_mm_s)).Add(Magnitude(assistance, &AssistanceRow::power_w));
  else
    table.AddEmpty().AddEmpty();
  table.Add(curve.problem.d_min_mm);
  table.Add(point.links.Values());
}

}  // namespace

void WriteActuatorFront(const std::vector<synthesis::ActuatorCurve>& curves, const std::filesystem::path& path) {
  std::vector<std::string> header = {
      "actuator", "assist",    "status",       "duration_s",      "any_linkage_duration_s", "limiting_percent",
      "on_front", "range_deg", "peak_force_n", "peak_speed_mm_s", "peak_power_w",           "d_min_mm"};
  for (const std::string& link : LinkColumns("")) header.push_back(link);
  header.push_back("reason");
  CsvWriter table(header);
  constexpr int kOfSolved = 15;
  for (const synthesis::ActuatorCurve& curve : curves)
    for (const synthesis::FrontPoint& point : curve.points) {
      table.Add(curve.Actuator().name).Add(point.assist).Add(StatusOf(curve, point));
      if (point.solved)
        AddSolved(curve, point, table);
      else
        for (int i = 0; i < kOfSolved; ++i) table.AddEmpty();
      table.Add(point.solved ? "" : curve.failing).EndRow();
    }
  table.Write(path);
}

std::string ActuatorFrontText(const std::vector<synthesis::ActuatorCurve>& curves, double own_s) {
  std::string text;
  for (const synthesis::ActuatorCurve& curve : curves) {
    text += fmt::format("{:<16}", curve.Actuator().name);
    for (const synthesis::FrontPoint& point : curve.points)
      if (point.solved && std::isfinite(point.assistance.shortest_s))
        text += fmt::format("  {:.0f} %: {:.2f} s{}", 100 * point.assist, point.assistance.shortest_s,
                            point.is_on_front ? " *" : "");
    if (!curve.Actuator().HasSpeed())
      text += "  speed not known";
    else if (!curve.Actuator().HasForceSpeedLaw())
      text += "  (lower bounds: speed under load not known)";
    if (!curve.Last()) text += fmt::format("  no design: {}", fmt::join(curve.limits, ", "));
    text += "\n";
  }
  return text +
         fmt::format("shortest rise at a share of the knee moment; * none is faster; the person's own: {:.2f} s\n",
                     own_s);
}

Json ActuatorFrontJson(const std::vector<synthesis::ActuatorCurve>& curves, const problem::SynthesisProblem& problem) {
  Json actuators = Json::array();
  for (const synthesis::ActuatorCurve& curve : curves) {
    Json points = Json::array();
    for (const synthesis::FrontPoint& point : curve.points)
      if (point.solved)
        points.push_back({{"assist", point.assist},
                          {"shortest_duration_s", NumberOrNull(point.assistance.shortest_s)},
                          {"limiting_percent", NumberOrNull(point.assistance.limiting_percent)},
                          {"on_front", point.is_on_front}});
    actuators.push_back({{"name", curve.Actuator().name},
                         {"source", curve.Actuator().source},
                         {"speed_is_known", curve.Actuator().HasSpeed()},
                         {"speed_under_load_is_known", curve.Actuator().HasForceSpeedLaw()},
                         {"mass_g", NumberOrNull(curve.Actuator().mass_g)},
                         {"points", points},
                         {"largest_assist", curve.Last() ? Json(curve.Last()->assist) : Json()},
                         {"reason", curve.failing.empty() ? Json() : Json(curve.failing)},
                         {"limits", curve.limits}});
  }
  return {{"profile", problem.profile->file.string()},
          {"own_duration_s", problem.profile->duration_s},
          {"actuators", actuators}};
}

}  // namespace lake::commands
