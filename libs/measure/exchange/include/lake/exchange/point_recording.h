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

namespace lake::exchange {

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

// The axes of a Tracker project in the image.
struct ImageAxes {
  Eigen::Vector2d origin_px = Eigen::Vector2d::Zero();  // image frame
  double angle_deg = 0;                                 // from the image's right to x, counter-clockwise as seen
};

// The video that the image points belong to, for programs that open both.
struct SourceVideo {
  std::string file;
  int width_px = 0, height_px = 0;
};

// An event of the file, e.g. "Foot Strike" in the context "Left".
struct PointEvent {
  double time_s = 0;
  std::string context, label;
};

// What a model worked out from the markers, as the flexion of a knee: three components in each frame, the first of an
// angle about the joint's own axis as a rule.
struct ModelOutput : PointTrack {
  std::string kind, unit;  // "angle", "deg"; the unit is empty where the file does not say it
};

struct PointRecording {
  PointSpace space = PointSpace::kSpace;
  char up_axis = 'y';               // of kSpace: x, y or z
  std::vector<std::int64_t> frame;  // from 0
  std::vector<double> time_s;       // increasing
  std::vector<PointTrack> points;
  std::vector<PointEvent> events;    // only C3D has them
  std::vector<ModelOutput> outputs;  // likewise
  std::optional<double> mm_per_px;   // of kImage, if the file has a scale
  std::optional<ImageAxes> axes;     // of kImage, if the file has its own; else x right, y up from the top-left pixel
  std::optional<SourceVideo> video;
  std::vector<std::string> warnings;  // oddities of the file, one line each

  const PointTrack* Find(std::string_view name) const;
};

// Detected and filled samples become points; missing ones stay missing.
PointRecording PointsFromMarkers(const motion::MarkerRecording& markers);

// The other way, for points in a plane (kImage, kPlane); sigma 0, as files do not say. Throws Error for kSpace.
motion::MarkerRecording MarkersFromPoints(const PointRecording& points);

// Points of an image with a scale, in mm along the file's axes; others as they are.
PointRecording PointsInPlane(const PointRecording& points);

// Points in space, turned so that `up` is the vertical: y and z change places about x, x comes by turning all three.
PointRecording PointsTurnedUp(PointRecording points, char up);

// Adds points of these names, without positions yet. A name that stands more than once gets _2, _3, …, and the
// recording a warning; `where` is the place of the names in the file.
void AddPoints(std::vector<std::string> names, const std::string& where, PointRecording& recording);

// mm per unit of length by its name, in any case and number: "mm", "Meters"; nullopt for others.
std::optional<double> FindMmPerUnit(std::string_view unit);

// Average frame rate in Hz; 0 for fewer than two frames.
double FrameRate(const std::vector<double>& time_s);

}  // namespace lake::exchange
