#include "lake/gait/leg_view.h"

#include <cmath>

#include "lake/core/error.h"

namespace lake::gait {

double LegView::Depth(const std::string& marker) const {
  const auto found = depth_mm.find(marker);
  return found == depth_mm.end() ? 0 : found->second;
}

LegView MakeLegView(motion::LengthUnit recording_unit, const std::optional<camera::CameraProfile>& profile,
                    const std::optional<double>& mm_per_px, const std::map<std::string, double>& depth_mm) {
  LegView view;
  view.recorded_in_plane = recording_unit == motion::LengthUnit::kMm;
  if (view.recorded_in_plane) return view;
  if (profile) {
    view.camera = profile->camera;
    view.camera_from_plane = profile->camera_from_plane;
  }
  if (mm_per_px && !(*mm_per_px > 0 && std::isfinite(*mm_per_px)))
    throw Fail("scale: {} mm per px is not a positive number", *mm_per_px);
  if (!view.camera_from_plane) view.mm_per_px = mm_per_px;
  if (!depth_mm.empty() && !view.camera_from_plane)
    throw Fail("depth of marker '{}': a depth needs a camera file with a calibrated plane (lake calibrate plane)",
               depth_mm.begin()->first);
  view.depth_mm = depth_mm;
  return view;
}

motion::LengthUnit PlaneUnit(const LegView& view) {
  const bool is_in_mm = view.recorded_in_plane || view.camera_from_plane || view.homography || view.mm_per_px;
  return is_in_mm ? motion::LengthUnit::kMm : motion::LengthUnit::kPx;
}

Eigen::Vector2d PlaneFromRecorded(const LegView& view, const Eigen::Vector2d& recorded, double depth_mm) {
  if (view.recorded_in_plane) return recorded;
  if (view.homography) return camera::ApplyHomography(*view.homography, recorded);
  if (view.camera_from_plane) return camera::PlaneFromPixel(*view.camera, *view.camera_from_plane, recorded, depth_mm);
  Eigen::Vector2d pixel = recorded;
  if (view.camera) {
    const Eigen::Vector3d ray = camera::RayFromPixel(*view.camera, recorded);
    pixel = {ray.x() * view.camera->fx + view.camera->cx, ray.y() * view.camera->fy + view.camera->cy};
  }
  const double scale = view.mm_per_px.value_or(1);
  return {pixel.x() * scale * view.pixel_aspect, -pixel.y() * scale};
}

double PlaneUnitsPerRecorded(const LegView& view, const Eigen::Vector2d& point_in_plane, double depth_mm) {
  constexpr double kStep = 0.5;  // central difference over one unit; the projection is smooth over hundreds of them
  Eigen::Matrix2d recorded_per_plane;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(i);
    recorded_per_plane.col(i) = RecordedFromPlane<double>(view, point_in_plane + step, depth_mm) -
                                RecordedFromPlane<double>(view, point_in_plane - step, depth_mm);
  }
  return 1 / std::sqrt(std::abs(recorded_per_plane.determinant()));
}

Eigen::Vector2d UpFromPlumbLine(const LegView& view, const Eigen::Vector2d& one_end_px,
                                const Eigen::Vector2d& other_end_px, const Eigen::Vector2d& up_px) {
  const bool one_is_upper = (one_end_px - other_end_px).dot(up_px) > 0;
  const Eigen::Vector2d upper = PlaneFromRecorded(view, one_is_upper ? one_end_px : other_end_px, 0);
  const Eigen::Vector2d lower = PlaneFromRecorded(view, one_is_upper ? other_end_px : one_end_px, 0);
  const Eigen::Vector2d up = upper - lower;
  if (!(up.norm() > 0))
    throw Fail("vertical: both ends of the plumb line are ({}, {})", one_end_px.x(), one_end_px.y());
  return up.normalized();
}

}  // namespace lake::gait
