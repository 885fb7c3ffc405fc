#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "label_places.h"
#include "lake/core/angles.h"
#include "lake/drawing/linkage_figures.h"
#include "linkage_page.h"
#include "linkage_scene.h"
#include "scene.h"

namespace lake::drawing {
namespace {

using Eigen::Vector2d;

// What a label belongs to: a point, and which way from it the label is to stand (length 1).
struct LabelSpot {
  Eigen::Vector2d at, outward;
};

struct LabelWish {
  std::string name;  // by which its place is found again
  std::vector<LabelSpot> spots;
  std::size_t letters;
};

class LabelRoom {
 public:
  // `scale`: mm per px of the scene's PNG, in which text is larger than in its SVG.
  LabelRoom(const SceneView& view, double scale) : view_(view), scale_(scale) {}

  // What labels must not cover; `weight` below 1: what they may where there is no other room.
  void Avoid(const PlanePath& path, double half_width_mm, double weight = 1);

  // The labels' centres. Those whose place in the picture before is free stay there; then the others go as near to one
  // of their spots, and to that place, as there is room, in steps of `gap_mm`. `places`: of the picture before, then
  // of this one.
  std::vector<Eigen::Vector2d> Place(const std::vector<LabelWish>& wishes, double gap_mm, LabelPlaces& places);

 private:
  struct Box {
    Eigen::Array2d low, high;
  };
  struct Line {
    Eigen::Vector2d from, to;
    double half_width_mm, weight;
  };

  Box BoxAt(const LabelWish& wish, double gap_mm, const LabelPlace& place) const;
  double Covered(const Box& label) const;
  // `before`: where it would stand if it stayed.
  LabelPlace BestPlace(const LabelWish& wish, double gap_mm, const std::optional<Box>& before) const;

  SceneView view_;
  double scale_;
  std::vector<Box> taken_;
  std::vector<Line> lines_;
};

using Eigen::Array2d, Eigen::Vector2d;

// Whether a part of the line lies between the bounds on both axes (Liang & Barsky 1984).
bool Crosses(const Vector2d& from, const Vector2d& to, const Array2d& low, const Array2d& high) {
  double begin = 0, end = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double along = to[axis] - from[axis];
    if (along == 0) {
      if (from[axis] < low[axis] || from[axis] > high[axis]) return false;
      continue;
    }
    const double a = (low[axis] - from[axis]) / along, b = (high[axis] - from[axis]) / along;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return begin <= end;
}

// Round a point, the first way first; on both sides of a line, beside its middle first (`side` 1: first on its right
// as one goes along it, -1: left).
std::vector<LabelSpot> RoundPoint(const Vector2d& at, const Vector2d& first) {
  constexpr int kWays = 16;  // 22.5° apart, at which a label's boxes still overlap: no room between them is missed
  const double heading = std::atan2(first.y(), first.x());
  std::vector<LabelSpot> spots;
  spots.reserve(kWays);
  for (int i = 0; i < kWays; ++i) {  // to both sides in turn, away from the first
    const int steps = (i + 1) / 2;
    const double turned = heading + (i % 2 ? steps : -steps) * 2 * std::numbers::pi / kWays;
    spots.push_back({at, {std::cos(turned), std::sin(turned)}});
  }
  return spots;
}

std::vector<LabelSpot> BesideLine(const Vector2d& from, const Vector2d& to, int side) {
  const Vector2d along = (to - from).normalized(), out = side * Vector2d(along.y(), -along.x());
  std::vector<LabelSpot> spots;
  for (const double tilt : {0.0, 1.0, -1.0})              // straight away from the line, or 45° to it
    for (const double way : {0.5, 0.35, 0.65, 0.2, 0.8})  // its middle first, never its ends, where joints are
      for (const int to_side : {1, -1})
        spots.push_back({from + way * (to - from), (to_side * out + tilt * along).normalized()});
  return spots;
}

void LabelRoom::Avoid(const PlanePath& path, double half_width_mm, double weight) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) lines_.push_back({path[i], path[i + 1], half_width_mm, weight});
}

