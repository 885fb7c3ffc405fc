// lake-compare: the misalignment between a human's and an exoskeleton's knee in sit-to-stand.
#include <cmath>
#include <string>

#include "lake/commands/compare.h"
#include "lake/commands/symmetry.h"
#include "lake/compare/misalignment.h"
#include "lake/core/json.h"
#include "program.h"

namespace {

// The joint on the leg that wears it; empty if that leg's knee is not shown.
std::string JointReport(const lake::Json& summary) {
  using lake::NumberOrNaN;
  const lake::Json& joint = summary["joint"];
  if (joint.is_null()) return "";
  std::string text =
      fmt::format("joint misalignment {:.2f} mm RMS, {:.2f} mm at most, {:.2f} % of the shank",
                  NumberOrNaN(joint["rms_mm"]), NumberOrNaN(joint["max_mm"]), 100 * NumberOrNaN(joint["relative_rms"]));
  if (joint.contains("rms_interval_mm")) {
    const lake::Json& interval = joint["rms_interval_mm"];
    text += fmt::format(" (95 % interval {:.2f} to {:.2f} mm RMS)", NumberOrNaN(interval[0]), NumberOrNaN(interval[1]));
  }
  const lake::Json& moved = summary["best_placement"];
  text += fmt::format("; moving the joint leaves {:.2f} mm RMS", NumberOrNaN(moved["rms_mm"]));
  if (moved.contains("path_relative_rms"))
    text += fmt::format(" and a path difference of {:.2f} %", 100 * NumberOrNaN(moved["path_relative_rms"]));
  if (moved.contains("path_relative_rms_interval"))
    text +=
        fmt::format(" (95 % interval {:.2f} to {:.2f} %)", 100 * NumberOrNaN(moved["path_relative_rms_interval"][0]),
                    100 * NumberOrNaN(moved["path_relative_rms_interval"][1]));
  return text + "\n" + moved["body_text"].get<std::string>() + "\n";
}

// The same headline with what the markers do not tell of the joint beneath them, and what the cuffs make of it.
std::string AnatomyReport(const lake::Json& summary) {
  using lake::NumberOrNaN;
  if (!summary["uncertainty"].contains("joint_rms_mm")) return "";
  const lake::Json& joint = summary["uncertainty"]["joint_rms_mm"];
  std::string text = fmt::format("of the joint beneath the skin: 95 % interval {:.1f} to {:.1f} mm RMS; {}\n",
                                 NumberOrNaN(joint["anatomical_interval"][0]),
                                 NumberOrNaN(joint["anatomical_interval"][1]), joint["narrower"].get<std::string>());
  if (!summary.contains("cuffs")) return text;
  const auto newtons = [&](const char* which, const char* name) {
    const lake::Json& of = summary["cuffs"][which];
    const lake::Json& interval = of[fmt::format("{}_interval_n", name)];
    return fmt::format("{:.0f} N ({:.0f} to {:.0f})", NumberOrNaN(of[fmt::format("{}_n", name)]),
                       NumberOrNaN(interval[0]), NumberOrNaN(interval[1]));
  };
  return text + fmt::format("it loads the thigh's cuff by {}, the shank's by {}; with the joint moved {} and {}\n",
                            newtons("worn", "thigh_cuff"), newtons("worn", "shank_cuff"),
                            newtons("moved", "thigh_cuff"), newtons("moved", "shank_cuff"));
}

// What the exoskeleton does to pace and posture.
std::string PaceAndPostureReport(const lake::Json& summary) {
  using lake::NumberOrNaN;
  const lake::Json &pace = summary["pace"], &posture = summary["posture"];
  std::string text = fmt::format("the rise takes {:.2f} s, with the exoskeleton {:.2f} s", NumberOrNaN(pace["human_s"]),
                                 NumberOrNaN(pace["exo_s"]));
  for (const auto& [name, angle] : {std::pair("shank", &posture["shank"]), std::pair("trunk", &posture["lean"])})
    if (!angle->is_null())
      text +=
          fmt::format("; with it the {} leans {:.1f}° {} forward on average ({:.1f}° RMS apart)", name,
                      std::abs(NumberOrNaN((*angle)["difference_deg"])),
                      NumberOrNaN((*angle)["difference_deg"]) < 0 ? "less" : "more", NumberOrNaN((*angle)["rms_deg"]));
  return text + "\n";
}

std::string Report(const lake::Json& summary) {
  if (summary.contains("symmetry")) return lake::commands::SymmetryReport(summary);
  const lake::Json& metrics = summary["metrics"];
  const lake::Json& parts = summary["decomposition"];
  using lake::NumberOrNaN;
  const auto part = [&](const char* name) { return 100 * NumberOrNaN(parts[name]["fraction"]); };
  std::string text = JointReport(summary) + AnatomyReport(summary);
  text += fmt::format(
      "path difference at equal percent {:.2f} mm RMS, {:.2f} mm at most; {:.2f} % of the shank RMS, {:.2f} % at "
      "most\n",
      NumberOrNaN(metrics["rms_mm"]), NumberOrNaN(metrics["max_mm"]), 100 * NumberOrNaN(metrics["relative_rms"]),
      100 * NumberOrNaN(metrics["relative_max"]));
  if (summary.contains("intervals")) {
    const lake::Json& interval = summary["intervals"]["relative_rms"];
    text += fmt::format("95 % interval of the path difference {:.2f} to {:.2f} % RMS; noise alone shows {:.2f} %\n",
                        100 * NumberOrNaN(interval[0]), 100 * NumberOrNaN(interval[1]),
                        100 * NumberOrNaN(summary["noise_floor_relative"]));
  }
  text += PaceAndPostureReport(summary);
  if (!std::isfinite(part("placement"))) return text + "both paths are one: there are no parts\n";
  const auto part_mm = [&](const char* name) { return NumberOrNaN(summary["parts_mm"][name]["rms_mm"]); };
  text += fmt::format("placement {:.1f} % ({:.1f} mm), timing {:.1f} % ({:.1f} mm), shape {:.1f} % ({:.1f} mm)\n",
                      part("placement"), part_mm("placement"), part("timing"), part_mm("timing"), part("shape"),
                      part_mm("shape"));
  const lake::Json& joint = (summary["joint"].is_null() ? parts : summary["joint"])["offset_mm"];
  return text + fmt::format("the exoskeleton's joint sits {}\n",
                            lake::compare::DescribeJoint({NumberOrNaN(joint[0]), NumberOrNaN(joint[1])}));
}

}  // namespace

int main(int argc, char** argv) {
  lake::Program program("lake-compare", "The misalignment between a human's and an exoskeleton's knee in sit-to-stand",
                        "lake-compare track/human track/exo --human-knee knee --exo-knee exo_knee -o comparison");
  lake::commands::CompareRunOptions options;
  program.Add(lake::OptionsOf(options));
  return program.Main(
      argc, argv, [] { return std::string("comparison"); },
      [&](lake::Run& run) { return lake::commands::RunCompare(options, run); }, Report);
}
