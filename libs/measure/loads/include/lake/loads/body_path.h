// A person's body over a rise, as balance and moments at another pace ask for it: the segments, where the trunk's
// centre of mass is from the hip, and from when on the feet alone bear it. The mean of a trial's rises.
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <vector>

#include "lake/core/json.h"
#include "lake/loads/leg_dynamics.h"

namespace lake::loads {

// At one percent; leg axes (x the way the subject faces, y up). NaN where the markers do not show it.
struct TrunkSample {
  double tilt_rad = std::numeric_limits<double>::quiet_NaN();  // from the vertical, positive leaning forward
  Eigen::Vector2d centre_m = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());  // from the hip
};

// What a person has beside the own body, on this leg.
struct Aids {
  double device_kg = 0;  // an exoskeleton's mass: half moves with the shank, half with the thigh, spread as theirs is
  double hold_n = 0;     // upward on the trunk's centre: arm rests, a helper, a harness
};

struct BodyPath {
  LegBody body;
  Aids aids;
  std::vector<TrunkSample> trunk;  // at 0, 1, … 100 %
  int feet_from_percent = 0;       // the seat bears a part until then
};

// As loads.json has it under "body_path"; lengths in mm, angles in degrees.
Json BodyPathJson(const BodyPath& path);

// loads.json, or the folder of lake-loads with it. Throws Error naming the file where it has no body, or where the
// trunk is not known over the whole rise.
BodyPath ReadBodyPath(const std::filesystem::path& path);

// The centre of mass of a segment and its tilt at one moment, from the ankle.
template <typename T>
struct SegmentPose {
  T x_m, y_m, tilt_rad;
};

// Shank, thigh, trunk.
template <typename T>
using BodyPose = std::array<SegmentPose<T>, 3>;

// What has to act on a body from outside: its vertical force, and its moment about a point, counter-clockwise.
template <typename T>
struct Support {
  T force_n, moment_nm;
};

// On the segments from `first` on (0: the shank), of poses at equal steps of time, at the middle one:
//   F = Σ m (ÿ + g)        M = Σ m [(ÿ + g) (x − x_p) − ẍ (y − y_p)] − I tilt¨
// with central differences for accelerations; less what holds the trunk.
template <typename T>
Support<T> FindSupport(const std::array<BodyPose<T>, 3>& poses, const T& step_s, const BodyPath& path,
                       std::size_t first, double about_x_m, double about_y_m) {
  const std::array<const SegmentInertia*, 3> inertias = {&path.body.shank, &path.body.thigh, &path.body.trunk};
  const std::array<double, 3> device_kg = {path.aids.device_kg / 2, path.aids.device_kg / 2, 0};
  const T per_square = 1.0 / (step_s * step_s);
  const auto acceleration = [&](std::size_t segment, T SegmentPose<T>::*member) {
    return (poses[0][segment].*member + poses[2][segment].*member - poses[1][segment].*member * 2.0) * per_square;
  };
  Support<T> support{T(), T()};
  for (std::size_t i = first; i < inertias.size(); ++i) {
    const SegmentPose<T>& pose = poses[1][i];
    const double mass_kg = inertias[i]->mass_kg + device_kg[i],
                 inertia = mass_kg * inertias[i]->gyration_m * inertias[i]->gyration_m;
    const T up = acceleration(i, &SegmentPose<T>::y_m) + kGravity_m_s2;
    support.force_n += up * mass_kg;
    support.moment_nm +=
        (up * (pose.x_m - about_x_m) - acceleration(i, &SegmentPose<T>::x_m) * (pose.y_m - about_y_m)) * mass_kg -
        acceleration(i, &SegmentPose<T>::tilt_rad) * inertia;
  }
  support.force_n = support.force_n - path.aids.hold_n;
  support.moment_nm = support.moment_nm - (poses[1][2].x_m - about_x_m) * path.aids.hold_n;
  return support;
}

// Of the ground on the foot, about the point under the ankle. The centre of pressure is moment / force before the
// ankle.
template <typename T>
Support<T> FindGroundSupport(const std::array<BodyPose<T>, 3>& poses, const T& step_s, const BodyPath& path) {
  const LegBody& body = path.body;
  Support<T> support = FindSupport(poses, step_s, path, 0, 0, -body.ankle_height_m);
  const double foot_n = body.foot.mass_kg * kGravity_m_s2;
  support.force_n = support.force_n + foot_n;
  support.moment_nm = support.moment_nm + foot_n * body.foot.centre_m;
  return support;
}

}  // namespace lake::loads
