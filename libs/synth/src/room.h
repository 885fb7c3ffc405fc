// The room behind the person: what does not move.
#pragma once

#include "lake/synth/marker_motion.h"
#include "layer.h"

namespace lake::synth {

// The whole picture before the point-spread. Furniture stands where the motion needs a seat.
Canvas PaintRoom(const SceneOptions& options, const View& view, const MarkerMotion& motion);

}  // namespace lake::synth
