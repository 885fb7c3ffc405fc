#include "force_plates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/exchange/formats.h"

namespace lake::commands {
namespace {

using Eigen::Vector3d;

// Where a plate's force acts at the height of the point that its moment is about, on average, weighted by the force.
std::optional<Vector3d> MeanPoint(const exchange::PlateForces& plate, const Vector3d& up) {
  constexpr double kLeast_n = 20;
  Vector3d sum = Vector3d::Zero();
  double weight = 0;
  for (std::size_t i = 0; i < plate.force_n.size(); ++i) {
    const double force_n = plate.force_n[i].dot(up);
    if (force_n < kLeast_n) continue;
    sum += force_n * plate.point_m[i] + up.cross(plate.moment_nm[i]);
    weight += force_n;
  }
  return weight > 0 ? std::optional<Vector3d>(sum / weight) : std::nullopt;
}

Vector3d MeanAnkle(const exchange::PointRecording& points) {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (const Vector3d& position : points.Find("ankle")->positions)
    if (position.allFinite()) {
      sum += position / kMmPerM;
      ++count;
    }
  return sum / std::max(count, 1);
}

}  // namespace

Vector3d VerticalOf(const exchange::GroundForceRecording& forces, const exchange::Trial& trial,
                    const std::filesystem::path& path) {
  Vector3d up = Vector3d::Unit(forces.up_axis - 'x');
  if (trial.plane_from_space && Vector3d(trial.plane_from_space->row(1)) != up)
    throw Fail("{}: its vertical is {}, and that of the markers is another: give both in the same axes", path.string(),
               forces.up_axis);
  return up;
}

void WarnOfSwappedPlates(const exchange::GroundForceRecording& forces, const exchange::PlateForces& plate,
                         const std::string& leg, const exchange::Trial& trial, const exchange::TrialOptions& reading,
                         const std::string& way_out, Run& run) {
  if (!trial.plane_from_space) return;
  const Vector3d up = trial.plane_from_space->row(1);
  const Vector3d ankle_m =
      MeanAnkle(exchange::RenamePoints(exchange::ReadPoints(trial.file, reading.Reading()), reading.names, trial.file));
  const auto distance_mm = [&](const exchange::PlateForces& p) {
    const std::optional<Vector3d> point_m = MeanPoint(p, up);
    if (!point_m) return std::numeric_limits<double>::infinity();
    const Vector3d apart_m = *point_m - ankle_m;
    return kMmPerM * (apart_m - apart_m.dot(up) * up).norm();
  };
  constexpr double kFarthest_mm = 400;  // of a foot's own force from its ankle: a foot's length and more
  if (const double apart_mm = distance_mm(plate); apart_mm > kFarthest_mm && std::isfinite(apart_mm))
    run.Warn("the force of {} acts {:.0f} mm from the {} ankle: do plates and markers have the same axes and units?",
             plate.name, apart_mm, leg);
  const exchange::PlateForces* nearest = &plate;
  for (const exchange::PlateForces& other : forces.plates)
    if (distance_mm(other) < distance_mm(*nearest)) nearest = &other;
  if (nearest != &plate)
    run.Warn(
        "{} is taken for the {} foot, but its force acts {:.0f} mm from the ankle, that of {} {:.0f} mm: are the "
        "plates swapped? {}",
        plate.name, leg, distance_mm(plate), nearest->name, distance_mm(*nearest), way_out);
}

}  // namespace lake::commands
