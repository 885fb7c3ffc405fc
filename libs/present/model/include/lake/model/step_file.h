// Plates, pins and spacers as solids, for CAD.
#pragma once

#include <filesystem>

#include "lake/linkage/linkage.h"
#include "lake/parts/mechanism.h"

namespace lake::model {

// STEP AP214, mm, in the thigh frame with the layers along z, assembled in this pose; each solid has its part's name.
// Throws Error if it cannot be written.
void WriteStep(const std::filesystem::path& path, const parts::Mechanism& mechanism, const linkage::Pose& pose);

}  // namespace lake::model
