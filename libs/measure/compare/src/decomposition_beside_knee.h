// The parts of a misalignment where the joint's place against the knee of the leg that wears it is measured. The paths
// alone do not tell a joint beside the knee from a leg that leans otherwise: p is the measured place, and w is fitted
// to the knee angles θ, which do not depend on lean either:
//
//   min over w:  Σ (L (θ_e(s) − θ_h(w(s))))² + λ Σ (Δ² w_k)²,   L = length of the human's shank.
//
// Not part of the interface.
#pragma once

#include "lake/compare/decomposition.h"

namespace lake::compare {

// `joint_mm`: p, shank frame. Its `start` is "joint".
Decomposition DecomposeBesideKnee(const StsCurve& human, const StsCurve& exo, const Eigen::Vector2d& joint_mm,
                                  const DecompositionOptions& options);

}  // namespace lake::compare
