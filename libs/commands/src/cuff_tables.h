// What the cuffs do to the leg over the rise, worn as measured and with the joint moved onto the knee.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "lake/compare/joint_misalignment.h"
#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/cuffs/cuff_model.h"
#include "lake/report/report.h"

namespace lake::commands {

// N, with what the stiffness and the misfit's own uncertainty leave open (95 %).
struct CuffForce {
  double force_n = 0, low_n = 0, high_n = 0;
};

struct CuffCase {
  std::string name;                                       // worn, moved
  std::vector<CuffForce> thigh_n, shank_n, knee_shear_n;  // per percent, the largest of a segment's cuffs
};

// `leg`: the exoskeleton trial's mean, with the leg's own knee. `misfit_share`: standard deviation of the misfit over
// itself. The cuffs are free of stress at standing.
std::vector<CuffCase> CuffCases(const compare::StsCurve& leg, const compare::JointMisalignment& joint,
                                double misfit_share, const cuffs::CuffOptions& options);

void WriteCuffTable(const std::filesystem::path& path, const std::vector<CuffCase>& cases);

// The largest over the rise: of each case thigh_n, shank_n, knee_shear_n, each with its …_interval_n.
Json CuffsJson(const std::vector<CuffCase>& cases);

report::Section CuffSection(const std::vector<CuffCase>& cases, const cuffs::CuffOptions& options);

}  // namespace lake::commands
