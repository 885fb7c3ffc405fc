#include "comparison_text.h"

#include <fmt/format.h>

#include <cmath>

#include "lake/compare/misalignment.h"

namespace lake::commands {
namespace {

// The joint on the leg that wears it; empty if that leg's knee is not shown.
std::string JointReport(const Json& comparison) {
  const Json& joint = comparison["joint"];
  if (joint.is_null()) return "";
  std::string text =
      fmt::format("joint misalignment {:.2f} mm RMS, {:.2f} mm at most, {:.2f} % of the shank",
                  NumberOrNaN(joint["rms_mm"]), NumberOrNaN(joint["max_mm"]), 100 * NumberOrNaN(joint["relative_rms"]));
  if (joint.contains("rms_interval_mm")) {
    const Json& interval = joint["rms_interval_mm"];
    text += fmt::format(" (95 % interval {:.2f} to {:.2f} mm RMS)", NumberOrNaN(interval[0]), NumberOrNaN(interval[1]));
  }
  const Json& moved = comparison["best_placement"];
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
std::string AnatomyReport(const Json& comparison) {
  if (!comparison["uncertainty"].contains("joint_rms_mm")) return "";
  const Json& joint = comparison["uncertainty"]["joint_rms_mm"];
  std::string text = fmt::format("of the joint beneath the skin: 95 % interval {:.1f} to {:.1f} mm RMS; {}\n",
                                 NumberOrNaN(joint["anatomical_interval"][0]),
                                 NumberOrNaN(joint["anatomical_interval"][1]), joint["narrower"].get<std::string>());
  if (!comparison.contains("cuffs")) return text;
  const auto newtons = [&](const char* which, const char* name) {
    const Json& of = comparison["cuffs"][which];
    const Json& interval = of[fmt::format("{}_interval_n", name)];
    return fmt::format("{:.0f} N ({:.0f} to {:.0f})", NumberOrNaN(of[fmt::format("{}_n", name)]),
                       NumberOrNaN(interval[0]), NumberOrNaN(interval[1]));
  };
  return text + fmt::format("it loads the thigh's cuff by {}, the shank's by {}; with the joint moved {} and {}\n",
                            newtons("worn", "thigh_cuff"), newtons("worn", "shank_cuff"),
                            newtons("moved", "thigh_cuff"), newtons("moved", "shank_cuff"));
}

// What the exoskeleton does to pace and posture.
std::string PaceAndPostureReport(const Json& comparison) {
  const Json &pace = comparison["pace"], &posture = comparison["posture"];
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

}  // namespace

std::string ComparisonText(const Json& comparison) {
  const Json& metrics = comparison["metrics"];
  const Json& parts = comparison["decomposition"];
  const auto part = [&](const char* name) { return 100 * NumberOrNaN(parts[name]["fraction"]); };
  std::string text = JointReport(comparison) + AnatomyReport(comparison);
  text += fmt::format(
      "path difference at equal percent {:.2f} mm RMS, {:.2f} mm at most; {:.2f} % of the shank RMS, {:.2f} % at "
      "most\n",
      NumberOrNaN(metrics["rms_mm"]), NumberOrNaN(metrics["max_mm"]), 100 * NumberOrNaN(metrics["relative_rms"]),
      100 * NumberOrNaN(metrics["relative_max"]));
  if (comparison.contains("intervals")) {
    const Json& interval = comparison["intervals"]["relative_rms"];
    text += fmt::format("95 % interval of the path difference {:.2f} to {:.2f} % RMS; noise alone shows {:.2f} %\n",
                        100 * NumberOrNaN(interval[0]), 100 * NumberOrNaN(interval[1]),
                        100 * NumberOrNaN(comparison["noise_floor_relative"]));
  }
  text += PaceAndPostureReport(comparison);
  if (!std::isfinite(part("placement"))) return text + "both paths are one: there are no parts\n";
  const auto part_mm = [&](const char* name) { return NumberOrNaN(comparison["parts_mm"][name]["rms_mm"]); };
  text += fmt::format("placement {:.1f} % ({:.1f} mm), timing {:.1f} % ({:.1f} mm), shape {:.1f} % ({:.1f} mm)\n",
                      part("placement"), part_mm("placement"), part("timing"), part_mm("timing"), part("shape"),
                      part_mm("shape"));
  const Json& joint = (comparison["joint"].is_null() ? parts : comparison["joint"])["offset_mm"];
  return text + fmt::format("the exoskeleton's joint sits {}\n",
                            compare::DescribeJoint({NumberOrNaN(joint[0]), NumberOrNaN(joint[1])}));
}

}  // namespace lake::commands