LabelRoom::Box LabelRoom::BoxAt(const LabelWish& wish, double gap_mm, const LabelPlace& place) const {
  // Of 13 points in DejaVu Sans on their ground, as gnuplot draws them: "M" is 17 px wide, 13 letters are 135, 14 are
  // 146; they are 22 px high at most.
  constexpr double kLetter_px = 10.2, kAround_px = 8, kHeight_px = 24;
  const Array2d half = 0.5 * scale_ * Array2d(kLetter_px * static_cast<double>(wish.letters) + kAround_px, kHeight_px);
  const LabelSpot& spot = wish.spots[place.spot];
  const double reach = (spot.outward.array().abs() * half).sum() + gap_mm * (1 + place.steps);
  const Array2d centre = (spot.at + reach * spot.outward).array();
  return {centre - half, centre + half};
}

// 1: a line. Worse is a label over another one, as both are lost, and worst one that is cut off, even for two others.
double LabelRoom::Covered(const Box& label) const {
  constexpr double kLabel = 3, kOutside = 10;
  const bool is_within = label.low.x() >= view_.left && label.high.x() <= view_.right &&
                         label.low.y() >= view_.bottom && label.high.y() <= view_.top;
  double covered = is_within ? 0 : kOutside, lines = 0;
  for (const Box& other : taken_)
    if ((label.low < other.high).all() && (other.low < label.high).all()) covered += kLabel;
  for (const Line& line : lines_)
    if (Crosses(line.from, line.to, label.low - line.half_width_mm, label.high + line.half_width_mm))
      lines = std::max(lines, line.weight);
  return covered + lines;
}

LabelPlace LabelRoom::BestPlace(const LabelWish& wish, double gap_mm, const std::optional<Box>& before) const {
  // All steps and the longest way from the place before count less than a line: a label rather goes far than covers
  // one. What may be covered, such as the leg's edges, is covered where the way round it is a few steps.
  constexpr int kSteps = 16;
  constexpr double kStep = 0.02, kAcrossView = 0.6;
  const double view_mm = std::hypot(view_.right - view_.left, view_.top - view_.bottom);
  double least = std::numeric_limits<double>::infinity();
  LabelPlace best;
  for (int step = 0; step < kSteps; ++step)
    for (std::size_t spot = 0; spot < wish.spots.size(); ++spot) {
      const LabelPlace place{spot, step};
      const Box box = BoxAt(wish, gap_mm, place);
      const double moved_mm = before ? (box.low - before->low).matrix().norm() : 0;
      const double cost = Covered(box) + kStep * step + kAcrossView * moved_mm / view_mm;
      if (cost >= least) continue;
      least = cost;
      best = place;
    }
  return best;
}

std::vector<Vector2d> LabelRoom::Place(const std::vector<LabelWish>& wishes, double gap_mm, LabelPlaces& places) {
  constexpr double kFree = 1;  // below a line
  std::vector<std::optional<Box>> before(wishes.size()), boxes(wishes.size());
  for (std::size_t i = 0; i < wishes.size(); ++i) {
    const auto place = places.find(wishes[i].name);
    if (place == places.end()) continue;
    before[i] = BoxAt(wishes[i], gap_mm, place->second);
    if (Covered(*before[i]) >= kFree) continue;
    boxes[i] = before[i];
    taken_.push_back(*boxes[i]);
  }
  std::vector<Vector2d> centres;
  centres.reserve(wishes.size());
  for (std::size_t i = 0; i < wishes.size(); ++i) {
    if (!boxes[i]) {
      const LabelPlace place = BestPlace(wishes[i], gap_mm, before[i]);
      places[wishes[i].name] = place;
      boxes[i] = BoxAt(wishes[i], gap_mm, place);
      taken_.push_back(*boxes[i]);
    }
    centres.emplace_back(0.5 * (boxes[i]->low + boxes[i]->high));
  }
  return centres;
}

std::string Symbol(int link) {
  return fmt::format("{{/:Italic l}}_{}", link);
}

// A length beside its line, first on its right (`side` 1) or left (-1).
struct Dimension {
  Vector2d from, to;
  int side;
  std::string symbol;
  double length_mm;
  const char* colour;
};

