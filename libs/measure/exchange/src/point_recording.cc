#include "lake/exchange/point_recording.h"

#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "lake/core/angles.h"
#include "lake/core/error.h"

namespace lake::exchange {

const PointTrack* PointRecording::Find(std::string_view name) const {
  for (const PointTrack& point : points)
    if (point.name == name) return &point;
  return nullptr;
}

PointRecording PointsFromMarkers(const motion::MarkerRecording& markers) {
  PointRecording points;
  points.space = markers.unit == motion::LengthUnit::kPx ? PointSpace::kImage : PointSpace::kPlane;
  points.frame = markers.frame;
  points.time_s = markers.time_s;
  for (const motion::MarkerTrack& marker : markers.markers) {
    points.points.push_back({marker.name, {}});
    for (const motion::MarkerSample& sample : marker.samples)
      points.points.back().positions.push_back(
          sample.IsKnown() ? Eigen::Vector3d(sample.position.x(), sample.position.y(), 0) : PointTrack::Missing());
  }
  return points;
}

motion::MarkerRecording MarkersFromPoints(const PointRecording& points) {
  if (points.space == PointSpace::kSpace) throw Fail("points in three dimensions must be projected onto a plane first");
  motion::MarkerRecording markers;
  markers.unit = points.space == PointSpace::kImage ? motion::LengthUnit::kPx : motion::LengthUnit::kMm;
  markers.frame = points.frame;
  markers.time_s = points.time_s;
  for (const PointTrack& point : points.points) {
    markers.markers.push_back({point.name, {}});
    for (const Eigen::Vector3d& position : point.positions) {
      motion::MarkerSample sample;
      if (position.allFinite()) sample = {position.head<2>(), 0, motion::SampleStatus::kDetected};
      markers.markers.back().samples.push_back(sample);
    }
  }
  return markers;
}

PointRecording PointsInPlane(const PointRecording& points) {
  if (points.space != PointSpace::kImage || !points.mm_per_px) return points;
  PointRecording plane = points;
  plane.space = PointSpace::kPlane;
  plane.mm_per_px.reset();
  plane.axes.reset();
  plane.video.reset();
  const ImageAxes axes = points.axes.value_or(ImageAxes{});
  const double angle_rad = RadiansFromDegrees(axes.angle_deg);
  const Eigen::Vector3d x(std::cos(angle_rad), -std::sin(angle_rad), 0),
      y(-std::sin(angle_rad), -std::cos(angle_rad), 0);
  const Eigen::Vector3d origin(axes.origin_px.x(), axes.origin_px.y(), 0);
  for (PointTrack& point : plane.points)
    for (Eigen::Vector3d& p : point.positions)
      if (p.allFinite()) p = *points.mm_per_px * Eigen::Vector3d(x.dot(p - origin), y.dot(p - origin), 0);
  return plane;
}

PointRecording PointsTurnedUp(PointRecording points, char up) {
  if (points.space != PointSpace::kSpace || points.up_axis == up) return points;
  const bool about_x = points.up_axis != 'x' && up != 'x';
  const int shift = (up - points.up_axis + 3) % 3;
  for (PointTrack& point : points.points)
    for (Eigen::Vector3d& p : point.positions) {
      const Eigen::Vector3d old = p;
      for (int axis = 0; axis < 3; ++axis) p[(axis + shift) % 3] = old[axis];
      if (about_x)
        p = up == 'y' ? Eigen::Vector3d(old.x(), old.z(), -old.y()) : Eigen::Vector3d(old.x(), -old.z(), old.y());
    }
  points.up_axis = up;
  return points;
}

void AddPoints(std::vector<std::string> names, const std::string& where, PointRecording& recording) {
  std::set<std::string> taken(names.begin(), names.end()), seen;
  std::vector<std::string> renamed;
  for (std::string& name : names) {
    const std::string given = name;
    const bool is_first = seen.insert(given).second;
    for (int copy = 2; !is_first && !taken.insert(name = fmt::format("{}_{}", given, copy)).second;) ++copy;
    if (!is_first) renamed.push_back(name);
    recording.points.push_back({std::move(name), {}});
  }
  if (!renamed.empty())
    recording.warnings.push_back(
        fmt::format("{}: some names stand twice; the later ones are called {}", where, fmt::join(renamed, ", ")));
}

std::optional<double> FindMmPerUnit(std::string_view unit) {
  static const std::map<std::string, double, std::less<>> kUnits = {
      {"um", 1e-3},   {"µm", 1e-3},       {"micrometer", 1e-3}, {"mm", 1},       {"millimeter", 1}, {"cm", 10},
      {"dm", 100},    {"decimeter", 100}, {"centimeter", 10},   {"m", 1000},     {"meter", 1000},   {"in", 25.4},
      {"inch", 25.4}, {"inche", 25.4},    {"ft", 304.8},        {"foot", 304.8}, {"feet", 304.8}};
  std::string name;
  for (const char c : unit)  // "(mm)"
    if (!std::isspace(static_cast<unsigned char>(c)) && std::string_view("()[].\"").find(c) == std::string_view::npos)
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (name.size() > 3 && name.back() == 's') name.pop_back();
  if (name.ends_with("metre")) name.replace(name.size() - 2, 2, "er");
  const auto found = kUnits.find(name);
  return found == kUnits.end() ? std::nullopt : std::optional(found->second);
}

double FrameRate(const std::vector<double>& time_s) {
  return time_s.size() < 2 ? 0 : static_cast<double>(time_s.size() - 1) / (time_s.back() - time_s.front());
}

}  // namespace lake::exchange
