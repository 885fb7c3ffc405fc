// The figures of a synthesis study.
#pragma once

#include <filesystem>

#include "lake/synthesis/study.h"

namespace lake {

// Range against the change of each link, one panel per link; where it cannot be assembled is shaded, where it leaves
// the bounds or violates a requirement on the links dashed.
void DrawSensitivity(const Study& study, const std::filesystem::path& path);

// Range (and yield, if estimated) against the margin from both singularities.
void DrawMargins(const Study& study, const std::filesystem::path& path);

// Range and errors over Ipopt's iterations of the best start.
void DrawConvergence(const Study& study, const std::filesystem::path& path);

}  // namespace lake
