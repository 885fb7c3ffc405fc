// comparison.json read back: what a re-optimisation starts from.
#pragma once

#include <filesystem>
#include <optional>

#include "lake/compare/knee_axes.h"
#include "lake/compare/misalignment.h"

namespace lake::compare {

// The means over the repetitions that were compared; leg frame, mm.
struct ComparedCurves {
  StsCurve human, exo;
  std::vector<bool> spike{};                            // per percent
  double noise_floor_mm = 0, noise_floor_relative = 0;  // RMS that noise alone would show
  std::optional<MarkerSight> exo_sight{};
  bool knee_is_functional = false;  // the axis of rotation, not the marker
  KneeAxes axes{};                  // empty in an older file, which does not say
  // Of the joint's place against the knee beneath the skin, along the worse axis; where it was seen.
  std::optional<double> joint_sd_mm{};
  gait::MovementKind movement = gait::MovementKind::kSitToStand;  // or kWalking; an older file has sit-to-stands
};

// `path`: the folder that lake-compare wrote, or its comparison.json. Throws Error naming the file: absent, not JSON,
// made by another version, a curve that is missing, of another length, not finite, or that contradicts another.
ComparedCurves ReadComparison(const std::filesystem::path& path);

// The same for a linkage, which is designed for rises; throws Error for another movement.
ComparedCurves ReadComparisonOfRises(const std::filesystem::path& path);

}  // namespace lake::compare
