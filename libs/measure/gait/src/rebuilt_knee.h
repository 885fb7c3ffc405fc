// The knee where its marker is hidden, from technical markers. Not part of the interface.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "detections.h"
#include "lake/gait/learnt_knee.h"

namespace lake::gait {

// Gives the leg's knee detections in the frames in which it is not seen. Where it is seen, seen and rebuilt places are
// compared; near such frames, and by their mean, the rebuilt ones are corrected. Throws Error where the technical
// markers are absent, exchanged or elsewhere than when the knee was learnt, or the flexion is never one that was.
RebuiltKnee RebuildKnee(const LearntKnee& learnt, const motion::MarkerRecording& recording, const LegView& view,
                        const LateralPlaces& lateral, const LegFitOptions& options,
                        std::array<Detections, kLegMarkers>& leg, std::vector<std::string>& warnings);

}  // namespace lake::gait
