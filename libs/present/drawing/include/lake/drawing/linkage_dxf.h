// The link plates as a drawing for a cutter: DXF R12/2000, 1:1 in mm.
#pragma once

#include <filesystem>

#include "lake/linkage/linkage.h"

namespace lake::drawing {

struct PlateOptions {
  double bar_width_mm = 24;    // of all plates, rounded about their pins (the paper: all links of one width)
  double pin_diameter_mm = 8;  // of the holes
  double gap_mm = 15;          // between plates on the sheet

  void Check() const;  // throws Error
};

// Plates of the coupler l1, the slewing bar l2, the shank link l4, and the thigh plate that joins K, P and M and so
// holds l3, l5 and l6. Layers: OUTLINE (closed, lines and arcs), HOLES, LABELS.
void WriteLinkPlates(const std::filesystem::path& path, const linkage::Links& links, const PlateOptions& options = {});

}  // namespace lake::drawing
