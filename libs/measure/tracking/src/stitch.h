// Tracklets of one object put together where nothing else can be meant, so that all that was seen of it counts when it
// is named.
#pragma once

#include <vector>

#include "lake/tracking/marker_physics.h"
#include "lake/tracking/tracklet.h"

namespace lake::tracking {

// Joins a tracklet that ends to the one that begins within a quarter of a second where it must be by then, if it is
// the only one that does, of its size, and no other ends there.
std::vector<Tracklet> StitchPieces(std::vector<Tracklet> tracklets, const MarkerPhysics& physics);

}  // namespace lake::tracking