// Letters beside their points and dimensions beside their lines: the first have the first choice of room.
class Labels {
 public:
  void Letter(const Vector2d& at, const Vector2d& first, const char* letter) {
    wishes_.push_back({letter, RoundPoint(at, first), 1});
    texts_.push_back({letter, {}});
  }
  void Length(const Dimension& d) {
    const std::string value = fmt::format(" = {:.2f} mm", d.length_mm);
    wishes_.push_back({d.symbol, BesideLine(d.from, d.to, d.side), 2 + value.size()});
    texts_.push_back({d.symbol + value, {.colour = d.colour}});
  }
  void Write(Scene& scene, LabelRoom& room, double gap_mm, LabelPlaces& places) const {
    const std::vector<Vector2d> centres = room.Place(wishes_, gap_mm, places);
    for (std::size_t i = 0; i < centres.size(); ++i) scene.Label(centres[i], texts_[i].text, texts_[i].style);
  }

 private:
  struct Text {
    std::string text;
    LabelStyle style;
  };

  std::vector<LabelWish> wishes_;
  std::vector<Text> texts_;
};

// The linkage, and the leg's edges where there is other room.
void AvoidMechanism(LabelRoom& room, const LinkageLook& look, const PosedLeg& leg, double half_width_mm) {
  constexpr double kEdgeWeight = 0.1;
  const linkage::Pose& pose = leg.ThePose();
  const Vector2d knee(0, 0), thigh_pin = leg.FromThigh(pose.thigh_pin), tip = leg.FromThigh(pose.tip);
  const Vector2d shank_pin = leg.FromThigh(pose.shank_pin), mount = leg.FromThigh(pose.mount);
  for (const double way : {0.0, 0.25, 0.5, 0.75, 1.0})  // all of the plate
    room.Avoid({mount, knee + way * (thigh_pin - knee)}, half_width_mm);
  room.Avoid({knee, shank_pin, tip, thigh_pin, knee}, half_width_mm);
  room.Avoid({mount, tip}, kCylinderWidth * half_width_mm);
  for (const PlanePath& outline : LegOutlines(leg, look.body)) room.Avoid(outline, 0, kEdgeWeight);
}

// Wide enough for the leg in every pose of the range, so that pictures of one design compare.
SceneView WholeView(const LinkageLook& look) {
  const person::Body& body = look.body;
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

void LabelWhole(Scene& scene, LabelRoom& room, const LinkageLook& look, const PosedLeg& leg, LabelPlaces& places) {
  constexpr double kGap_mm = 8;
  const linkage::Pose& pose = leg.ThePose();
  const Vector2d thigh_pin = leg.FromThigh(pose.thigh_pin), mount = leg.FromThigh(pose.mount),
                 tip = leg.FromThigh(pose.tip), bend = leg.FromThigh({0, pose.mount.y()});
  scene.Stroke({thigh_pin, bend, mount}, link_colour::kThigh, 1.5, "dashed");
  room.Avoid({thigh_pin, bend, mount}, 0);
  Labels labels;
  if (std::abs(pose.theta_rad) > RadiansFromDegrees(8)) {  // room for an arc
    const double radius = 0.28 * look.body.thigh.length_mm, up = std::numbers::pi / 2;
    const PlanePath zero{{0, 0}, {0, 1.5 * radius}}, arc = Arc({0, 0}, radius, up, up + pose.theta_rad);
    scene.Stroke(zero, "#888888", 1.5, "dashed");
    scene.Stroke(arc, "#444444", 1.5);
    room.Avoid(zero, 0);
    room.Avoid(arc, 0);
    const double middle = up + 0.3 * pose.theta_rad;
    const Vector2d out(std::cos(middle), std::sin(middle));
    labels.Letter(radius * out, -out, "{/:Italic θ}");
  }
  labels.Letter(mount, mount - bend, "M");
  labels.Length({mount, tip, 1, "{/:Italic d}", pose.stroke_mm, link_text::kCylinder});
  labels.Length({thigh_pin, bend, 1, Symbol(6), look.links.l6, link_text::kThigh});
  labels.Length({mount, bend, -1, Symbol(5), look.links.l5, link_text::kThigh});
  labels.Write(scene, room, kGap_mm, places);
}

void LabelFourBar(Scene& scene, LabelRoom& room, const LinkageLook& look, const PosedLeg& leg, double view_half_mm,
                  LabelPlaces& places) {
  const linkage::Pose& pose = leg.ThePose();
  const Vector2d knee(0, 0), thigh_pin = leg.FromThigh(pose.thigh_pin), tip = leg.FromThigh(pose.tip);
  const Vector2d shank_pin = leg.FromThigh(pose.shank_pin);
  Labels labels;
  labels.Letter(knee, {1, 0.2}, "K");
  labels.Letter(shank_pin, {0.8, -0.6}, "S");
  labels.Letter(thigh_pin, leg.FromThigh({-0.95, 0.3}), "P");
  labels.Letter(tip, leg.FromThigh({0.95, -0.3}), "R");
  // Round the four-bar, whose outside is on the left this way.
  labels.Length({thigh_pin, knee, -1, Symbol(3), look.links.l3, link_text::kThigh});
  labels.Length({knee, shank_pin, -1, Symbol(4), look.links.l4, link_text::kShank});
  labels.Length({tip, thigh_pin, -1, Symbol(2), look.links.l2, link_text::kBar});
  labels.Length({shank_pin, tip, -1, Symbol(1), look.links.l1, link_text::kCoupler});
  labels.Write(scene, room, 0.03 * view_half_mm, places);
}

// mm per px of a view that is drawn to one scale on both axes.
double ScaleOf(const SceneView& view, const Scene::Place& place) {
  return std::max((view.right - view.left) / (place.width * kPosePageWidth_px),
                  (view.top - view.bottom) / (place.height * kPosePageHeight_px));
}

}  // namespace

