#include "stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "lake/core/angles.h"
#include "lake/core/cross.h"
#include "lake/core/numbers.h"

namespace lake::parts {
namespace {

using Eigen::Vector2d;

constexpr std::array<Body, kBodies> kAllBodies = {Body::kThigh, Body::kShank, Body::kCoupler, Body::kBar,
                                                  Body::kActuator};
constexpr std::array<Joint, kJoints> kAllJoints = {Joint::kKnee, Joint::kThighPin, Joint::kTip, Joint::kShankPin,
                                                   Joint::kMount};

std::size_t Index(Body body) {
  return static_cast<std::size_t>(body);
}
std::size_t Index(Joint joint) {
  return static_cast<std::size_t>(joint);
}

const std::vector<Body>& JoinedBy(Joint joint) {
  static const std::vector<Body> kJoined[] = {{Body::kThigh, Body::kShank},
                                              {Body::kThigh, Body::kBar},
                                              {Body::kCoupler, Body::kBar, Body::kActuator},
                                              {Body::kShank, Body::kCoupler},
                                              {Body::kThigh, Body::kActuator}};
  return kJoined[Index(joint)];
}

bool Joins(Joint joint, Body body) {
  const std::vector<Body>& joined = JoinedBy(joint);
  return std::find(joined.begin(), joined.end(), body) != joined.end();
}

// A convex polygon, or a segment, with a margin around it.
struct Shape {
  std::vector<Vector2d> corners;
  double radius = 0;
};

double PointToSegment(const Vector2d& point, const Vector2d& from, const Vector2d& to) {
  const Vector2d along = to - from;
  const double length2 = along.squaredNorm();
  const double part = length2 > 0 ? std::clamp((point - from).dot(along) / length2, 0.0, 1.0) : 0;
  return (point - (from + part * along)).norm();
}

bool Contains(const std::vector<Vector2d>& polygon, const Vector2d& point) {
  if (polygon.size() < 3) return false;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    if (Cross(polygon[(i + 1) % polygon.size()] - polygon[i], point - polygon[i]) < 0) return false;
  return true;
}

bool Cuts(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  return Cross(b - a, c - a) * Cross(b - a, d - a) < 0 && Cross(d - c, a - c) * Cross(d - c, b - c) < 0;
}

// Of the polygons without their margins; 0 where they overlap.
double PolygonDistance(const std::vector<Vector2d>& a, const std::vector<Vector2d>& b) {
  if (Contains(a, b.front()) || Contains(b, a.front())) return 0;
  double least = kInfinity;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) {
      const Vector2d &a0 = a[i], &a1 = a[(i + 1) % a.size()], &b0 = b[j], &b1 = b[(j + 1) % b.size()];
      if (Cuts(a0, a1, b0, b1)) return 0;
      least = std::min({least, PointToSegment(a0, b0, b1), PointToSegment(a1, b0, b1), PointToSegment(b0, a0, a1),
                        PointToSegment(b1, a0, a1)});
    }
  return least;
}

double ShapeDistance(const Shape& a, const Shape& b) {
  return PolygonDistance(a.corners, b.corners) - a.radius - b.radius;
}

Shape ShapeOf(const Mechanism& mechanism, Body body, const linkage::Pose& pose) {
  if (body == Body::kActuator) return {{pose.mount, pose.tip}, mechanism.options.actuator_diameter_mm / 2};
  const Plate& plate = mechanism.plates[Index(body)];
  const Placement thigh_from_part = PlacementOf(body, pose);
  Shape shape{{}, plate.radius_mm};
  for (const Vector2d& corner : plate.corners) shape.corners.push_back(thigh_from_part * corner);
  return shape;
}

// Around a pin where it crosses other layers there is a tube.
double TubeDiameter(const PartOptions& options) {
  constexpr double kTubeWall = 0.25;  // of the pin's diameter
  return (1 + 2 * kTubeWall) * options.pin_diameter_mm;
}

double CornerMotion(const Mechanism& mechanism, const linkage::Pose& from, const linkage::Pose& to) {
  double most = 0;
  for (const Body body : kAllBodies) {
    const Shape before = ShapeOf(mechanism, body, from), after = ShapeOf(mechanism, body, to);
    for (std::size_t i = 0; i < before.corners.size(); ++i)
      most = std::max(most, (after.corners[i] - before.corners[i]).norm());
  }
  return most;
}

// The knee angles at which two parts are too near to each other in the plane, if any.
struct Meeting {
  double least_deg = kInfinity, most_deg = -kInfinity;
  bool Happens() const { return least_deg <= most_deg; }
  void Take(double deg) {
    constexpr double kTenth = 0.1;                  // as it is reported
    deg = kTenth * std::round(deg / kTenth) + 0.0;  // no -0
    least_deg = std::min(least_deg, deg);
    most_deg = std::max(most_deg, deg);
  }
};

struct Meetings {
  std::array<std::array<Meeting, kBodies>, kBodies> bodies;
  std::array<std::array<Meeting, kBodies>, kJoints> pins;  // a pin and a body that is not on it
};

Meetings FindMeetings(const Mechanism& mechanism) {
  Meetings meetings;
  // Halfway between two poses each of two parts is at most half a step from where it was looked at.
  const double near_mm = mechanism.options.clearance_mm + kSweepStep_mm;
  for (const double stroke : SweepStrokes(mechanism)) {
    const linkage::Pose pose = linkage::RequirePose(mechanism.links, stroke);
    const double deg = DegreesFromRadians(pose.theta_rad);
    for (const Body body : kAllBodies) {
      for (const Body other : kAllBodies)
        if (body < other && DistanceBetween(mechanism, body, other, pose) < near_mm)
          meetings.bodies[Index(body)][Index(other)].Take(deg);
      for (const Joint joint : kAllJoints)
        if (!Joins(joint, body) && DistanceBetween(mechanism, joint, body, pose) < near_mm)
          meetings.pins[Index(joint)][Index(body)].Take(deg);
    }
  }
  return meetings;
}

using Layers = std::array<int, kBodies>;

// Lowest and highest layer that a pin reaches.
std::pair<int, int> ReachOf(Joint joint, const Layers& layers) {
  int low = static_cast<int>(kBodies), high = -1;
  for (const Body body : JoinedBy(joint)) {
    low = std::min(low, layers[Index(body)]);
    high = std::max(high, layers[Index(body)]);
  }
  return {low, high};
}

// Calls meet(text of what, Meeting) for all that this order does not keep apart.
template <typename Meet>
void ForEachConflict(const Meetings& meetings, const Layers& layers, const Meet& meet) {
  for (const Body body : kAllBodies)
    for (const Body other : kAllBodies) {
      const Meeting& meeting = meetings.bodies[Index(body)][Index(other)];
      if (body < other && layers[Index(body)] == layers[Index(other)] && meeting.Happens())
        meet(NameOf(body), NameOf(other), meeting);
    }
  for (const Joint joint : kAllJoints) {
    const auto [low, high] = ReachOf(joint, layers);
    for (const Body body : kAllBodies) {
      const Meeting& meeting = meetings.pins[Index(joint)][Index(body)];
      if (layers[Index(body)] > low && layers[Index(body)] < high && meeting.Happens())
        meet(NameOf(body), LetterOf(joint), meeting);
    }
  }
}

int CountConflicts(const Meetings& meetings, const Layers& layers) {
  int count = 0;
  ForEachConflict(meetings, layers, [&](std::string_view, std::string_view, const Meeting&) { ++count; });
  return count;
}

bool AreWithoutGap(const Layers& layers) {
  const int top = *std::max_element(layers.begin(), layers.end());
  for (int layer = 0; layer <= top; ++layer)
    if (std::find(layers.begin(), layers.end(), layer) == layers.end()) return false;
  return true;
}

std::array<Span, kBodies> SpansOf(const PartOptions& options, const Layers& layers) {
  std::array<Span, kBodies> spans{};
  double bottom_mm = 0;
  for (int layer = 0; layer <= *std::max_element(layers.begin(), layers.end()); ++layer) {
    const bool has_actuator = layers[Index(Body::kActuator)] == layer;
    const double height_mm = has_actuator ? options.actuator_diameter_mm : options.thickness_mm;
    for (const Body body : kAllBodies) {
      if (layers[Index(body)] != layer) continue;
      const double thickness_mm = body == Body::kActuator ? options.actuator_eye_mm : options.thickness_mm;
      const double middle_mm = bottom_mm + height_mm / 2;
      spans[Index(body)] = {middle_mm - thickness_mm / 2, middle_mm + thickness_mm / 2};
    }
    bottom_mm += height_mm + options.gap_mm;
  }
  return spans;
}

Pin PinOf(Joint joint, const std::array<Span, kBodies>& spans, double gap_mm) {
  Pin pin{joint, JoinedBy(joint), {}};
  std::sort(pin.bodies.begin(), pin.bodies.end(),
            [&](Body a, Body b) { return spans[Index(a)].from_mm < spans[Index(b)].from_mm; });
  pin.span = {spans[Index(pin.bodies.front())].from_mm - gap_mm, spans[Index(pin.bodies.back())].to_mm + gap_mm};
  return pin;
}

double TotalPinLength(const PartOptions& options, const Layers& layers) {
  const std::array<Span, kBodies> spans = SpansOf(options, layers);
  double total_mm = 0;
  for (const Joint joint : kAllJoints) total_mm += PinOf(joint, spans, options.gap_mm).span.Length();
  return total_mm;
}

// The thigh plate below the actuator: one of each order and its mirror image.
Layers BestLayers(const Mechanism& mechanism, const Meetings& meetings) {
  std::tuple<int, double, Layers> best{std::numeric_limits<int>::max(), 0, {}};
  constexpr int kLayers = static_cast<int>(kBodies);
  const int orders = static_cast<int>(std::pow(kLayers, kLayers));
  for (int order = 0; order < orders; ++order) {
    Layers layers;
    for (int i = 0, rest = order; i < kLayers; ++i, rest /= kLayers) layers[i] = rest % kLayers;
    if (!AreWithoutGap(layers) || layers[Index(Body::kThigh)] > layers[Index(Body::kActuator)]) continue;
    const int conflicts = CountConflicts(meetings, layers);
    if (conflicts > std::get<int>(best)) continue;
    best = std::min(best, {conflicts, TotalPinLength(mechanism.options, layers), layers});
  }
  return std::get<Layers>(best);
}

void AddSpacers(const Pin& pin, const PartOptions& options, Stack& stack) {
  for (std::size_t i = 0; i + 1 < pin.bodies.size(); ++i) {
    const Span between{stack.span[Index(pin.bodies[i])].to_mm, stack.span[Index(pin.bodies[i + 1])].from_mm};
    if (between.Length() > 0)
      stack.spacers.push_back(
          {pin.joint, between, options.pin_diameter_mm + options.bore_clearance_mm, TubeDiameter(options)});
  }
}

}  // namespace

