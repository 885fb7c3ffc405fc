// What a comparison says beside its curves: forces at the cuffs, what seat and limbs allow of a worn linkage whose
// joint is moved onto the knee, and the text at the terminal.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/compare/joint_misalignment.h"
#include "lake/core/json.h"
#include "lake/cuffs/cuff_course.h"
#include "lake/linkage/design_file.h"
#include "lake/linkage/wear.h"
#include "lake/report/report.h"

namespace lake::commands {

struct CuffCase {
  std::string name;  // worn, moved; before, joint_moved, other_program, after
  cuffs::CuffCourse course;
};

// The joint as worn and moved onto the knee. `leg`: the exoskeleton trial's mean, with the leg's own knee.
// `place_sd_mm`: of the joint's place against the knee.
std::vector<CuffCase> CuffCases(const compare::StsCurve& leg, const compare::JointMisalignment& joint,
                                double place_sd_mm, const cuffs::CuffOptions& options);

// case, percent, then thigh_cuff, shank_cuff and knee_shear, each with its limits.
void WriteCuffTable(const std::filesystem::path& path, const std::vector<CuffCase>& cases);

// The largest over the rise: thigh_cuff_n, shank_cuff_n, knee_shear_n, each with its …_interval_n.
Json CuffsJson(const cuffs::CuffCourse& course);

report::Section CuffSection(const std::vector<CuffCase>& cases, const cuffs::CuffOptions& options);

struct WornJoint {
  linkage::WearCheck as_worn, moved;  // on this person, the joint where it was and where it is best
  // Of the places nearer to the knee than as worn, and within 40 mm of it, at which linkage and actuator reach no
  // further into seat and limbs than as worn, the nearest to the knee, in steps of 2 mm, shank frame; absent: there is
  // none.
  std::optional<Eigen::Vector2d> nearest_mm;
};

// `offset_mm`: where the joint was from the knee, shank frame. Throws Error where the links cannot be assembled.
WornJoint CheckWornJoint(const linkage::Design& worn, const Eigen::Vector2d& offset_mm, const person::Body& body,
                         linkage::WearOptions wear);

// Sentences for people: what is in the way, and how near to the knee the joint may be instead. `unmoved_mm`: what
// moving leaves of the joint misalignment, RMS.
std::string WornJointText(const WornJoint& joint, double unmoved_mm);

Json WornJointJson(const WornJoint& joint);

// For the terminal, of comparison.json with its curves.
std::string ComparisonText(const Json& comparison);

}  // namespace lake::commands
