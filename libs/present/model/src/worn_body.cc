#include "worn_body.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "lake/core/angles.h"

namespace lake::model {
namespace {

using Eigen::Vector2d;

// Where the trunk's centre of mass is in its own axes, m, mean over the rise.
Vector2d TrunkCentre(const loads::BodyPath& body) {
  Vector2d sum = Vector2d::Zero();
  for (const loads::TrunkSample& sample : body.trunk) sum += Eigen::Rotation2Dd(sample.tilt_rad) * sample.centre_m;
  return sum / static_cast<double>(body.trunk.size());
}

WornSegment SegmentOf(const char* name, const loads::SegmentInertia& inertia, const Vector2d& centre_m) {
  return {.name = name,
          .mass_kg = inertia.mass_kg,
          .inertia_kg_m2 = inertia.mass_kg * inertia.gyration_m * inertia.gyration_m,
          .centre_m = centre_m,
          .at_m = Vector2d::Zero()};
}

// On the shank the cuffs are free of stress in this pose; those of the thigh have all of the misfit.
std::vector<WornCuff> CuffsOf(const Subject& subject, double knee_deg) {
  const Vector2d on_thigh_mm = cuffs::MisfitOf(Vector2d::Zero(), subject.hinge_mm, subject.rise.back().knee_deg, 0);
  const Vector2d misfit_mm = cuffs::MisfitOf(subject.hinge_mm, on_thigh_mm, -knee_deg, 0);
  const Vector2d slip_mm = -cuffs::MisfitOf(Vector2d::Zero(), misfit_mm, knee_deg, 0);  // thigh's axes
  const double stiffness_n_mm = std::sqrt(subject.cuffs.softest_n_mm * subject.cuffs.stiffest_n_mm);
  std::vector<WornCuff> worn;
  for (const cuffs::PlacedCuff& cuff : cuffs::CuffsOf(subject.cuffs)) {
    worn.push_back(
        {.name = fmt::format("{}_cuff_{}", cuff.Segment(), cuff.number + 1),
         .on_thigh = cuff.on_thigh,
         .up_m = kMetresPerMillimetre * (cuff.on_thigh ? cuff.from_knee_mm : subject.shank_mm - cuff.from_knee_mm),
         .slip_m = cuff.on_thigh ? Vector2d(kMetresPerMillimetre * slip_mm) : Vector2d::Zero(),
         .stiffness_n_m = stiffness_n_mm / kMetresPerMillimetre,
         .turn_nm = stiffness_n_mm * cuff.length_mm * cuff.length_mm / 12 * kMetresPerMillimetre});
  }
  return worn;
}

}  // namespace

double WornSegment::LongInertia() const {
  constexpr double kAbout = 0.3;
  return kAbout * inertia_kg_m2;
}

WornBody WornBodyOf(const parts::Mechanism& mechanism, const Subject& subject) {
  cuffs::CheckCuffs(subject.cuffs);
  cuffs::CheckStiffnesses(subject.cuffs);
  const loads::LegBody& body = subject.body.body;
  const double shank_m = kMetresPerMillimetre * subject.shank_mm, thigh_m = kMetresPerMillimetre * subject.thigh_mm;
  WornBody worn{.mechanism = RigidBodiesOf(mechanism),
                .foot = SegmentOf("foot", body.foot, {body.foot.centre_m, -body.ankle_height_m / 2}),
                .shank = SegmentOf("shank", body.shank, {0, shank_m - body.shank.centre_m}),
                .thigh = SegmentOf("thigh", body.thigh, {0, thigh_m - body.thigh.centre_m}),
                .trunk = SegmentOf("trunk", body.trunk, TrunkCentre(subject.body)),
                .cuffs = {},
                .hinge_m = Vector2d(0, shank_m) + kMetresPerMillimetre * subject.hinge_mm};
  worn.knee_rad = worn.mechanism.reference.theta_rad;
  worn.cuffs = CuffsOf(subject, DegreesFromRadians(worn.knee_rad));
  worn.shank.length_m = shank_m;
  worn.shank.radius_m = 0.045;
  worn.thigh.length_m = thigh_m;
  worn.thigh.radius_m = 0.06;
  worn.trunk.length_m = 2 * body.trunk.centre_m;
  worn.trunk.radius_m = 0.1;
  worn.thigh.lean_rad = -worn.knee_rad;
  worn.thigh.at_m = Vector2d(0, shank_m);
  worn.trunk.at_m = worn.thigh.at_m + Eigen::Rotation2Dd(worn.knee_rad) * Vector2d(0, thigh_m);
  return worn;
}

double HipDeg(const WornSample& sample) {
  return sample.trunk_deg - (sample.shank_deg - sample.knee_deg);
}

}  // namespace lake::model