std::vector<double> SweepStrokes(const Mechanism& mechanism) {
  // From the end backwards: what is still to be looked at, nearest last. A stroke is halved until its ends are near.
  constexpr double kLeastTravel_mm = 1e-9;
  std::vector<double> ahead = {mechanism.range.stroke.upper_mm};
  std::vector<double> strokes = {mechanism.range.stroke.lower_mm};
  while (!ahead.empty()) {
    const double from = strokes.back(), to = ahead.back();
    const double motion =
        CornerMotion(mechanism, linkage::RequirePose(mechanism.links, from), linkage::RequirePose(mechanism.links, to));
    if (motion > kSweepStep_mm && to - from > kLeastTravel_mm) {
      ahead.push_back((from + to) / 2);
    } else {
      strokes.push_back(to);
      ahead.pop_back();
    }
  }
  return strokes;
}

double DistanceBetween(const Mechanism& mechanism, Body a, Body b, const linkage::Pose& pose) {
  return ShapeDistance(ShapeOf(mechanism, a, pose), ShapeOf(mechanism, b, pose));
}

double DistanceBetween(const Mechanism& mechanism, Joint joint, Body body, const linkage::Pose& pose) {
  const Shape pin{{PlaceOf(joint, pose)}, TubeDiameter(mechanism.options) / 2};
  return ShapeDistance(pin, ShapeOf(mechanism, body, pose));
}

Stack FindStack(const Mechanism& mechanism) {
  const Meetings meetings = FindMeetings(mechanism);
  Stack stack;
  stack.layer = BestLayers(mechanism, meetings);
  stack.span = SpansOf(mechanism.options, stack.layer);
  for (const Joint joint : kAllJoints) {
    stack.pins.push_back(PinOf(joint, stack.span, mechanism.options.gap_mm));
    AddSpacers(stack.pins.back(), mechanism.options, stack);
  }
  ForEachConflict(meetings, stack.layer, [&](std::string_view body, std::string_view other, const Meeting& meeting) {
    stack.conflicts.push_back(fmt::format("{} and {}{} meet between {:.1f}° and {:.1f}°", body,
                                          other.size() == 1 ? "pin " : "", other, meeting.least_deg, meeting.most_deg));
  });
  return stack;
}

Mechanism MakeMechanism(const linkage::Links& links, const linkage::UsedRange& range, const PartOptions& options) {
  Mechanism mechanism{
      .links = links, .range = range, .options = options, .plates = PlatesOf(links, options), .stack = {}};
  mechanism.stack = FindStack(mechanism);
  return mechanism;
}

}  // namespace lake::parts
