// Figures of a comparison, in the paper's colours.
#pragma once

#include <filesystem>

#include "lake/compare/misalignment.h"

namespace lake::figure {

// Both knee paths on the sagittal plane, lines between equal percents, the legs at 0, 50 and 100 %.
void DrawOverlayFigure(const std::filesystem::path& path, const compare::Misalignment& misalignment);

// The path difference over percent with spikes and, with several repetitions, the ± SD band; what it is made of; the
// knee angles.
void DrawMisalignmentFigure(const std::filesystem::path& path, const compare::Misalignment& misalignment);

}  // namespace lake::figure
