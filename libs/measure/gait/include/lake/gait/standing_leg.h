// Which way is up, from a leg that stands.
#pragma once

#include "lake/gait/leg_angles.h"
#include "lake/gait/leg_view.h"
#include "lake/motion/marker_recording.h"

namespace lake::gait {

// The mean direction from ankle to hip, in the plane, over the frames in which the knee is straightest. A person stands
// with the hip over the ankle to within some three degrees (the leg leans forward by about that); knee angles do not
// depend on it. Throws Error where the knee never comes within 25° of straight, or a marker of the leg is absent.
Eigen::Vector2d UpFromStandingLeg(const motion::MarkerRecording& recording, const LegView& view,
                                  const LegMarkers& names = {});

}  // namespace lake::gait
