// A rolling shutter reads the picture row by row: what is seen in another row is seen at another time.
#pragma once

#include <Eigen/Core>

#include "lake/motion/marker_recording.h"

namespace lake::gait {

// When what is at a place in the picture is read, against its frame's time stamp, which is the picture's middle's:
// delay = readout · (along · place − 1/2).
struct RollingShutter {
  double readout_s = 0;
  Eigen::Vector2d along = Eigen::Vector2d::Zero();  // per px; the sensor's rows run across it

  double DelayS(const Eigen::Vector2d& place_px) const { return readout_s * (along.dot(place_px) - 0.5); }
};

// Of a picture as it is shown: turned by `rotation_deg` clockwise from how it was read, then perhaps mirrored.
RollingShutter ShutterOf(double readout_s, int width_px, int height_px, int rotation_deg, bool mirrored);

// Every detected position moved to its frame's own time, by the velocity and the acceleration of the marker's smoothed
// path. Sigmas stay: these are known well enough. Without a readout the recording itself.
motion::MarkerRecording AtFrameTimes(const motion::MarkerRecording& recording, const RollingShutter& shutter);

}  // namespace lake::gait
