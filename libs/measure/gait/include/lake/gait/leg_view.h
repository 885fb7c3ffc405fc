// How the plane in which the leg moves is seen: the link between its coordinates and what was recorded.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <map>
#include <optional>
#include <string>

#include "lake/camera/camera.h"
#include "lake/camera/homography.h"
#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/motion/marker_recording.h"

namespace lake::gait {

// How far a marker stands proud of the sagittal plane, towards the camera: "40", or "40±5" with its standard deviation.
struct MarkerDepth {
  double mm = 0;
  std::optional<double> sd_mm = {};  // as it was measured

  bool operator==(const MarkerDepth&) const = default;
};
using MarkerDepths = std::map<std::string, MarkerDepth>;

// --depth of all programs that read pictures.
Option& DescribeDepths(MarkerDepths& depths, OptionList& options);

// How a calibrated camera stands before its plane: what a marker's place has of its depth.
struct PlaneSight {
  Eigen::Vector3d camera_mm = Eigen::Vector3d::UnitZ();  // its centre, plane frame; z is its distance from the plane
  double turn_sd_rad = 0, distance_sd_mm = 0;            // of the plane, as calibrated; 0: not known
  MarkerDepths depths;                                   // that the markers' places are corrected by

  // By so many mm is a marker at this place off it for each mm that it stands proud.
  Eigen::Vector2d Slope(const Eigen::Vector2d& place) const { return (place - camera_mm.head<2>()) / camera_mm.z(); }
};

// Which of the plane's descriptions holds, best first:
// - camera and camera_from_plane: a calibrated plane, in mm; a marker's depth is how far it stands proud of it, towards
//   the camera;
// - homography: known points of the plane, in mm, without a known lens;
// - mm_per_px: a scale bar, in mm; the picture (without its lens distortion, if the camera is known) scaled, y flipped
//   up;
// - neither: the same with 1 px for 1 mm, in px.
// Where lengths are those of the picture, pixels that are not square count by their height: x is stretched by
// pixel_aspect.
// A recording in mm is in the plane already and is taken as it is.
struct LegView {
  std::optional<camera::Camera> camera;
  std::optional<camera::PlanePose> camera_from_plane;
  std::optional<camera::HomographyFit> homography;
  std::optional<double> mm_per_px;
  double pixel_aspect = 1;  // width over height of a pixel, as the recording's file says
  std::optional<camera::PlaneUncertainty> plane_uncertainty;
  MarkerDepths depths;             // 0 where not named
  bool recorded_in_plane = false;  // the recording is in mm: nothing to project

  double Depth(const std::string& marker) const;
};

// From a camera profile (if any), a scale (if any) and the depths. Throws Error for a scale that is not positive, or
// depths without a calibrated plane.
LegView MakeLegView(motion::LengthUnit recording_unit, const std::optional<camera::CameraProfile>& profile,
                    const std::optional<double>& mm_per_px = {}, const MarkerDepths& depths = {});

std::optional<MarkerDepth> DepthOf(const PlaneSight& sight, const std::string& marker);

// nullopt without a calibrated plane.
std::optional<PlaneSight> SightOf(const LegView& view);

// For summary.json under `kPlaneSight`, and back; nullopt where a summary has none. Throws Error naming the file.
inline constexpr const char* kPlaneSight = "plane_sight";
Json PlaneSightJson(const PlaneSight& sight);
std::optional<PlaneSight> PlaneSightIn(const Json& summary, const std::string& file);

// Of a recording in the plane: moves its markers to where they are at these depths; others are passed over. Throws
// UsageError where no sight is known.
void PutAtDepths(const MarkerDepths& depths, std::optional<PlaneSight>& sight, motion::MarkerRecording& recording);

// The unit of plane coordinates under this view.
motion::LengthUnit PlaneUnit(const LegView& view);

// Where a recorded point is in the plane frame: px become mm here, by camera::PlaneFromPixel where the plane is
// calibrated. Throws Error if it cannot be (a ray that misses the plane).
Eigen::Vector2d PlaneFromRecorded(const LegView& view, const Eigen::Vector2d& recorded, double depth_mm);

// The other way, for T = double or a ceres::Jet.
template <typename T>
Eigen::Matrix<T, 2, 1> RecordedFromPlane(const LegView& view, const Eigen::Matrix<T, 2, 1>& point, double depth_mm) {
  if (view.recorded_in_plane) return point;
  if (view.homography) {
    const Eigen::Matrix<T, 3, 1> image = (view.homography->plane_from_image.inverse()).template cast<T>() *
                                         Eigen::Matrix<T, 3, 1>(point.x(), point.y(), T(1));
    return {image.x() / image.z(), image.y() / image.z()};
  }
  if (!view.camera_from_plane && !view.camera) {
    const double scale = view.mm_per_px.value_or(1);
    return {point.x() / (scale * view.pixel_aspect), -point.y() / scale};
  }
  Eigen::Matrix<T, 3, 1> in_camera;
  if (view.camera_from_plane) {
    const Eigen::Matrix3d& r = view.camera_from_plane->linear();
    const Eigen::Vector3d offset = view.camera_from_plane->translation() + r.col(2) * depth_mm;
    for (int i = 0; i < 3; ++i) in_camera[i] = point.x() * r(i, 0) + point.y() * r(i, 1) + offset[i];
  } else {
    const double scale = view.mm_per_px.value_or(1);
    in_camera = {(point.x() / (scale * view.pixel_aspect) - view.camera->cx) / view.camera->fx,
                 (-point.y() / scale - view.camera->cy) / view.camera->fy, T(1)};
  }
  return camera::ProjectAny<T>(*view.camera, in_camera);
}

// How far a point of the plane moves per unit of its recorded position (mm per px): the root of the area ratio there.
double PlaneUnitsPerRecorded(const LegView& view, const Eigen::Vector2d& point_in_plane, double depth_mm);

// Both ends of a plumb line in the picture give the direction up in the plane; the end farther along `up_px` in the
// picture is the upper one. Throws Error if the ends are one point.
Eigen::Vector2d UpFromPlumbLine(const LegView& view, const Eigen::Vector2d& one_end_px,
                                const Eigen::Vector2d& other_end_px, const Eigen::Vector2d& up_px = {0, -1});

}  // namespace lake::gait

template <>
struct lake::OptionValue<lake::gait::MarkerDepth> {
  static constexpr const char* kType = "NUMBER";
  static lake::gait::MarkerDepth Parse(const std::string& text, const std::string& said);
  static std::string Format(const lake::gait::MarkerDepth& value);
};
