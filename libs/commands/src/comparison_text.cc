#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "comparison_tables.h"
#include "lake/compare/decomposition.h"
#include "lake/core/statistics.h"
#include "lake/report/misalignment_sections.h"

namespace lake::commands {
namespace {

using report::FactOf, report::Find, report::NumberAt, report::Uncertain;

// The joint on the leg that wears it, with the interval of all sources, to which every number is rounded.
std::string JointText(const Json& comparison) {
  if (Find(comparison, "joint").is_null()) return "";
  const Uncertain rms = FactOf(comparison, report::kJointRms), moved = FactOf(comparison, report::kPathMoved);
  const auto rounded = [&](const char* path) { return RoundedText(NumberAt(comparison, path), rms.Decimals(2)); };
  std::string text = fmt::format("joint misalignment {} mm RMS", rms.Text(2));
  if (rms.IsKnown())
    text += fmt::format(" (95 % interval {} mm; of the markers alone {} to {} mm)", rms.IntervalText(),
                        rounded("uncertainty/joint_rms_mm/marker_interval/0"),
                        rounded("uncertainty/joint_rms_mm/marker_interval/1"));
  text +=
      fmt::format(", {} mm at most; moved there and put on anew {}{} mm RMS", rounded("joint/max_mm"),
                  NumberAt(comparison, "joint/repetitions") < 2 ? "at least " : "", rounded("best_placement/rms_mm"));
  if (std::isfinite(moved.value)) text += fmt::format(" and a path difference of {:.2f} %", moved.value);
  if (std::isfinite(moved.low)) text += fmt::format(" (95 % interval {:.2f} to {:.2f} %)", moved.low, moved.high);
  text += "\n";
  for (const char* sentence : {"best_placement/body_text", "uncertainty/joint_rms_mm/narrower"})
    if (const Json words = Find(comparison, sentence); words.is_string()) text += words.get<std::string>() + "\n";
  return text;
}

std::string CuffText(const Json& cuffs) {
  if (cuffs.is_null()) return "";
  const auto newtons = [&](const std::string& of, const std::string& force) {
    const Uncertain n = report::UncertainOf(cuffs.at(of).at(force + "_n"), cuffs.at(of).at(force + "_interval_n"));
    return fmt::format("{:.0f} N ({:.0f} to {:.0f})", n.value, n.low, n.high);
  };
  return fmt::format("it loads the thigh's cuff by {}, the shank's by {}; with the joint moved {} and {}\n",
                     newtons("worn", "thigh_cuff"), newtons("worn", "shank_cuff"), newtons("moved", "thigh_cuff"),
                     newtons("moved", "shank_cuff"));
}

std::string PathText(const Json& comparison) {
  const Uncertain percent = FactOf(comparison, report::kPathPercent);
  std::string text = fmt::format(
      "path difference at equal percent{} {:.2f} mm RMS, {:.2f} mm at most; {:.2f} % of the shank RMS, {:.2f} % at "
      "most\n",
      report::IsOfWalking(comparison) ? " of the stride, relative to the hip," : "",
      FactOf(comparison, report::kPathMm).value, FactOf(comparison, report::kPathMaxMm).value, percent.value,
      FactOf(comparison, report::kPathMaxPercent).value);
  if (!comparison.contains("intervals")) return text;
  return text + fmt::format("95 % interval of the path difference {:.2f} to {:.2f} % RMS; noise alone shows {:.2f} %\n",
                            percent.low, percent.high, 100 * NumberAt(comparison, "noise_floor_relative"));
}

// What the exoskeleton does to pace and posture.
std::string PaceAndPostureText(const Json& comparison) {
  std::string text =
      fmt::format("the {} takes {:.2f} s, with the exoskeleton {:.2f} s", report::RepetitionIn(comparison),
                  NumberAt(comparison, "pace/human_s"), NumberAt(comparison, "pace/exo_s"));
  for (const auto& [name, key] : {std::pair("shank", "posture/shank"), std::pair("trunk", "posture/lean")}) {
    const Json angle = Find(comparison, key);
    if (angle.is_null()) continue;
    const double more_deg = NumberAt(angle, "difference_deg");
    text += fmt::format("; with it the {} leans {:.1f}° {} forward on average ({:.1f}° RMS apart)", name,
                        std::abs(more_deg), more_deg < 0 ? "less" : "more", NumberAt(angle, "rms_deg"));
  }
  return text + "\n";
}

std::string PartsText(const Json& comparison) {
  std::vector<std::string> each;
  for (const compare::Part& part : compare::kParts) {
    const std::string name = part.name;
    const double percent = 100 * NumberAt(comparison, fmt::format("decomposition/{}/fraction", name));
    if (std::isnan(percent)) return "both paths are one: there are no parts\n";
    const auto rms_mm = [&](const char* axis) {
      return RootMeanSquare(NumbersOrNaN(comparison.at("curves").at(fmt::format("{}_{}_mm", name, axis))));
    };
    each.push_back(fmt::format("{} {:.1f} % ({:.1f} mm)", name, percent, std::hypot(rms_mm("x"), rms_mm("y"))));
  }
  return fmt::format("{}\nthe exoskeleton's joint sits {}\n", fmt::join(each, ", "),
                     report::JointPlaceText(comparison));
}

}  // namespace

std::string ComparisonText(const Json& comparison) {
  return JointText(comparison) + CuffText(Find(comparison, "cuffs")) + PathText(comparison) +
         PaceAndPostureText(comparison) + PartsText(comparison);
}

}  // namespace lake::commands
