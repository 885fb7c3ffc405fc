#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/drawing/linkage_figures.h"
#include "linkage_page.h"
#include "linkage_scene.h"

namespace lake::drawing {
namespace {

using Eigen::Vector2d;

std::string Symbol(int link) {
  return fmt::format("{{/:Italic l}}_{}", link);
}

// Writes a dimension beside the middle of a line, on its right (negative: left), clear of it at any slope.
void LabelLine(Scene& scene, const Vector2d& from, const Vector2d& to, double aside, const std::string& text,
               const char* colour) {
  const Vector2d along = (to - from).normalized(), out = aside * Vector2d(along.y(), -along.x());
  const double slope = out.x() / out.norm();
  scene.Label(0.5 * (from + to) + out, text, {colour, slope > 0.5 ? "left" : slope < -0.5 ? "right" : "center"});
}

// Wide enough for the leg in every pose of the range, so that pictures of one design compare.
SceneView WholeView(const LinkageLook& look) {
  const linkage::Body& body = look.body;
  const double reach = std::max(body.thigh.length_mm + body.thigh.proximal_radius_mm,
                                std::hypot(look.links.l5, look.links.l3 + look.links.l6) + 60);
  const double sole = body.shank.length_mm + body.ankle_height_mm;
  return {.left = -reach - 120,
          .right = std::max(0.75 * body.foot_length_mm, 0.4 * reach) + 30,
          .bottom = -std::max(sole, reach) - 20,
          .top = reach + 20};
}

// A square that holds the four-bar and its labels in every pose of the range.
SceneView FourBarView(const LinkageLook& look) {
  constexpr int kPoses = 40;
  Eigen::Array2d low(0, 0), high(0, 0);
  for (int i = 0; i <= kPoses; ++i) {
    const PosedLeg leg(
        linkage::RequirePose(look.links, look.range.stroke.lower_mm + look.range.stroke.Travel() * i / kPoses));
    const linkage::Pose& pose = leg.ThePose();
    for (const Vector2d& joint : {pose.thigh_pin, pose.tip, pose.shank_pin}) {
      low = low.min(leg.FromThigh(joint).array());
      high = high.max(leg.FromThigh(joint).array());
    }
  }
  const Eigen::Array2d centre = 0.5 * (low + high);
  const double half = 0.62 * (high - low).maxCoeff();
  return {centre.x() - half, centre.x() + half, centre.y() - half, centre.y() + half};
}

void LabelWhole(Scene& scene, const LinkageLook& look, const PosedLeg& leg) {
  const linkage::Pose& pose = leg.ThePose();
  const Vector2d thigh_pin = leg.FromThigh(pose.thigh_pin), mount = leg.FromThigh(pose.mount),
                 tip = leg.FromThigh(pose.tip);
  const Vector2d bend = leg.FromThigh({0, pose.mount.y()});
  const std::string l5 = fmt::format("{} = {:.2f} mm", Symbol(5), look.links.l5),
                    l6 = fmt::format("{} = {:.2f} mm", Symbol(6), look.links.l6);
  scene.Stroke({thigh_pin, bend, mount}, link_colour::kThigh, 1.5, "dashed");
  LabelLine(scene, thigh_pin, bend, 36, l6, link_text::kThigh);
  LabelLine(scene, mount, bend, -26, l5, link_text::kThigh);
  LabelLine(scene, mount, tip, 46, fmt::format("{{/:Italic d}} = {:.2f} mm", pose.stroke_mm), link_text::kCylinder);
  scene.Label(mount + (mount - bend).normalized() * 28, "M");
  if (std::abs(pose.theta_rad) < RadiansFromDegrees(8)) return;  // no room for an arc
  const double radius = 0.28 * look.body.thigh.length_mm, up = std::numbers::pi / 2;
  scene.Stroke({{0, 0}, {0, 1.5 * radius}}, "#888888", 1.5, "dashed");
  scene.Stroke(Arc({0, 0}, radius, up, up + pose.theta_rad), "#444444", 1.5);
  const double middle = up + 0.3 * pose.theta_rad;
  scene.Label(0.55 * radius * Vector2d(std::cos(middle), std::sin(middle)), "{/:Italic θ}", {.size = 14});
}

void LabelFourBar(Scene& scene, const LinkageLook& look, const PosedLeg& leg, double view_half_mm) {
  const linkage::Pose& pose = leg.ThePose();
  const Vector2d knee(0, 0), thigh_pin = leg.FromThigh(pose.thigh_pin), tip = leg.FromThigh(pose.tip);
  const Vector2d shank_pin = leg.FromThigh(pose.shank_pin);
  // Round the four-bar, whose outside is on the left this way; a bar that lies along the thigh plate has its label
  // beyond the plate.
  const double outside = -0.13 * view_half_mm;
  const bool along_thigh = pose.phi_rad < RadiansFromDegrees(50);
  const auto dimension = [&](const Vector2d& from, const Vector2d& to, int link, double length, const char* colour,
                             double aside) {
    LabelLine(scene, from, to, aside, fmt::format("{} = {:.2f} mm", Symbol(link), length), colour);
  };
  dimension(thigh_pin, knee, 3, look.links.l3, link_text::kThigh, outside);
  dimension(knee, shank_pin, 4, look.links.l4, link_text::kShank, outside);
  dimension(tip, thigh_pin, 2, look.links.l2, link_text::kBar, along_thigh ? 3 * outside : outside);
  dimension(shank_pin, tip, 1, look.links.l1, link_text::kCoupler, outside);
  const double away = 0.1 * view_half_mm;
  scene.Label(knee + away * Vector2d(1, 0.2), "K");
  scene.Label(shank_pin + away * Vector2d(0.8, -0.6), "S");
  scene.Label(thigh_pin + away * (leg.FromThigh({-0.95, 0.3})), "P");
  scene.Label(tip + away * (leg.FromThigh({0.95, -0.3})), "R");
}

}  // namespace

void DrawPosePage(figure::GnuplotFigure& figure, const LinkageLook& look, const linkage::Pose& pose) {
  const PosedLeg leg(pose);
  const linkage::Transmission transmission = linkage::TransmissionOf(look.links, pose);
  figure.Line(
      fmt::format("set label 101 '{{/:Italic θ}} = {:.1f}°     {{/:Italic d}} = {:.2f} mm' at screen 0.5,0.962 center "
                  "font ',17'",
                  DegreesFromRadians(pose.theta_rad), pose.stroke_mm));
  figure.Line(fmt::format(
      "set label 102 'moment arm {:.1f} mm/rad     force {:.0f} N for {:g} N m     transmission "
      "angle {:.1f}°     actuator angle {:.1f}°' at screen 0.5,0.918 center font ',12' textcolor rgb '#555555'",
      transmission.moment_arm_mm, linkage::ActuatorForce(transmission, look.knee_torque_nm), look.knee_torque_nm,
      DegreesFromRadians(transmission.transmission_rad), DegreesFromRadians(transmission.actuator_rad)));
  figure.Line("set multiplot");
  Scene scene(figure);
  const double d_min = look.range.stroke.lower_mm;
  DrawLeg(scene, leg, look.body);
  DrawLinkage(scene, leg, d_min, 6, 0.7);
  LabelWhole(scene, look, leg);
  scene.Draw(WholeView(look), {0.075, 0.085, 0.44, 0.80});
  figure.Line("unset label 101\nunset label 102");

  const SceneView near = FourBarView(look);
  const double half = 0.5 * (near.right - near.left);
  DrawLeg(scene, leg, look.body);
  DrawLinkage(scene, leg, d_min, 0.03 * half, 1.3);
  LabelFourBar(scene, look, leg, half);
  scene.Draw(near, {0.54, 0.085, 0.45, 0.80});
  figure.Line("unset multiplot");
}

void DrawLinkagePose(const std::filesystem::path& path, const LinkageLook& look, const linkage::Pose& pose) {
  figure::GnuplotFigure figure(kPosePageWidth_px, kPosePageHeight_px);
  DrawPosePage(figure, look, pose);
  figure.Write(path);
}

}  // namespace lake::drawing
