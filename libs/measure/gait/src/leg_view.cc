#include "lake/gait/leg_view.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "lake/core/error.h"

namespace lake::gait {

double LegView::Depth(const std::string& marker) const {
  const auto found = depths.find(marker);
  return found == depths.end() ? 0 : found->second.mm;
}

Option& DescribeDepths(MarkerDepths& depths, OptionList& options) {
  return options
      .Add("depth", depths,
           "How far a marker stands proud of the calibrated plane, towards the camera, with its standard deviation: "
           "exo_knee=40±5 (may be repeated)")
      .Unit("mm")
      .Value("NAME=MM±SD")
      .Repeats();
}

LegView MakeLegView(motion::LengthUnit recording_unit, const std::optional<camera::CameraProfile>& profile,
                    const std::optional<double>& mm_per_px, const MarkerDepths& depths) {
  LegView view;
  view.recorded_in_plane = recording_unit == motion::LengthUnit::kMm;
  if (view.recorded_in_plane) return view;
  if (profile) {
    view.camera = profile->camera;
    view.camera_from_plane = profile->camera_from_plane;
    view.plane_uncertainty = profile->plane_uncertainty;
  }
  if (mm_per_px && !(*mm_per_px > 0 && std::isfinite(*mm_per_px)))
    throw Fail("scale: {} mm per px is not a positive number", *mm_per_px);
  if (!view.camera_from_plane) view.mm_per_px = mm_per_px;
  if (!depths.empty() && !view.camera_from_plane)
    throw Fail("depth of marker '{}': a depth needs a camera file with a calibrated plane (lake calibrate plane)",
               depths.begin()->first);
  view.depths = depths;
  return view;
}

std::optional<PlaneSight> SightOf(const LegView& view) {
  if (!view.camera_from_plane || view.recorded_in_plane) return std::nullopt;
  PlaneSight sight{.camera_mm = view.camera_from_plane->inverse().translation(), .depths = view.depths};
  if (const auto& plane = view.plane_uncertainty) {
    sight.turn_sd_rad = plane->rotation_sd_rad.head<2>().norm() / std::sqrt(2.0);
    const Eigen::Vector3d normal = view.camera_from_plane->linear().col(2);
    sight.distance_sd_mm = normal.cwiseProduct(plane->translation_sd_mm).norm();
  }
  return sight;
}

std::optional<MarkerDepth> DepthOf(const PlaneSight& sight, const std::string& marker) {
  const auto found = sight.depths.find(marker);
  return found == sight.depths.end() ? std::nullopt : std::optional(found->second);
}

Json PlaneSightJson(const PlaneSight& sight) {
  Json depths = Json::object();
  for (const auto& [marker, depth] : sight.depths) depths[marker] = OptionValue<MarkerDepth>::Format(depth);
  return {{"camera_mm", {sight.camera_mm.x(), sight.camera_mm.y(), sight.camera_mm.z()}},
          {"turn_sd_rad", sight.turn_sd_rad},
          {"distance_sd_mm", sight.distance_sd_mm},
          {"depths_mm", depths}};
}

std::optional<PlaneSight> PlaneSightIn(const Json& summary, const std::string& file) {
  if (!summary.is_object() || !summary.contains(kPlaneSight)) return std::nullopt;
  try {
    const Json& json = summary[kPlaneSight];
    PlaneSight sight{.turn_sd_rad = json.at("turn_sd_rad"), .distance_sd_mm = json.at("distance_sd_mm"), .depths = {}};
    for (int i = 0; i < 3; ++i) sight.camera_mm[i] = json.at("camera_mm").at(static_cast<std::size_t>(i));
    for (const auto& [marker, depth] : json.at("depths_mm").items())
      sight.depths[marker] = OptionValue<MarkerDepth>::Parse(depth.get<std::string>(), marker);
    if (!(sight.camera_mm.z() > 0)) throw Error("the camera is not before the plane");
    return sight;
  } catch (const std::exception& error) {
    throw Fail("{}: '{}' is damaged ({}); track the video again", file, kPlaneSight, error.what());
  }
}

void PutAtDepths(const MarkerDepths& depths, std::optional<PlaneSight>& sight, motion::MarkerRecording& recording) {
  for (const auto& [name, depth] : depths) {
    const auto track = std::ranges::find(recording.markers, name, &motion::MarkerTrack::name);
    if (track == recording.markers.end()) continue;
    if (!sight)
      throw UsageError("--depth {}: where the camera stood is not known; give --depth to lake track, with --camera",
                       name);
    const double to_camera = sight->camera_mm.z(), before_mm = sight->depths[name].mm;
    const double nearer = (to_camera - depth.mm) / (to_camera - before_mm);
    for (motion::MarkerSample& sample : track->samples)
      if (sample.IsKnown())
        sample.position = sight->camera_mm.head<2>() + nearer * (sample.position - sight->camera_mm.head<2>());
    sight->depths[name] = depth;
  }
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

lake::gait::MarkerDepth lake::OptionValue<lake::gait::MarkerDepth>::Parse(const std::string& text,
                                                                          const std::string& said) {
  constexpr std::string_view kPlusMinus = "±";
  const std::size_t at = text.find(kPlusMinus);
  lake::gait::MarkerDepth depth{.mm = OptionValue<double>::Parse(text.substr(0, at), said)};
  if (at == std::string::npos) return depth;
  depth.sd_mm = OptionValue<double>::Parse(text.substr(at + kPlusMinus.size()), said);
  if (*depth.sd_mm < 0) throw UsageError("{}: the standard deviation of '{}' is negative", said, text);
  return depth;
}

std::string lake::OptionValue<lake::gait::MarkerDepth>::Format(const lake::gait::MarkerDepth& value) {
  return OptionValue<double>::Format(value.mm) + (value.sd_mm ? "±" + OptionValue<double>::Format(*value.sd_mm) : "");
}
