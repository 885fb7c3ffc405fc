#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/drawing/linkage_figures.h"
#include "linkage_scene.h"

namespace lake::drawing {
namespace {

using Eigen::Vector2d;

// From +y counter-clockwise, as the mirrored linkage counts, to counter-clockwise from +x, as arcs are drawn.
double HeadingOf(double from_y_rad) {
  return std::numbers::pi / 2 + from_y_rad;
}

// The subject faces right, as in all pictures: the thigh frame's x, posterior, is drawn to the left.
Vector2d Seen(const Vector2d& in_thigh) {
  return {-in_thigh.x(), in_thigh.y()};
}

struct Drawing {
  Scene& scene;
  double unit;  // mm; a fortieth of the picture

  void Stroke(const Vector2d& from, const Vector2d& to, const char* colour, double width) const {
    scene.Stroke({Seen(from), Seen(to)}, colour, width, "dashed");
  }
  void Link(const Vector2d& from, const Vector2d& to, const char* colour, double half_width = 0.35) const {
    scene.Fill(CapsulePath(Seen(from), Seen(to), half_width * unit, half_width * unit), colour);
  }
  // Pale, so that the lengths that are measured on it are seen.
  void ThighPlate(const linkage::Pose& pose) const {
    constexpr const char* kPale = "#D5E6F2";
    PlanePath plate = drawing::ThighPlate(pose, 0.9 * unit);
    for (Vector2d& point : plate) point = Seen(point);
    scene.Fill(plate, kPale);
    scene.Stroke(plate, link_colour::kThigh, 1.5);
  }
  // The name stands to the left of the line from `from` to `to` as it is seen (negative: to the right).
  void Name(const Vector2d& from, const Vector2d& to, const char* text, const char* colour, double aside = 1.3,
            double way = 0.5) const {
    const Vector2d along = (to - from).normalized();
    scene.Label(Seen(from + way * (to - from) + aside * unit * Vector2d(along.y(), -along.x())), text,
                {.colour = colour, .size = 15});
  }
  void Label(const Vector2d& at, const char* text, const LabelStyle& style) const {
    scene.Label(Seen(at), text, style);
  }
  // The name stands outside the arc, half its way along (aside: how many units; negative: inside).
  void Angle(const Vector2d& at, double from, double to, double radius, const char* text, double aside = 1.1,
             double way = 0.5) const {
    scene.Stroke(Arc(Seen(at), radius * unit, HeadingOf(from), HeadingOf(to)), "#444444", 1.5);
    const double heading = HeadingOf(from + way * (to - from));
    scene.Label(Seen(at) + (radius + aside) * unit * Vector2d(std::cos(heading), std::sin(heading)), text,
                {.size = 14, .box = false});
  }
};

void DrawBodies(const Drawing& drawing, const linkage::Pose& p) {
  const Vector2d bend(0, p.mount.y());
  drawing.ThighPlate(p);
  drawing.Stroke({0, -1.15 * p.shank_pin.norm()}, {0, bend.y() + 3 * drawing.unit}, "#666666", 1);
  drawing.Stroke(p.knee, p.thigh_pin, link_text::kThigh, 1.5);
  drawing.Stroke(p.thigh_pin, bend, link_text::kThigh, 1.5);
  drawing.Stroke(bend, p.mount, link_text::kThigh, 1.5);
  drawing.Stroke(p.thigh_pin, p.mount, "#666666", 1.5);
  drawing.Stroke(p.knee, p.tip, "#666666", 1.5);
  drawing.Link(p.knee, p.shank_pin, link_colour::kShank);
  drawing.Link(p.thigh_pin, p.tip, link_colour::kBar);
  drawing.Link(p.tip, p.shank_pin, link_colour::kCoupler);
  drawing.Link(p.mount, p.tip, link_colour::kPiston);
  const Vector2d along = p.tip - p.mount;
  drawing.Link(p.mount, p.mount + 0.6 * along, link_colour::kCylinder, 0.6);
  for (const Vector2d& pin : {p.knee, p.thigh_pin, p.tip, p.shank_pin, p.mount}) drawing.scene.Pin(Seen(pin), 1.3);
}

void NameAll(const Drawing& drawing, const linkage::Pose& p) {
  const Vector2d bend(0, p.mount.y());
  drawing.Name(p.tip, p.shank_pin, "{/:Italic l}_1", link_text::kCoupler, -1.3);
  drawing.Name(p.thigh_pin, p.tip, "{/:Italic l}_2", link_text::kBar, -1.2, 0.72);
  drawing.Name(p.thigh_pin, p.knee, "{/:Italic l}_3", link_text::kThigh);
  drawing.Name(p.knee, p.shank_pin, "{/:Italic l}_4", link_text::kShank, 1.2, 0.75);
  drawing.Name(bend, p.mount, "{/:Italic l}_5", link_text::kThigh, -1.2);
  drawing.Name(bend, p.thigh_pin, "{/:Italic l}_6", link_text::kThigh);
  drawing.Name(p.thigh_pin, p.mount, "{/:Italic l}_7", "#666666", 1.0, 0.35);
  drawing.Name(p.knee, p.tip, "{/:Italic l}_8", "#666666", 0.9, 0.72);
  drawing.Name(p.mount, p.tip, "{/:Italic d}", link_text::kCylinder, -1.6);
  drawing.Angle(p.thigh_pin, 0, p.alpha1_rad, 6, "{/:Italic α}_1");
  drawing.Angle(p.thigh_pin, p.alpha1_rad, p.phi_rad, 3, "{/:Italic α}_2");
  drawing.Angle(p.knee, 0, p.beta1_rad, 4.2, "{/:Italic β}_1", -1.2, 0.4);
  drawing.Angle(p.knee, p.beta1_rad, p.beta1_rad + p.beta2_rad, 1.9, "{/:Italic β}_2");
  drawing.Angle(p.knee, std::numbers::pi - p.theta_rad, std::numbers::pi, 2.8, "{/:Italic θ}");
  const double u = drawing.unit;
  const LabelStyle joint{.size = 15, .box = false};
  drawing.Label(p.knee + Vector2d(-1.6, 0) * u, "K", joint);
  drawing.Label(p.thigh_pin + Vector2d(-1.6, 0) * u, "P", joint);
  drawing.Label(p.tip + Vector2d(1.6, -0.4) * u, "R", joint);
  drawing.Label(p.shank_pin + Vector2d(0.6, -1.8) * u, "S", joint);
  drawing.Label(p.mount + Vector2d(1.7, 0.4) * u, "M", joint);
  drawing.Label(bend + Vector2d(0, 3.9) * u, "{/:Italic y}: to the hip",
                {.colour = "#666666", .size = 11, .box = false});
  drawing.Label({0.6 * u, -1.1 * p.shank_pin.norm()}, "{/:Italic x}: posterior, to the left",
                {.colour = "#666666", .align = "right", .size = 11, .box = false});
}

}  // namespace

void DrawLinkageSchematic(const std::filesystem::path& path, const linkage::Links& links, const linkage::Pose& pose) {
  const double bottom = std::min(-1.15 * links.l4, pose.shank_pin.y()), top = pose.mount.y();
  const double unit = (top - bottom) / 32;
  const double back = std::max({pose.mount.x(), pose.tip.x(), pose.shank_pin.x()});
  const SceneView view{.left = -back - 5 * unit, .right = 6 * unit, .bottom = bottom - 3 * unit, .top = top + 5 * unit};
  constexpr int kHeight_px = 900;
  figure::GnuplotFigure figure(static_cast<int>(kHeight_px * (view.right - view.left) / (view.top - view.bottom)),
                               kHeight_px);
  Scene scene(figure);
  const Drawing drawing{scene, unit};
  DrawBodies(drawing, pose);
  NameAll(drawing, pose);
  scene.Draw(view, {0.01, 0.01, 0.98, 0.98}, false);
  figure.Write(path);
}

}  // namespace lake::drawing
