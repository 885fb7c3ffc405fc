// The forces in the linkage's members and pins over its range.
#pragma once

#include <filesystem>
#include <vector>

#include "lake/linkage/statics.h"

namespace lake::figure {

struct PinForcesRow {
  double stroke_mm = 0, knee_deg = 0;
  linkage::MemberForces forces;  // NaN where no torque is known
};

// PNG or SVG by the extension. Above along the members, push positive; below what the pins bear; over the knee angle.
// Near a dead point forces have no bound: the axes show five times the least that the largest pin force is. Throws
// Error if it cannot be drawn.
void DrawPinForces(const std::filesystem::path& path, const std::vector<PinForcesRow>& rows);

}  // namespace lake::figure
