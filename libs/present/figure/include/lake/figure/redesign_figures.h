// The figures of a redesign.
#pragma once

#include <filesystem>

#include "lake/redesign/redesign_outcome.h"

namespace lake::figure {

// The design before and after in the human's motion: knee paths in the leg frame, misalignment, knee angle and stroke
// over percent.
void DrawKneePaths(const redesign::RedesignOutcome& outcome, const std::filesystem::path& path);

// Where the ground's force acts within the foot over the rise at the program's pace, of the design before, after and,
// where balance was required, without that; how trunk and leg lean; the knee's moment. The body must be known.
void DrawBalance(const redesign::RedesignOutcome& outcome, const std::filesystem::path& path);

// Range against the least misalignment, a line per stroke program; the designs before and after, the limit.
void DrawPareto(const redesign::RedesignOutcome& outcome, const std::filesystem::path& path);

}  // namespace lake::figure
