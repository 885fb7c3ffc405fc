// A marker's detections, as recorded and in the plane, and which of them are used. Not part of the interface.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "lake/gait/leg_view.h"
#include "lake/motion/marker_recording.h"
#include "leg_markers.h"

namespace lake::gait {

struct Detections {
  std::string name;
  const motion::MarkerTrack* track = nullptr;  // nullptr: the recording has no such marker
  double depth_mm = 0;
  std::vector<char> seen;     // 0 or 1 per frame
  std::vector<char> trusted;  // seen, and used
  std::vector<double> sigma;  // recorded unit; where it was given as 0, the estimate
  bool has_sigmas = true;     // of all detections
  std::vector<double> jump;   // recorded unit: how far off a smooth path a person's marker may be, noise apart
  std::vector<Eigen::Vector2d> in_plane;
  std::vector<double> plane_sigma;  // unit of the plane
  // Unit of the plane, per axis: of places that technical markers give where the marker is hidden (trusted, not seen),
  // what no frame's neighbours average away; NaN elsewhere, empty without any.
  std::vector<double> rebuilt_sd;
  std::vector<double> lateral;  // mm, normal to the plane, NaN where missing; empty for a trial of two dimensions

  bool IsRebuilt(std::size_t frame) const { return !rebuilt_sd.empty() && rebuilt_sd[frame] >= 0; }
};

// `skin` (recorded unit) is what a marker on skin may jump from frame to frame. Excursions of a few frames are not
// trusted. Throws Error for a sample that is not finite or lies where the camera cannot see it, naming marker and
// frame.
Detections CollectDetections(const motion::MarkerRecording& recording, const motion::MarkerTrack& track,
                             const LegView& view, double skin);

// Mistrusts detections in too few frames for a curve, and for less time than the marker is hidden before and after
// them. Not where most of a marker's samples are such.
void MistrustIsolated(Detections& detections, const std::vector<double>& time_s);

// In how many frames both are trusted.
std::size_t FramesTogether(const Detections& lower, const Detections& upper);

// Throws Error if ankle, knee and hip are not seen together often enough.
void CheckIsSeen(const std::array<Detections, kLegMarkers>& leg);

}  // namespace lake::gait
