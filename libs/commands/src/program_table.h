// program.csv of a design for a person.
#pragma once

#include <filesystem>

#include "lake/redesign/redesign_outcome.h"

namespace lake::commands {

// The program sample by sample, and the knee angles that it is to follow; only the header where the design cannot make
// the motion.
void WriteProgramTable(const redesign::DesignInMotion& design, const redesign::HumanMotion& human,
                       const std::filesystem::path& path);

}  // namespace lake::commands
