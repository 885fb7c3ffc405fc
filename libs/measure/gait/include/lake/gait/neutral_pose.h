// Quiet standing: the pose that a person's angles are relative to.
#pragma once

#include "lake/gait/leg_fit.h"

namespace lake::gait {

// The means of all angles over the frames from one time to another; their standard deviations are the person's sway
// there, with the markers' noise of a frame. Throws Error: fewer than eight frames show the knee there, its angle or
// the shank's sways by more than 3° (SD), or the knee is bent by more than 30°: nobody stands quietly there.
motion::LegSample NeutralPose(const LegFitResult& leg, double from_s, double to_s);

}  // namespace lake::gait
