// What the cuffs do to the leg over the rise, of several places of the joint or designs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/compare/joint_misalignment.h"
#include "lake/core/json.h"
#include "lake/cuffs/cuff_course.h"
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

}  // namespace lake::commands
