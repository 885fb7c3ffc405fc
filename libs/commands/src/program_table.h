// What the tables of one person's design and of a group's share: program.csv, a warning.
#pragma once

#include <filesystem>

#include "lake/core/run.h"
#include "lake/redesign/redesign_outcome.h"

namespace lake::commands {

// The program sample by sample, and the knee angles that it is to follow; only the header where the design cannot make
// the motion.
void WriteProgramTable(const redesign::DesignInMotion& design, const redesign::HumanMotion& human,
                       const std::filesystem::path& path);

// Where nothing limits the misalignment.
void WarnWithoutLimit(const redesign::MotionLimits& limits, Run& run);

}  // namespace lake::commands
