// Walking askance to the camera's plane. Not part of the interface.
#pragma once

#include <optional>
#include <string>

#include "lake/gait/leg_fit.h"

namespace lake::gait {

// A sentence where shank and thigh, of a film or a plane's file, become longer or shorter along the way as those of a
// person do who comes nearer or goes away by 15 degrees and more: by how much, and what of the leans and of the knee's
// angle is lost. Without the camera's distance the angle is not known; then it is said of a change of 10 %.
std::optional<std::string> ObliqueWalk(const LegFitResult& leg);

}  // namespace lake::gait
