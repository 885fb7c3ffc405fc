#include "assistance_tables.h"

#include <fmt/ranges.h>

#include <cmath>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/figure/design_figures.h"
#include "optimum_tables.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

using problem::AssistanceRow;

constexpr double kRounding = 1e-5;  // a solver leaves a force this much above its limit, with what its pace is off

void WriteTable(const problem::Assistance& assistance, const std::filesystem::path& path) {
  CsvWriter table({"percent", "time_s", "knee_deg", "knee_nm", "stroke_mm", "moment_arm_mm", "force_n", "speed_mm_s",
                   "power_w", "least_duration_s"});
  for (const AssistanceRow& row : assistance.rows)
    table.AddRow(row.percent, row.time_s, row.knee_deg, row.knee_nm, row.stroke_mm, row.moment_arm_mm, row.force_n,
                 row.speed_mm_s, row.power_w, row.least_duration_s);
  table.Write(path);
}

Json PeakJson(const problem::Assistance& assistance, double AssistanceRow::*column) {
  const AssistanceRow* row = assistance.Largest(column);
  if (!row) return nullptr;
  return {{"value", NumberOrNull(row->*column)}, {"percent", row->percent}, {"knee_deg", row->knee_deg}};
}

// Work of the actuator where it drives, trapezoids over the rows known.
double DrivenEnergy(const problem::Assistance& assistance) {
  double energy_j = 0;
  for (std::size_t i = 1; i < assistance.rows.size(); ++i) {
    const AssistanceRow &from = assistance.rows[i - 1], &to = assistance.rows[i];
    if (std::isfinite(from.power_w) && std::isfinite(to.power_w))
      energy_j += (std::max(0.0, from.power_w) + std::max(0.0, to.power_w)) / 2 * (to.time_s - from.time_s);
  }
  return energy_j;
}

Json ActuatorJson(const problem::LinearActuator& actuator, double duration_s) {
  Json json = {{"name", actuator.name},
               {"maker", actuator.maker},
               {"source", actuator.source},
               {"closed_mm", NumberOrNull(actuator.closed_mm)},
               {"travel_mm", NumberOrNull(actuator.travel_mm)},
               {"lifting_force_n", NumberOrNull(actuator.LiftingForce())},
               {"no_load_speed_mm_s", NumberOrNull(actuator.no_load_speed_mm_s)},
               {"speed_under_load_is_known", actuator.HasForceSpeedLaw()},
               {"holding_force_n", NumberOrNull(actuator.holding_force_n)},
               {"mass_g", NumberOrNull(actuator.mass_g)},
               {"duty_cycle_percent", NumberOrNull(actuator.duty_cycle_percent)}};
  // After a rise it must not run for so long.
  json["pause_s"] = actuator.duty_cycle_percent && std::isfinite(duration_s)
                        ? Json(duration_s * (100 / *actuator.duty_cycle_percent - 1))
                        : Json();
  return json;
}

// How fast, what decides, and how fast any linkage could be.
std::string AssistanceText(const problem::Assistance& assistance, const problem::SynthesisProblem& problem) {
  const double share = 100 * problem.assist.value_or(1), own_s = problem.profile->duration_s;
  const AssistanceRow* force = assistance.Largest(&AssistanceRow::force_n);
  const std::string most =
      force ? fmt::format("at most {:.0f} N, at {:.0f} % of the rise", std::abs(force->force_n), force->percent) : "";
  if (!problem.actuator) return fmt::format("{:.0f} % of the knee moment takes {}", share, most);
  const std::string& name = problem.actuator->name;
  if (const auto lifts_n = problem.actuator->LiftingForce();
      force && lifts_n && std::abs(force->force_n) > *lifts_n * (1 + kRounding))
    return fmt::format(
        "{} cannot give {:.0f} % of the knee moment with this linkage: that takes {}, and it lifts {:.0f} N", name,
        share, most, *lifts_n);
  if (std::isnan(assistance.shortest_s))
    return fmt::format("{}: {:.0f} % of the knee moment takes {}; the actuator's speed is unknown", name, share, most);
  if (std::isinf(assistance.shortest_s))
    return fmt::format("{} cannot give {:.0f} % of the knee moment with this linkage: that takes {}", name, share,
                       most);
  std::string text = fmt::format(
      "{} gives {:.0f} % of the knee moment in a rise of {:.1f} s or longer (the person's own: {:.1f} s); its "
      "{} is the limit, at {:.0f} % of the rise; {}",
      name, share, assistance.shortest_s, own_s, assistance.force_is_limit ? "force" : "speed",
      assistance.limiting_percent, most);
  if (!assistance.speed_under_load_is_known)
    text += "; its speed under load is not known, so this is a lower bound";
  else if (std::isfinite(assistance.bound_s))
    text += fmt::format("; with its power no linkage could be faster than {:.1f} s", assistance.bound_s);
  return text;
}

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

Json WriteAssistance(const problem::Assistance& assistance, const problem::SynthesisProblem& problem, Run& run) {
  WriteTable(assistance, run.Result("assistance.csv"));
  DrawPngAndSvg("assistance", run, figure::DrawAssistance, assistance, problem);
  const std::string text = AssistanceText(assistance, problem);
  run.Report(text + "\n");
  Json json = {{"text", text},
               {"profile", problem.profile->file.string()},
               {"assist", problem.assist.value_or(1)},
               {"actuator", problem.actuator ? ActuatorJson(*problem.actuator, assistance.duration_s) : Json()},
               {"own_duration_s", problem.profile->duration_s},
               {"duration_s", assistance.duration_s},
               {"moments_of_s", assistance.moments_s},
               {"shortest_duration_s", NumberOrNull(assistance.shortest_s)},
               {"shortest_is_lower_bound", problem.actuator && !assistance.speed_under_load_is_known},
               {"limiting_percent", NumberOrNull(assistance.limiting_percent)},
               {"any_linkage_duration_s", NumberOrNull(assistance.bound_s)},
               {"any_linkage_percent", NumberOrNull(assistance.bound_percent)}};
  json["force_n"] = PeakJson(assistance, &AssistanceRow::force_n);
  json["speed_mm_s"] = PeakJson(assistance, &AssistanceRow::speed_mm_s);
  json["power_w"] = PeakJson(assistance, &AssistanceRow::power_w);
  json["driven_energy_j"] = DrivenEnergy(assistance);
  return json;
}

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
