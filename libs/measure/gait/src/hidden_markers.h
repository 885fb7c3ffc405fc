// A hidden marker of the leg between those that are seen. Not part of the interface.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "lake/dynamics/path_smoother.h"
#include "marker_curves.h"

namespace lake::gait {

// Where a marker is not seen between frames in which it is, its path keeps the distances to its neighbours in the leg:
// a distance is the segment's mean length and a slow change whose size and speed are those of the frames in which both
// ends are seen. A joint between two seen neighbours lies on the side to which it bends in the other frames.
void BridgeHiddenMarkers(std::span<const dynamics::SeenPath> seen, std::span<const dynamics::PathModel> models,
                         const dynamics::MotionPrior& prior, std::array<MarkerCurve, kLegMarkers>& curves);

}  // namespace lake::gait
