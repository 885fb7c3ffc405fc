// The link plates as a drawing for a cutter: DXF R12/2000, 1:1 in mm.
#pragma once

#include <filesystem>

#include "lake/parts/mechanism.h"

namespace lake::drawing {

// Layers: OUTLINE and HOLES to cut (a closed polyline with arcs, and circles), ENGRAVING (each plate's name and
// thickness, on it), LABELS (what it is, beside it).
void WriteLinkPlates(const std::filesystem::path& path, const linkage::Links& links,
                     const parts::PartOptions& options = {});

}  // namespace lake::drawing
