#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/drawing/linkage_figures.h"
#include "linkage_scene.h"

namespace lake::drawing {
namespace {

using Eigen::Vector2d;

void DrawTrunk(Scene& scene, const Vector2d& hip, const person::Body& body) {
  constexpr const char* kSkin = "#F6E7DA";
  constexpr const char* kEdge = "#A07F60";
  const double depth = 0.5 * body.trunk_depth_mm;
  const Vector2d seat = hip + Vector2d(0, std::max(0.0, depth - body.thigh.proximal_radius_mm));  // as low as the thigh
  const Vector2d shoulder = hip + Vector2d(0, body.trunk_length_mm - depth),
                 neck = hip + Vector2d(0, body.trunk_length_mm);
  const double head = 0.5 * body.head_height_mm;
  PlanePath face = Circle({0, 0}, head);
  for (Vector2d& point : face) point = neck + Vector2d(0.8 * point.x(), point.y() + body.neck_length_mm + head);
  const std::vector<PlanePath> shapes{
      CapsulePath(seat, shoulder, depth, depth),
      CapsulePath(neck, neck + Vector2d(0, body.neck_length_mm), 0.45 * head, 0.45 * head), face};
  for (const PlanePath& shape : shapes) scene.Stroke(shape, kEdge, 3);
  for (const PlanePath& shape : shapes) scene.Fill(shape, kSkin);
}

void DrawSeat(Scene& scene, const LinkageLook& look, const Vector2d& hip) {
  const double edge = look.wear.seat_edge_mm > 0 ? look.wear.seat_edge_mm : look.body.thigh.length_mm / 2;
  const double top = hip.y() - look.body.thigh.proximal_radius_mm, back = hip.x() - look.body.trunk_depth_mm;
  scene.Fill({{-edge, top}, {-edge, top - 70}, {back, top - 70}, {back, top}}, "#C9CED6");
}

void DrawBody(Scene& scene, const LinkageLook& look, const PosedLeg& leg) {
  DrawTrunk(scene, leg.FromThigh({0, look.body.thigh.length_mm}), look.body);
  DrawLeg(scene, leg, look.body);
  DrawLinkage(scene, leg, look.range.stroke.lower_mm, 0.5 * look.wear.bar_width_mm, 0.55);
}

void DrawPanel(Scene& scene, const LinkageLook& look, const PosedLeg& leg, double left_mm, const Scene::Place& place) {
  const person::Body& body = look.body;
  const double sole = -body.shank.length_mm - body.ankle_height_mm;
  const double floor = std::min(leg.FromShank({-0.25 * body.foot_length_mm, sole}).y(),  // heel
                                leg.FromShank({0.75 * body.foot_length_mm, sole}).y());  // toes
  scene.Stroke({{left_mm - 2000, floor}, {2000, floor}}, "#888888", 2);
  const double top = body.thigh.length_mm + body.trunk_length_mm + body.neck_length_mm + body.head_height_mm;
  scene.Draw({left_mm, left_mm + 0.64 * body.height_mm, sole - 0.04 * body.height_mm, top + 0.04 * body.height_mm},
             place, false);
}

std::string Finding(const char* what, double clearance_mm, const std::string& where) {
  return clearance_mm < 0 ? fmt::format("{} overlap by {:.1f} mm{}", what, -clearance_mm, where)
                          : fmt::format("{}: {:.1f} mm clear{}", what, clearance_mm, where);
}

std::vector<std::string> Findings(const linkage::WearCheck& check) {
  const auto at = [](double knee_deg) { return fmt::format(" at {:.1f}°", knee_deg); };
  std::vector<std::string> findings = {fmt::format("{} the leg, seen from the side:", linkage::NameOf(check.mount)),
                                       Finding("mount and hip", check.mount_below_hip_mm, "")};
  if (check.meets_seat) findings.push_back(Finding("linkage and seat", check.seat_clearance_mm, at(check.seated_deg)));
  if (check.meets_limbs) {
    findings.push_back(Finding("actuator and thigh", check.thigh_clearance_mm, at(check.thigh_clearance_deg)));
    findings.push_back(Finding("actuator and shank", check.shank_clearance_mm, at(check.shank_clearance_deg)));
  }
  return findings;
}

// A length of 200 mm to judge by.
void DrawScaleBar(Scene& scene, const Vector2d& from) {
  constexpr double kLength_mm = 200;
  scene.Stroke({from, from + Vector2d(kLength_mm, 0)}, colour::kText, 3);
  scene.Label(from + Vector2d(kLength_mm / 2, 32), fmt::format("{:.0f} mm", kLength_mm), {.box = false});
}

// The height of titles and findings, beside the head.
double TitleHeight(const person::Body& body) {
  return body.thigh.length_mm + body.trunk_length_mm + body.neck_length_mm + body.head_height_mm;
}

void DrawStanding(Scene& scene, const LinkageLook& look, const linkage::WearCheck& check) {
  const PosedLeg leg(
      linkage::PutOnBody(linkage::RequirePose(look.links, check.standing_stroke_mm), look.wear.placement_mm));
  DrawBody(scene, look, leg);
  constexpr double kHardlyBent_deg = 10;
  scene.Label({-0.29 * look.body.height_mm, TitleHeight(look.body)},
              fmt::format("{}, {:.1f}°", check.standing_deg < kHardlyBent_deg ? "standing" : "straightest",
                          std::abs(check.standing_deg)),
              {.align = "left", .size = 15, .box = false});
  DrawScaleBar(scene, {-0.29 * look.body.height_mm, 0});
  DrawPanel(scene, look, leg, -0.31 * look.body.height_mm, {0.06, 0.07, 0.44, 0.86});
}

void DrawSeated(Scene& scene, const LinkageLook& look, const linkage::WearCheck& check) {
  const linkage::Pose pose =
      linkage::PutOnBody(linkage::RequirePose(look.links, check.seated_stroke_mm), look.wear.placement_mm);
  const PosedLeg leg(pose, std::numbers::pi / 2 - pose.theta_rad);  // thigh level
  DrawSeat(scene, look, leg.FromThigh({0, look.body.thigh.length_mm}));
  DrawBody(scene, look, leg);
  Vector2d at(-0.33 * look.body.height_mm, TitleHeight(look.body));
  scene.Label(at, fmt::format("seated, {:.1f}°", check.seated_deg), {.align = "left", .size = 15, .box = false});
  for (const std::string& line : Findings(check)) {
    at.y() -= 0.031 * look.body.height_mm;
    scene.Label(at, line, {.align = "left", .size = 13, .box = false});
  }
  DrawPanel(scene, look, leg, -0.4 * look.body.height_mm, {0.55, 0.07, 0.44, 0.86});
}

}  // namespace

void DrawMannequin(const std::filesystem::path& path, const LinkageLook& look, const linkage::WearCheck& check) {
  figure::GnuplotFigure figure(1200, 1000);
  figure.Line(
      "set label 101 'Body of {:.0f} cm and {:.0f} kg; thigh {:.1f} mm, shank {:.1f} mm' at screen 0.5,0.97 center "
      "font ',16'\nset multiplot",
      look.body.height_mm / 10, look.body.mass_kg, look.body.thigh.length_mm, look.body.shank.length_mm);
  Scene scene(figure);
  DrawStanding(scene, look, check);
  figure.Line("unset label 101");
  DrawSeated(scene, look, check);
  figure.Line("unset multiplot");
  figure.Write(path);
}

}  // namespace lake::drawing
