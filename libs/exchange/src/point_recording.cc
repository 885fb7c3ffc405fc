#include "lake/exchange/point_recording.h"

#include "lake/core/error.h"

namespace lake {

const PointTrack* PointRecording::Find(std::string_view name) const {
  for (const PointTrack& point : points)
    if (point.name == name) return &point;
  return nullptr;
}

PointRecording PointsFromMarkers(const MarkerRecording& markers) {
  PointRecording points;
  points.space = markers.unit == LengthUnit::kPx ? PointSpace::kImage : PointSpace::kPlane;
  points.frame = markers.frame, points.time_s = markers.time_s;
  for (const MarkerTrack& marker : markers.markers) {
    points.points.push_back({marker.name, {}});
    for (const MarkerSample& sample : marker.samples)
      points.points.back().positions.push_back(
          sample.IsKnown() ? Eigen::Vector3d(sample.position.x(), sample.position.y(), 0) : PointTrack::Missing());
  }
  return points;
}

MarkerRecording MarkersFromPoints(const PointRecording& points) {
  if (points.space == PointSpace::kSpace) throw Fail("points in three dimensions must be projected onto a plane first");
  MarkerRecording markers;
  markers.unit = points.space == PointSpace::kImage ? LengthUnit::kPx : LengthUnit::kMm;
  markers.frame = points.frame, markers.time_s = points.time_s;
  for (const PointTrack& point : points.points) {
    markers.markers.push_back({point.name, {}});
    for (const Eigen::Vector3d& position : point.positions) {
      MarkerSample sample;
      if (position.allFinite()) sample = {position.head<2>(), 0, SampleStatus::kDetected};
      markers.markers.back().samples.push_back(sample);
    }
  }
  return markers;
}

double FrameRate(const std::vector<double>& time_s) {
  return time_s.size() < 2 ? 0 : static_cast<double>(time_s.size() - 1) / (time_s.back() - time_s.front());
}

}  // namespace lake
