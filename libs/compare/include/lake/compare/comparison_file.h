// comparison.json read back: what a re-optimisation starts from.
#pragma once

#include <filesystem>

#include "lake/compare/misalignment.h"

namespace lake {

// The means over the repetitions that were compared; leg frame, mm.
struct ComparedCurves {
  StsCurve human, exo;
};

// `path`: the folder that lake-compare wrote, or its comparison.json. Throws Error naming the file: absent, not JSON,
// made by another version, a curve that is missing, of another length, not finite, or that contradicts another.
ComparedCurves ReadComparison(const std::filesystem::path& path);

}  // namespace lake
