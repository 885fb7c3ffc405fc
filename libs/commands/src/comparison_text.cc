#include "comparison_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/compare/pointwise_error.h"
#include "lake/core/uncertain_text.h"

namespace lake::commands {
namespace {

const compare::Budget* FindBudget(const std::vector<compare::Budget>& budgets, const char* quantity) {
  const auto found = std::ranges::find(budgets, quantity, &compare::Budget::quantity);
  return found == budgets.end() ? nullptr : &*found;
}

// Of the interval of all sources; NaN where it is not known.
double HalfWidth(const compare::Budget* budget) {
  if (!budget) return std::nan("");
  const compare::Interval interval = budget->AnatomicalInterval();
  return (interval.high - interval.low) / 2;
}

// The joint on the leg that wears it, with the interval of all sources, to which every number is rounded.
std::string JointText(const compare::JointMisalignment& joint, const std::optional<compare::JointMoved>& moved,
                      const std::string& worn, const compare::Budget* rms) {
  const double half_width = HalfWidth(rms);
  const auto rounded = [&](double mm) { return KnownText(mm, half_width, 2); };
  std::string text = fmt::format("joint misalignment {} mm RMS", rounded(joint.rms_mm));
  if (rms) {
    const compare::Interval all = rms->AnatomicalInterval(), markers = rms->MarkerInterval();
    text += fmt::format(" (95 % interval {} to {} mm; of the markers alone {} to {} mm)", rounded(all.low),
                        rounded(all.high), rounded(markers.low), rounded(markers.high));
  }
  text += fmt::format(", {} mm at most", rounded(joint.max_mm));
  text += fmt::format("; moving the joint leaves {}{} mm RMS", joint.repetitions < 2 ? "at least " : "",
                      rounded(joint.remainder_mm));
  if (moved) text += fmt::format(" and a path difference of {:.2f} %", 100 * moved->relative_rms);
  if (moved && moved->intervals)
    text += fmt::format(" (95 % interval {:.2f} to {:.2f} %)", 100 * moved->intervals->relative_rms.low,
                        100 * moved->intervals->relative_rms.high);
  return text + "\n" + (worn.empty() ? "" : worn + "\n");
}

std::string CuffText(const cuffs::CuffCourse& worn, const cuffs::CuffCourse& moved) {
  const auto newtons = [](const std::vector<cuffs::CuffForce>& course) {
    const cuffs::CuffForce largest = cuffs::Largest(course);
    return fmt::format("{:.0f} N ({:.0f} to {:.0f})", largest.force_n, largest.low_n, largest.high_n);
  };
  return fmt::format("it loads the thigh's cuff by {}, the shank's by {}; with the joint moved {} and {}\n",
                     newtons(worn.thigh_n), newtons(worn.shank_n), newtons(moved.thigh_n), newtons(moved.shank_n));
}

// What the exoskeleton does to pace and posture.
std::string PaceAndPostureText(const compare::Misalignment& m) {
  const compare::Pace& pace = m.pace;
  const compare::Posture& posture = m.posture;
  std::string text = fmt::format("the {} takes {:.2f} s, with the exoskeleton {:.2f} s",
                                 gait::MovementOf(m.movement).repetition, pace.repetition.human, pace.repetition.exo);
  for (const auto& [name, angle] : {std::pair("shank", &posture.shank), std::pair("trunk", &posture.trunk)}) {
    if (!*angle) continue;
    const double more_deg = (*angle)->mean_deg.Value();
    text += fmt::format("; with it the {} leans {:.1f}° {} forward on average ({:.1f}° RMS apart)", name,
                        std::abs(more_deg), more_deg < 0 ? "less" : "more", (*angle)->rms_deg);
  }
  return text + "\n";
}

std::string PathText(const compare::Misalignment& m) {
  std::string text = fmt::format(
      "path difference at equal percent{} {:.2f} mm RMS, {:.2f} mm at most; {:.2f} % of the shank RMS, {:.2f} % at "
      "most\n",
      m.movement == gait::MovementKind::kWalking ? " of the stride, relative to the hip," : "", m.metrics.rms_mm,
      m.metrics.max_mm, 100 * m.metrics.relative_rms, 100 * m.metrics.relative_max);
  if (!m.intervals) return text;
  return text + fmt::format("95 % interval of the path difference {:.2f} to {:.2f} % RMS; noise alone shows {:.2f} %\n",
                            100 * m.intervals->relative_rms.low, 100 * m.intervals->relative_rms.high,
                            100 * m.noise_floor_relative);
}

std::string PartsText(const compare::Decomposition& parts, const Eigen::Vector2d& joint_mm,
                      const Eigen::Vector2d& half_width_mm) {
  if (!std::isfinite(parts.placement)) return "both paths are one: there are no parts\n";
  std::vector<std::string> each;
  for (const compare::Part& part : compare::kParts)
    each.push_back(fmt::format("{} {:.1f} % ({:.1f} mm)", part.name, 100 * (parts.*part.fraction),
                               std::sqrt(compare::MeanSquare(parts.*part.vectors_mm))));
  return fmt::format("{}\nthe exoskeleton's joint sits {}\n", fmt::join(each, ", "),
                     compare::DescribeJoint(joint_mm, half_width_mm));
}

}  // namespace

std::string ComparisonText(const compare::Misalignment& m, const std::vector<compare::Budget>& budgets,
                           const std::string& worn, const std::vector<CuffCase>& cuffs) {
  std::string text;
  const compare::Budget* rms = FindBudget(budgets, "joint_rms");
  const Eigen::Vector2d half_width_mm(HalfWidth(FindBudget(budgets, "joint_offset_x")),
                                      HalfWidth(FindBudget(budgets, "joint_offset_y")));
  if (m.joint) text += JointText(*m.joint, m.joint_moved, worn, rms);
  if (rms) text += compare::WhatNarrows(*rms) + "\n";
  if (!cuffs.empty()) text += CuffText(cuffs.front().course, cuffs.back().course);
  return text + PathText(m) + PaceAndPostureText(m) +
         PartsText(m.decomposition, m.joint ? m.joint->mean_mm : m.decomposition.offset_mm, half_width_mm);
}

}  // namespace lake::commands
