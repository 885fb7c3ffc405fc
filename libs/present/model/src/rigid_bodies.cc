#include "rigid_bodies.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/model/simulator_model.h"

namespace lake::model {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using parts::Body;

// The cylinder ends this much, of the shortest stroke, before the rod's pin.
constexpr double kRodEnd = 0.12;

std::string FileName(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

Eigen::Isometry3d Placed(const parts::Placement& placement) {
  Eigen::Isometry3d thigh_from_body = Eigen::Isometry3d::Identity();
  thigh_from_body.translation() << kMetresPerMillimetre * placement.at_mm, 0;
  thigh_from_body.linear() = Eigen::AngleAxisd(placement.turn_rad, Vector3d::UnitZ()).toRotationMatrix();
  return thigh_from_body;
}

std::vector<Vector2d> PolygonOf(const parts::Plate& plate) {
  constexpr int kPiecesPerTurn = 48;
  std::vector<Vector2d> polygon;
  for (const parts::OutlinePiece& piece : parts::OutlineOf(plate)) {
    if (!piece.is_arc) continue;
    const double turn = piece.to_rad - piece.from_rad;
    const int pieces = std::max(1, static_cast<int>(std::ceil(kPiecesPerTurn * turn / (2 * std::numbers::pi))));
    for (int i = 0; i <= pieces; ++i) {
      const double angle = piece.from_rad + turn * i / pieces;
      const Vector2d out = plate.radius_mm * Vector2d(std::cos(angle), std::sin(angle));
      polygon.push_back(kMetresPerMillimetre * (piece.centre + out));
    }
  }
  return polygon;
}

RigidBody PlateBody(const parts::Mechanism& mechanism, Body body, const linkage::Pose& pose) {
  const auto index = static_cast<std::size_t>(body);
  const parts::Plate& plate = mechanism.plates[index];
  const parts::Span& span = mechanism.stack.span[index];
  const parts::PlateMass mass = parts::MassOf(plate);
  RigidBody rigid;
  rigid.name = FileName(plate.name);
  rigid.thigh_from_body = Placed(parts::PlacementOf(body, pose));
  rigid.mass_kg = mass.mass_kg;
  rigid.centre_m = kMetresPerMillimetre * Vector3d(mass.centre_mm.x(), mass.centre_mm.y(), span.Middle());
  rigid.inertia_kg_m2 << mass.xx_kg_mm2, mass.xy_kg_mm2, 0, mass.xy_kg_mm2, mass.yy_kg_mm2, 0, 0, 0, mass.zz_kg_mm2;
  rigid.inertia_kg_m2 *= kMetresPerMillimetre * kMetresPerMillimetre;
  rigid.outline_m = PolygonOf(plate);
  rigid.low_m = kMetresPerMillimetre * span.from_mm;
  rigid.high_m = kMetresPerMillimetre * span.to_mm;
  return rigid;
}

RigidBody CylinderBody(const char* name, const parts::Placement& placement, double from_mm, double to_mm,
                       double diameter_mm, double z_mm, double mass_kg) {
  RigidBody rigid;
  rigid.name = name;
  rigid.thigh_from_body = Placed(placement);
  rigid.mass_kg = mass_kg;
  rigid.centre_m = kMetresPerMillimetre * Vector3d((from_mm + to_mm) / 2, 0, z_mm);
  rigid.cylinder_from_m = kMetresPerMillimetre * from_mm;
  rigid.cylinder_to_m = kMetresPerMillimetre * to_mm;
  rigid.cylinder_radius_m = kMetresPerMillimetre * diameter_mm / 2;
  const double r2 = rigid.cylinder_radius_m * rigid.cylinder_radius_m;
  const double length = rigid.cylinder_to_m - rigid.cylinder_from_m;
  const double across = mass_kg * (3 * r2 + length * length) / 12;
  rigid.inertia_kg_m2 = Vector3d(mass_kg * r2 / 2, across, across).asDiagonal();
  return rigid;
}

double RodMass_kg(double length_mm, double diameter_mm) {
  constexpr double kCubicMetresPerCubicMillimetre = 1e-9;
  return parts::kSteelDensity_kg_m3 * std::numbers::pi / 4 * diameter_mm * diameter_mm * length_mm *
         kCubicMetresPerCubicMillimetre;
}

}  // namespace

linkage::Pose ReferencePose(const parts::Mechanism& mechanism) {
  return linkage::RequirePose(mechanism.links, (mechanism.range.stroke.lower_mm + mechanism.range.stroke.upper_mm) / 2);
}

RigidBodies RigidBodiesOf(const parts::Mechanism& mechanism) {
  const linkage::Pose pose = ReferencePose(mechanism);
  const parts::PartOptions& options = mechanism.options;
  const double z_mm = mechanism.stack.span[static_cast<std::size_t>(Body::kActuator)].Middle();
  const double length_mm = (1 - kRodEnd) * mechanism.range.stroke.lower_mm;
  const parts::Placement mount = parts::PlacementOf(Body::kActuator, pose);
  const parts::Placement rod_end{pose.tip, mount.turn_rad};
  return {
      pose,
      {PlateBody(mechanism, Body::kThigh, pose), PlateBody(mechanism, Body::kShank, pose),
       PlateBody(mechanism, Body::kCoupler, pose), PlateBody(mechanism, Body::kBar, pose),
       CylinderBody("actuator_body", mount, 0, length_mm, options.actuator_diameter_mm, z_mm, options.actuator_mass_kg),
       CylinderBody("actuator_rod", rod_end, -length_mm, 0, options.rod_diameter_mm, z_mm,
                    RodMass_kg(length_mm, options.rod_diameter_mm))}};
}

Eigen::Matrix3d ModelFromThigh() {
  Eigen::Matrix3d model_from_thigh;
  model_from_thigh << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  return model_from_thigh;
}

}  // namespace lake::model
