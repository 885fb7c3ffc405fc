// Finds the links that give the largest range of rotation, proves it, and says what it is worth; with a human's motion,
// those whose knee also follows it.
#include <fmt/ranges.h>

#include <string>
#include <vector>

#include "lake/commands/optimize.h"
#include "program.h"

namespace {

using lake::Json;

// Before and after, where there is a motion.
std::string ReportMotion(const Json& summary) {
  if (!summary.contains("before")) return "";
  const auto line = [&](const char* name, const char* key, const char* unit) {
    const auto cell = [&](const char* when) {
      const Json& value = summary[when][key];
      return value.is_number() ? fmt::format("{:10.4g}", value.get<double>()) : fmt::format("{:>10}", "-");
    };
    return fmt::format("  {:<22}{} ->{} {}\n", name, cell("before"), cell("after"), unit);
  };
  return line("range", "range_deg", "deg") + line("misalignment", "misalignment_percent", "% of the shank, RMS") +
         line("", "misalignment_rms_mm", "mm RMS") + line("  placement", "part_placement", "of it") +
         line("  timing", "part_timing", "of it") + line("  shape", "part_shape", "of it") +
         line("joint sits", "placement_x_mm", "mm in front of the knee") +
         line("", "placement_y_mm", "mm above it, along the shank") + line("program", "program_duration_s", "s") +
         line("exact tracking takes", "exact_tracking_time_s", "s") + summary["trial_text"].get<std::string>() + "\n" +
         summary["build_text"].get<std::string>() + "\n";
}

std::string ReportFront(const Json& summary) {
  std::string text;
  for (const Json& actuator : summary["actuators"]) {
    text += fmt::format("{:<16}", actuator["name"].get<std::string>());
    for (const Json& point : actuator["points"])
      if (const Json& duration = point["shortest_duration_s"]; duration.is_number())
        text += fmt::format("  {:.0f} %: {:.2f} s{}", 100 * point["assist"].get<double>(), duration.get<double>(),
                            point["on_front"].get<bool>() ? " *" : "");
    if (!actuator["speed_is_known"].get<bool>())
      text += "  speed not known";
    else if (!actuator["speed_under_load_is_known"].get<bool>())
      text += "  (lower bounds: speed under load not known)";
    if (actuator["points"].empty())
      text += fmt::format("  no design: {}", fmt::join(actuator["limits"].get<std::vector<std::string>>(), ", "));
    text += "\n";
  }
  return text +
         fmt::format("shortest rise at a share of what the knee needs; * none is faster; the person's own: {:.2f} s\n",
                     summary["own_duration_s"].get<double>());
}

// Whom the design is for, and what it costs each.
std::string ReportPeople(const Json& summary) {
  if (!summary.contains("people")) return "";
  const auto cell = [](const Json& value, int digits) {
    return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), digits) : std::string("-");
  };
  std::string text = fmt::format("  {:<20}{:>16}{:>22}\n", "person", "misalignment", "costs, against their own");
  for (const Json& person : summary["people"])
    text += fmt::format("  {:<20}{:>14} %{:>20} °\n", person["person"].get<std::string>(),
                        cell(person["misalignment_percent"], 2), cell(person["cost_deg"], 1));
  if (summary.contains("across"))
    text += fmt::format("{} misalignment {} % of the shank, RMS\n", summary["across"].get<std::string>(),
                        cell(summary["misalignment_percent"], 3));
  return text;
}

// Each size, who gets it by which rule, and how that went for those who were left out.
std::string ReportSizes(const Json& summary) {
  std::string text;
  for (const Json& size : summary["sizes"])
    text += fmt::format("size {}: range {:.2f} deg, {} people\n", size["size"].get<int>(),
                        size["range_deg"].get<double>(), size["people"].get<int>());
  const Json& rule = summary["rule"];
  for (const Json& range : rule["ranges"])
    if (range["to_mm"].is_number())
      text += fmt::format("  {} up to {:.1f}: size {}\n", rule["quantity"].get<std::string>(),
                          range["to_mm"].get<double>(), range["size"].get<int>());
    else
      text +=
          fmt::format("  {}: size {}\n", rule["ranges"].size() > 1 ? "else" : "everybody", range["size"].get<int>());
  return text +
         fmt::format("leaving one out: the rule gives {} of {} the size that they wear, and {} keep the limits\n",
                     rule["left_out_same_size"].get<int>(), rule["left_out"].get<int>(),
                     rule["left_out_hold"].get<int>());
}

std::string Report(const Json& summary) {
  if (summary.contains("actuators")) return ReportFront(summary);
  if (summary.contains("sizes")) return ReportSizes(summary) + ReportPeople(summary);
  std::string text = fmt::format("range {:.4f} deg", summary["range_deg"].get<double>());
  if (const Json& bound = summary["certified_upper_bound_deg"]; bound.is_number())
    text += fmt::format(", proved to be at most {:.4f} deg for any design", bound.get<double>());
  if (const auto robust = summary.find("robust"); robust != summary.end())
    text += fmt::format(", at least {:.4f} deg for every build within {:.4g} mm",
                        (*robust)["worst_range_deg"].get<double>(), (*robust)["tolerance_mm"].get<double>());
  text += "\n";
  if (summary.contains("assistance")) text += summary["assistance"]["text"].get<std::string>() + "\n";
  text += ReportMotion(summary) + ReportPeople(summary);
  for (const auto& [name, length] : summary["links"].items())
    text += fmt::format("  {} {:9.4f} mm\n", name, length.get<double>());
  for (const Json& limit : summary.value("active", Json::array())) {
    text += fmt::format("  at its limit: {}", limit["limit"].get<std::string>());
    if (limit["multiplier"].is_number())
      text += fmt::format(", {:.4g} {}", limit["multiplier"].get<double>(), limit["unit"].get<std::string>());
    text += "\n";
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  lake::Program program(
      "lake-optimize",
      "The links that give the largest range of rotation; with a human's motion, the exoskeleton that follows it.",
      "lake-optimize --starts 20 --grashof-margin 2 --singularity-margin 2 --certify -o lake-out/design\n"
      "  lake-optimize --profile lake-out/loads --assist 0.4 --actuator LA31-1000 --duration free\n"
      "  lake-optimize --comparison lake-out/comparison --worn worn.yaml --max-misalignment 3 --program free "
      "--duration 25 --fit-placement --pareto 12\n"
      "  lake-optimize --comparison sub-01/comparison sub-02/comparison sub-03/comparison --human-only "
      "--max-misalignment 3 --program free --duration 25 --fit-placement");
  lake::commands::OptimizeRunOptions options;
  lake::commands::ReoptimizeRunOptions reoptimize;
  program.Add(lake::OptionsOf(options));
  // The duration stands among the problem's options.
  const auto motion =
      program.Add(lake::OptionsOf(reoptimize).Without({"duration"}), "Re-optimisation, with --comparison or --human");
  return program.Main(
      argc, argv, [] { return std::string("optimize"); },
      [&](lake::Run& run) {
        options.study.quiet = options.study.optimize.quiet = run.Quiet();
        if (motion->IsAnyGiven()) options.reoptimize = reoptimize;
        return lake::commands::RunOptimize(options, run);
      },
      Report);
}
