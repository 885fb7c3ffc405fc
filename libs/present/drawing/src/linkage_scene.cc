#include "linkage_scene.h"

#include <algorithm>
#include <cmath>

#include "lake/parts/plate.h"

namespace lake::drawing {
namespace {

using Eigen::Vector2d;

Vector2d Turned(const Vector2d& point, double angle) {
  return {point.x() * std::cos(angle) - point.y() * std::sin(angle),
          point.x() * std::sin(angle) + point.y() * std::cos(angle)};
}

PlanePath FootOutline(const PosedLeg& leg, const person::Body& body) {
  const double ankle = -body.shank.length_mm, sole = ankle - body.ankle_height_mm, length = body.foot_length_mm;
  const double behind = -0.25 * length, before = 0.75 * length, radius = body.shank.distal_radius_mm;
  PlanePath outline;
  for (const Vector2d& corner : {Vector2d(-radius, ankle + 10), Vector2d(behind, ankle - 0.45 * body.ankle_height_mm),
                                 Vector2d(behind, sole), Vector2d(0.5 * (behind + before), sole),
                                 Vector2d(before, sole), Vector2d(before, sole + 0.4 * body.ankle_height_mm),
                                 Vector2d(1.6 * radius, ankle - 5), Vector2d(radius, ankle + 10)})
    outline.push_back(leg.FromShank(corner));
  return Rounded(outline);
}

}  // namespace

Vector2d PosedLeg::FromThigh(const Vector2d& p) const {
  return Turned({-p.x(), p.y()}, ThighTilt());
}
Vector2d PosedLeg::FromShank(const Vector2d& p) const {
  return Turned(p, shank_tilt_rad_);
}

std::vector<PlanePath> LegOutlines(const PosedLeg& leg, const person::Body& body) {
  const Vector2d hip = leg.FromThigh({0, body.thigh.length_mm}), ankle = leg.FromShank({0, -body.shank.length_mm});
  return {FootOutline(leg, body),
          CapsulePath({0, 0}, ankle, body.shank.proximal_radius_mm, body.shank.distal_radius_mm),
          CapsulePath(hip, {0, 0}, body.thigh.proximal_radius_mm, body.thigh.distal_radius_mm)};
}

void DrawLeg(Scene& scene, const PosedLeg& leg, const person::Body& body) {
  constexpr const char* kSkin = "#F6E7DA";
  constexpr const char* kEdge = "#A07F60";
  const std::vector<PlanePath> shapes = LegOutlines(leg, body);
  // All edges first, then all fills: the edges within the leg disappear.
  for (const PlanePath& shape : shapes) scene.Stroke(shape, kEdge, 3);
  for (const PlanePath& shape : shapes) scene.Fill(shape, kSkin);
}

PlanePath ThighPlate(const linkage::Pose& pose, double radius_mm) {
  parts::Plate plate;
  plate.corners = {pose.knee, pose.mount, pose.thigh_pin};
  plate.radius_mm = radius_mm;
  PlanePath outline;
  for (const parts::OutlinePiece& piece : parts::OutlineOf(plate)) {
    if (!piece.is_arc) continue;
    const PlanePath arc = Arc(piece.centre, radius_mm, piece.from_rad, piece.to_rad);
    outline.insert(outline.end(), arc.begin(), arc.end());
  }
  outline.push_back(outline.front());
  return outline;
}

void DrawLinkage(Scene& scene, const PosedLeg& leg, double d_min_mm, double half_width, double pin_size) {
  const linkage::Pose& pose = leg.ThePose();
  const Vector2d knee = leg.FromThigh(pose.knee), thigh_pin = leg.FromThigh(pose.thigh_pin),
                 tip = leg.FromThigh(pose.tip);
  const Vector2d shank_pin = leg.FromThigh(pose.shank_pin), mount = leg.FromThigh(pose.mount);
  const auto bar = [&](const Vector2d& from, const Vector2d& to, const char* colour, double width) {
    scene.Fill(CapsulePath(from, to, width, width), colour);
  };
  PlanePath plate = ThighPlate(pose, half_width);
  for (Vector2d& point : plate) point = leg.FromThigh(point);
  scene.Fill(plate, link_colour::kThigh);
  bar(knee, shank_pin, link_colour::kShank, half_width);
  bar(thigh_pin, tip, link_colour::kBar, half_width);
  bar(tip, shank_pin, link_colour::kCoupler, half_width);
  // The piston is drawn through: the cylinder covers what is inside.
  constexpr double kRodEnd = 0.12;  // of the shortest stroke: rod end that stays out of the cylinder
  const Vector2d along = (tip - mount).normalized();
  const double cylinder = std::min((1 - kRodEnd) * d_min_mm, (tip - mount).norm());
  bar(mount, tip, link_colour::kPiston, 0.55 * half_width);
  bar(mount, mount + cylinder * along, link_colour::kCylinder, kCylinderWidth * half_width);
  for (const Vector2d& pin : {knee, thigh_pin, tip, shank_pin, mount}) scene.Pin(pin, pin_size);
}

}  // namespace lake::drawing
