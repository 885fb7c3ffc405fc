#include "lake/problem/problem_template.h"

#include <fmt/format.h>

#include "lake/core/option_template.h"
#include "lake/problem/problem.h"

namespace lake::problem {
namespace {

std::string LinkKeys(const SynthesisProblem& paper) {
  constexpr const char* kLinks[] = {"coupler RS",    "slewing bar PR",           "thigh link KP",
                                    "shank link KS", "mount M behind the thigh", "mount M above the thigh pin P"};
  std::string bounds = "bounds:\n", start = "start:\n";
  for (std::size_t i = 0; i < paper.bounds.size(); ++i) {
    bounds += TemplateLine(LinkName(i), fmt::format("[{}, {}]", paper.bounds[i].lower, paper.bounds[i].upper),
                           fmt::format("{}, mm", kLinks[i]), 2);
    start += TemplateLine(LinkName(i), fmt::format("{}", paper.start.Values()[i]), "where the search starts, mm", 2);
  }
  return bounds + start;
}

std::string Line(std::string_view key, std::string_view value, std::string_view meaning) {
  return TemplateLine(key, value, meaning, 2);
}

// Of the limits that stand in one map.
std::string LimitLines(std::string_view section, int indent) {
  std::string lines;
  for (const LimitInfo& info : kLimitInfos)
    if (*info.key && section == info.section) lines += TemplateLine(info.key, info.example, info.help, indent);
  return lines;
}

}  // namespace

std::string ProblemTemplate() {
  const SynthesisProblem paper;
  SynthesisProblem described;
  OptionList parts;
  parts::Describe(described.parts, parts);
  const auto number = [](double value) { return fmt::format("{}", value); };
  return "# What a design must satisfy, for `lake optimize --problem FILE` and `problem:` of a study. Remove the '#' "
         "before\n"
         "# a key, and before its section, to set it. With none set the problem is the paper's; other values are "
         "examples.\n" +
         TemplateLine("d_min_mm", number(paper.d_min_mm), "the actuator's shortest stroke") +
         AsComment(
             TemplateLine("standing_deg", number(paper.standing_deg), "knee angle at which the used range ends") +
             LimitLines("", 0) + TemplateLine("robust_mm", "0.1", "tolerance of each link that a design must bear") +
             TemplateLine("mount", "behind", "beside|behind: where the linkage is on the leg; limb_mm is for behind") +
             TemplateLine("actuator", "LA31-1000",
                          "a name of the catalogue or a file; sets d_min, d_max and max_force") +
             LinkKeys(paper) + "margins:\n" +
             Line("grashof_mm", number(paper.grashof_margin_mm), "l3 + l4 is shorter than l1 + l2 by this") +
             Line("singularity_mm", number(paper.singularity_margin_mm), "of the shortest stroke from the dead point") +
             "load:\n" + Line("knee_torque_nm", number(paper.knee_torque_nm), "constant moment, without a profile") +
             LimitLines("load", 2) + Line("profile", "loads.json", "moments over a rise, from lake loads") +
             Line("assist", "0.4", "the actuator's share of them, 0 to 1") +
             Line("rest", "anywhere", "anywhere|standing: where the actuator holds without power") +
             Line("duration_s", "free", "time of the rise; free: as short as the actuator can") + "clearances:\n" +
             Line("seat_mm", "5", "of mount, links and actuator from the seat") +
             Line("limb_mm", "5", "of the actuator from thigh and shank") + "body:\n" +
             Line("height_mm", "1750", "stature") + Line("mass_kg", "70", "of the whole body") +
             Line("thigh_mm", "410", "knee to hip; with shank_mm") +
             Line("shank_mm", "400", "ankle to knee; with thigh_mm") +
             Line("seat_edge_mm", number(paper.clearances.seat_edge_mm),
                  "knee to the seat's front edge; 0: half the thigh is seated") +
             "parts:\n" + OptionTemplate(parts, 2));
}

}  // namespace lake::problem