void DrawPosePage(figure::GnuplotFigure& figure, const LinkageLook& look, const linkage::Pose& pose,
                  LabelPlaces& labels) {
  const PosedLeg leg(pose);
  const linkage::Transmission transmission = linkage::TransmissionOf(look.links, pose);
  figure.Line(
      "set label 101 '{{/:Italic θ}} = {:.1f}°     {{/:Italic d}} = {:.2f} mm' at screen 0.5,0.962 center font ',17'",
      DegreesFromRadians(pose.theta_rad), pose.stroke_mm);
  figure.Line(
      "set label 102 'moment arm {:.1f} mm     force {:.0f} N for {:g} N m     transmission angle {:.1f}°     "
      "actuator angle {:.1f}°' at screen 0.5,0.918 center font ',12' textcolor rgb '#555555'",
      transmission.moment_arm_mm, linkage::ActuatorForce(transmission, look.knee_torque_nm), look.knee_torque_nm,
      DegreesFromRadians(transmission.transmission_rad), DegreesFromRadians(transmission.actuator_rad));
  figure.Line("set multiplot");
  Scene scene(figure);
  const double d_min = look.range.stroke.lower_mm;
  constexpr double kHalfWidth_mm = 6;
  constexpr Scene::Place kLeft = {0.075, 0.085, 0.44, 0.775}, kRight = {0.54, 0.085, 0.45, 0.775};
  const SceneView whole = WholeView(look), near = FourBarView(look);
  DrawLeg(scene, leg, look.body);
  DrawLinkage(scene, leg, d_min, kHalfWidth_mm, 0.7);
  LabelRoom whole_room(whole, ScaleOf(whole, kLeft));
  AvoidMechanism(whole_room, look, leg, kHalfWidth_mm);
  LabelWhole(scene, whole_room, look, leg, labels);
  scene.Draw(whole, kLeft);
  figure.Line("unset label 101\nunset label 102");

  const double half = 0.5 * (near.right - near.left), half_width = 0.03 * half;
  DrawLeg(scene, leg, look.body);
  DrawLinkage(scene, leg, d_min, half_width, 1.3);
  LabelRoom near_room(near, ScaleOf(near, kRight));
  AvoidMechanism(near_room, look, leg, half_width);
  LabelFourBar(scene, near_room, look, leg, half, labels);
  scene.Draw(near, kRight);
  figure.Line("unset multiplot");
}

void DrawLinkagePose(const std::filesystem::path& path, const LinkageLook& look, const linkage::Pose& pose) {
  LabelPlaces labels;
  DrawLinkagePose(path, look, pose, labels);
}

void DrawLinkagePose(const std::filesystem::path& path, const LinkageLook& look, const linkage::Pose& pose,
                     LabelPlaces& labels) {
  figure::GnuplotFigure figure(kPosePageWidth_px, kPosePageHeight_px);
  DrawPosePage(figure, look, pose, labels);
  figure.Write(path);
}

}  // namespace lake::drawing
