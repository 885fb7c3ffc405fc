#include "lake/linkage/linkage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lake/core/cross.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"
#include "lake/linkage/loop_equations.h"

namespace lake::linkage {
namespace {

using Eigen::Vector2d;

// A triangle that misses closing by less is taken as closed and flat: ends of solves hold their equations to 2e-9 mm,
// and the largest ranges are at flat triangles.
constexpr double kRounding_mm = 1e-8;

// How much the longest of three sides exceeds the sum of the others; negative if the triangle closes.
double TriangleGap(double a, double b, double c) {
  return std::max({a, b, c}) * 2 - (a + b + c);
}

// The angle between sides a and b, opposite c, by half its tangent in Kahan's order of operations ("Miscalculating Area
// and Angles of a Needle-like Triangle", 2014): keeps its digits for flat and for needle-like triangles, where the
// arccos form loses them. A gap within rounding gives 0 or pi.
double TriangleAngle(double a, double b, double c) {
  if (a < b) std::swap(a, b);
  const double sine2 = ((a - b) + c) * (b >= c ? c - (a - b) : b - (a - c));
  const double cosine2 = (a + (b + c)) * ((a - c) + b);
  return 2 * std::atan2(std::sqrt(std::max(0.0, sine2)), std::sqrt(std::max(0.0, cosine2)));
}

// KR for a bar angle, Eq. (4).
double TipDistance(const Links& l, double phi) {
  return std::hypot(l.l3 - l.l2, 2 * std::sqrt(l.l2 * l.l3) * std::cos(phi / 2));
}

double SignOfAlpha2(Branch branch) {
  return branch == Branch::kAssembled || branch == Branch::kShankFlipped ? 1 : -1;
}
double SignOfBeta2(Branch branch) {
  return branch == Branch::kAssembled || branch == Branch::kBarFlipped ? 1 : -1;
}

// P + l2 (sin phi, cos phi), written without cancellation where the tip passes the knee pivot.
Vector2d TipOf(const Links& l, double phi) {
  const double sine = std::sin(phi / 2), cosine = std::cos(phi / 2);
  return {2 * l.l2 * sine * cosine, (l.l3 - l.l2) + 2 * l.l2 * cosine * cosine};
}
Vector2d ShankPinOf(const Links& l, double theta) {
  return {l.l4 * std::sin(theta), -l.l4 * std::cos(theta)};
}

// The angle of KR from +y, continuous in phi: R goes behind the knee pivot when the bar is longer than the thigh link.
double Beta1(const Links& l, double phi) {
  const Vector2d tip = TipOf(l, phi);
  const double angle = std::atan2(tip.x(), tip.y());
  return phi > kPi && l.l2 > l.l3 ? angle + 2 * kPi : angle;
}

}  // namespace

double Links::L7() const {
  return std::hypot(l5, l6);
}

void CheckLinks(const Links& links, std::string_view where) {
  constexpr double kShortest_mm = 1, kLongest_mm = 1e4;
  const auto values = links.Values();
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(values[i] >= kShortest_mm && values[i] <= kLongest_mm))
      throw Fail("{}: link l{} is {} mm; it must be within {} and {} mm{}", where, i + 1, values[i], kShortest_mm,
                 kLongest_mm, values[i] > 0 && values[i] < kShortest_mm ? ": write lengths in mm, not in m" : "");
}

std::optional<AssemblyGap> FindAssemblyGap(const Links& links, double stroke_mm) {
  const double l7 = links.L7();
  const double actuator_gap = TriangleGap(l7, links.l2, stroke_mm);
  if (!(stroke_mm > 0) || !(actuator_gap <= kRounding_mm))
    return AssemblyGap{AssemblyGap::Triangle::kActuator, actuator_gap,
                       fmt::format("{} by {} mm",
                                   stroke_mm > std::max(l7, links.l2) ? "the actuator is too long for l2, l5 and l6"
                                   : links.l2 > l7                    ? "l2 is too long for l5, l6 and the actuator"
                                                                      : "l5 or l6 is too long for l2 and the actuator",
                                   SignificantText(actuator_gap, 3))};
  const double l8 = TipDistance(links, std::atan2(links.l5, links.l6) + TriangleAngle(l7, links.l2, stroke_mm));
  const double shank_gap = TriangleGap(l8, links.l4, links.l1);
  if (shank_gap > kRounding_mm)
    return AssemblyGap{AssemblyGap::Triangle::kShank, shank_gap,
                       fmt::format("{} by {} mm",
                                   l8 > std::max(links.l1, links.l4) ? "l1 or l4 is too short"
                                   : links.l1 > links.l4             ? "l1 is too long or l4 too short"
                                                                     : "l4 is too long or l1 too short",
                                   SignificantText(shank_gap, 3))};
  return std::nullopt;
}

