// Points of a recording as other programs' files hold them, in two or three dimensions.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/motion/marker_recording.h"

namespace lake {

enum class PointSpace {
  kImage,  // px, image frame: x right, y down, centre of the top-left pixel at (0, 0); z is 0
  kPlane,  // mm, x right, y up; z is 0
  kSpace,  // mm, three dimensions
};

struct PointTrack {
  static Eigen::Vector3d Missing() { return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()); }

  std::string name;
  std::vector<Eigen::Vector3d> positions;  // one per frame; NaN where missing
};

struct PointRecording {
  PointSpace space = PointSpace::kSpace;
  char up_axis = 'y';               // of kSpace: x, y or z
  std::vector<std::int64_t> frame;  // from 0
  std::vector<double> time_s;       // increasing
  std::vector<PointTrack> points;
  std::optional<double> mm_per_px;  // of kImage, if the file has a scale

  const PointTrack* Find(std::string_view name) const;
};

// Detected and filled samples become points; missing ones stay missing.
PointRecording PointsFromMarkers(const MarkerRecording& markers);

// The other way, for points in a plane (kImage, kPlane); sigma 0, as files do not say. Throws Error for kSpace.
MarkerRecording MarkersFromPoints(const PointRecording& points);

// Average frame rate in Hz; 0 for fewer than two frames.
double FrameRate(const std::vector<double>& time_s);

}  // namespace lake
