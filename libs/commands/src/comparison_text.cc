#include "comparison_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/compare/pointwise_error.h"

namespace lake::commands {
namespace {

// The joint on the leg that wears it.
std::string JointText(const compare::JointMisalignment& joint, const std::optional<compare::JointMoved>& moved,
                      const std::string& worn) {
  std::string text = fmt::format("joint misalignment {:.2f} mm RMS, {:.2f} mm at most, {:.2f} % of the shank",
                                 joint.rms_mm, joint.max_mm, 100 * joint.relative_rms);
  if (joint.intervals)
    text += fmt::format(" (95 % interval {:.2f} to {:.2f} mm RMS)", joint.intervals->rms_mm.low,
                        joint.intervals->rms_mm.high);
  text += fmt::format("; moving the joint leaves {:.2f} mm RMS", joint.remainder_mm);
  if (moved) text += fmt::format(" and a path difference of {:.2f} %", 100 * moved->relative_rms);
  if (moved && moved->intervals)
    text += fmt::format(" (95 % interval {:.2f} to {:.2f} %)", 100 * moved->intervals->relative_rms.low,
                        100 * moved->intervals->relative_rms.high);
  return text + "\n" + worn + "\n";
}

// What the markers do not tell of the joint beneath them; empty where its budget is not known.
std::string AnatomyText(const std::vector<compare::Budget>& budgets) {
  const auto joint = std::ranges::find(budgets, "joint_rms", &compare::Budget::quantity);
  if (joint == budgets.end()) return "";
  const compare::Interval interval = joint->AnatomicalInterval();
  return fmt::format("of the joint beneath the skin: 95 % interval {:.1f} to {:.1f} mm RMS; {}\n", interval.low,
                     interval.high, compare::WhatNarrows(*joint));
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
std::string PaceAndPostureText(const compare::Pace& pace, const compare::Posture& posture) {
  std::string text =
      fmt::format("the rise takes {:.2f} s, with the exoskeleton {:.2f} s", pace.rise.human, pace.rise.exo);
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
      "path difference at equal percent {:.2f} mm RMS, {:.2f} mm at most; {:.2f} % of the shank RMS, {:.2f} % at "
      "most\n",
      m.metrics.rms_mm, m.metrics.max_mm, 100 * m.metrics.relative_rms, 100 * m.metrics.relative_max);
  if (!m.intervals) return text;
  return text + fmt::format("95 % interval of the path difference {:.2f} to {:.2f} % RMS; noise alone shows {:.2f} %\n",
                            100 * m.intervals->relative_rms.low, 100 * m.intervals->relative_rms.high,
                            100 * m.noise_floor_relative);
}

std::string PartsText(const compare::Decomposition& parts, const Eigen::Vector2d& joint_mm) {
  if (!std::isfinite(parts.placement)) return "both paths are one: there are no parts\n";
  const auto part = [](const char* name, double fraction, const std::vector<Eigen::Vector2d>& vectors_mm) {
    return fmt::format("{} {:.1f} % ({:.1f} mm)", name, 100 * fraction, std::sqrt(compare::MeanSquare(vectors_mm)));
  };
  return fmt::format("{}, {}, {}\nthe exoskeleton's joint sits {}\n",
                     part("placement", parts.placement, parts.placement_mm),
                     part("timing", parts.timing, parts.timing_mm), part("shape", parts.shape, parts.shape_mm),
                     compare::DescribeJoint(joint_mm));
}

}  // namespace

std::string ComparisonText(const compare::Misalignment& m, const std::vector<compare::Budget>& budgets,
                           const std::string& worn, const std::vector<CuffCase>& cuffs) {
  std::string text;
  if (m.joint) text += JointText(*m.joint, m.joint_moved, worn) + AnatomyText(budgets);
  if (!cuffs.empty()) text += CuffText(cuffs.front().course, cuffs.back().course);
  return text + PathText(m) + PaceAndPostureText(m.pace, m.posture) +
         PartsText(m.decomposition, m.joint ? m.joint->mean_mm : m.decomposition.offset_mm);
}

}  // namespace lake::commands