std::optional<Pose> SolvePose(const Links& links, double stroke_mm, Branch branch) {
  const double l7 = links.L7();
  if (!(stroke_mm > 0) || !(TriangleGap(l7, links.l2, stroke_mm) <= kRounding_mm)) return std::nullopt;
  Pose pose;
  pose.stroke_mm = stroke_mm;
  pose.branch = branch;
  pose.alpha1_rad = std::atan2(links.l5, links.l6);                                 // Eq. (5)
  pose.alpha2_rad = SignOfAlpha2(branch) * TriangleAngle(l7, links.l2, stroke_mm);  // Eq. (6)
  pose.phi_rad = pose.alpha1_rad + pose.alpha2_rad;
  pose.l8_mm = TipDistance(links, pose.phi_rad);  // Eq. (4)
  if (!(TriangleGap(pose.l8_mm, links.l4, links.l1) <= kRounding_mm)) return std::nullopt;
  pose.beta1_rad = Beta1(links, pose.phi_rad);                                           // Eq. (2)
  pose.beta2_rad = SignOfBeta2(branch) * TriangleAngle(pose.l8_mm, links.l4, links.l1);  // Eq. (3)
  pose.theta_rad = kPi - pose.beta1_rad - pose.beta2_rad;                                // Eq. (1)
  pose.knee = {0, 0};
  pose.thigh_pin = {0, links.l3};
  pose.tip = TipOf(links, pose.phi_rad);
  pose.shank_pin = ShankPinOf(links, pose.theta_rad);
  pose.mount = {links.l5, links.l3 + links.l6};
  return pose;
}

Pose RequirePose(const Links& links, double stroke_mm) {
  const std::optional<Pose> pose = SolvePose(links, stroke_mm);
  if (pose) return *pose;
  const std::optional<AssemblyGap> gap = FindAssemblyGap(links, stroke_mm);
  throw Fail("the linkage cannot be assembled at a stroke of {} mm: {}", SignificantText(stroke_mm, 6),
             gap ? gap->text : "no triangle");
}

Transmission TransmissionOf(const Links& links, const Pose& pose) {
  const auto l = links.Values();
  const double d = pose.stroke_mm, phi = pose.phi_rad, theta = pose.theta_rad;
  const auto [transmission_sine, transmission_cosine] = SinCosTransmission(l.data(), phi, theta);
  const auto [actuator_sine, actuator_cosine] = SinCosActuator(l.data(), d, phi, theta);
  const double stroke_per_radian = StrokePerRadian(l.data(), d, phi, theta);
  Transmission result{.radians_per_mm = 1 / stroke_per_radian,
                      .moment_arm_mm = std::abs(stroke_per_radian),
                      .transmission_rad = std::abs(std::atan2(transmission_sine, transmission_cosine)),
                      .actuator_rad = std::abs(std::atan2(actuator_sine, actuator_cosine))};
  result.shank_pressure_rad = std::abs(kPi / 2 - result.transmission_rad);
  result.actuator_pressure_rad = std::abs(kPi / 2 - result.actuator_rad);
  return result;
}

double ActuatorForce(const Transmission& transmission, double knee_torque_nm) {
  constexpr double kMillimetresPerMetre = 1000;
  return -knee_torque_nm * kMillimetresPerMetre * transmission.radians_per_mm;
}

Grashof GrashofOf(const Links& links) {
  std::array<double, 4> sides{links.l1, links.l2, links.l3, links.l4};
  std::sort(sides.begin(), sides.end());
  const double slack = sides[1] + sides[2] - sides[0] - sides[3];
  if (slack < 0) return {GrashofClass::kTripleRocker, slack};
  if (slack == 0) return {GrashofClass::kChangePoint, slack};
  if (sides[0] == links.l4) return {GrashofClass::kDoubleCrank, slack};
  if (sides[0] == links.l2) return {GrashofClass::kDoubleRocker, slack};  // opposite the frame
  return {GrashofClass::kCrankRocker, slack};
}

std::string_view NameOf(GrashofClass type) {
  switch (type) {
    case GrashofClass::kCrankRocker:
      return "crank-rocker";
    case GrashofClass::kDoubleCrank:
      return "double crank";
    case GrashofClass::kDoubleRocker:
      return "double rocker";
    case GrashofClass::kChangePoint:
      return "change point";
    case GrashofClass::kTripleRocker:
      return "triple rocker (not Grashof)";
  }
  return "";
}

SingularityDistances DistancesToSingularities(const Links& links, const Pose& pose) {
  const double l7 = links.L7();
  return {.actuator_folded_mm = links.l2 + pose.stroke_mm - l7,
          .actuator_extended_mm = l7 + links.l2 - pose.stroke_mm,
          .shank_folded_mm = pose.l8_mm - std::abs(links.l4 - links.l1),
          .shank_extended_mm = links.l4 + links.l1 - pose.l8_mm};
}

const char* NameOf(Mount mount) {
  return mount == Mount::kBeside ? "beside" : "behind";
}

Mount MountOf(const std::string& name) {
  for (const Mount mount : {Mount::kBeside, Mount::kBehind})
    if (name == NameOf(mount)) return mount;
  throw UsageError("a mount is beside or behind the leg, not '{}'", name);
}

MemberForces MemberForcesOf(const Pose& pose, double knee_torque_nm) {
  constexpr double kMillimetresPerMetre = 1000;
  const Vector2d coupler = (pose.shank_pin - pose.tip).normalized();
  const Vector2d actuator = (pose.tip - pose.mount).normalized();
  const Vector2d bar = (pose.tip - pose.thigh_pin).normalized();
  MemberForces forces;
  // Shank about K: the coupler's push at S gives the torque. In the thigh frame flexion turns anticlockwise.
  forces.coupler_n = -knee_torque_nm * kMillimetresPerMetre / Cross(pose.shank_pin - pose.knee, coupler);
  // Pin R: actuator and bar push it away from M and P, the coupler away from S.
  const double between = Cross(actuator, bar);
  forces.actuator_n = forces.coupler_n * Cross(coupler, bar) / between;
  forces.bar_n = forces.coupler_n * Cross(actuator, coupler) / between;
  return forces;
}

}  // namespace lake::linkage
