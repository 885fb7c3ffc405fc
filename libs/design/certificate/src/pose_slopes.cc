#include "pose_slopes.h"

#include <algorithm>

namespace lake::certificate {
namespace {

std::array<Slope, 6> LinkSlopes(const AxisBox& box) {
  std::array<Slope, 6> links;
  for (std::size_t i = 0; i < links.size(); ++i) links[i] = Slope::Axis(i, box[i]);
  return links;
}

Interval NotNegative(const Interval& a) {
  return Intersection(a, {0, kInfinity});
}

// What is known to be no less than a bound.
Interval AtLeast(Interval a, const Interval& bound) {
  a.lower = std::max(a.lower, bound.lower);
  a.upper = std::max(a.lower, a.upper);
  return a;
}

// Twice the area of a triangle of this sum and these differences of its sides, by Heron.
Interval TwiceArea(const Interval& sum, const Interval& first, const Interval& second, const Interval& third) {
  return Sqrt(sum * NotNegative(first) * NotNegative(second) * NotNegative(third)) / 2.0;
}

// f over a box is within f(anchor) + derivatives x distances as well.
template <typename Function>
void Tighten(Slope& f, const Function& at, const Region& region) {
  if (!region.anchor) return;
  const Interval at_anchor = at(BoxOf(*region.anchor));
  if (at_anchor.IsEmpty()) return;
  Interval around = at_anchor;
  for (std::size_t i = 0; i < kAxes; ++i)
    if (f.by[i].lower != 0 || f.by[i].upper != 0)
      around = around + f.by[i] * (region.box[i] - Interval((*region.anchor)[i]));
  if (std::isfinite(around.lower) && std::isfinite(around.upper)) f.value = Intersection(f.value, around);
}

void DifferentiateKappa(const AxisBox& l, const Margins& margins, Slope& kappa) {
  const Interval phi = l[kPhi], between = kappa.value - phi;
  const Interval l8 = Sqrt(SquaredTipDistance(l));
  const Interval grashof = margins.grashof_mm - 4 * kRounding_mm;
  const Interval past_folded = 4.0 * l[kL2] * l[kL3] * Square(Cos(phi / 2.0)) / (l8 + NotNegative(l[kL2] - l[kL3]));
  const Interval short_of_straight = 4.0 * l[kL2] * l[kL3] * Square(Sin(phi / 2.0)) / (l[kL2] + l[kL3] + l8);
  // u.S' = l4 l8 sin beta2, twice the area of K, R, S; written with kappa it is narrower in small boxes.
  const Interval area = Intersection(
      TwiceArea(l[kL1] + l[kL4] + l8, AtLeast(l[kL1] + l[kL4] - l8, grashof + short_of_straight),
                AtLeast(l8 - l[kL4] + l[kL1], grashof + past_folded), AtLeast(l8 + l[kL4] - l[kL1], l8 - kRounding_mm)),
      NotNegative(l[kL4] * (l[kL3] * Sin(kappa.value) + l[kL2] * Sin(between))));
  const Interval squared = Square(l[kL3] - l[kL4]) + 4.0 * l[kL3] * l[kL4] * Square(Sin(kappa.value / 2.0));
  const Interval u_e = Intersection((squared - Square(l[kL1]) - Square(l[kL2])) / (2.0 * l[kL2]),
                                    l[kL4] * Cos(between) - l[kL3] * Cos(phi) - l[kL2]);
  const Interval u_y = l[kL4] * Cos(kappa.value) - l[kL3] - l[kL2] * Cos(phi);
  const Interval u_s = Intersection((Square(l[kL1]) + Square(l[kL4]) - Square(l8)) / (2.0 * l[kL4]),
                                    l[kL4] - l[kL3] * Cos(kappa.value) - l[kL2] * Cos(between));
  const Interval u_r = l[kL2] * (l[kL4] * Sin(between) + l[kL3] * Sin(phi));
  kappa.by[kL1] = l[kL1] / area;
  kappa.by[kL2] = u_e / area;
  kappa.by[kL3] = Intersection(u_y, Interval(-l[kL1].upper, l[kL1].upper)) / area;
  kappa.by[kL4] = -u_s / area;
  kappa.by[kPhi] = u_r / area;
}

// R is where the circles of l2 about P and of l1 about S meet, on the side where the used range is.
Interval PhiAt(const AxisBox& l, const Interval& kappa) {
  const Interval squared = Square(l[kL3] - l[kL4]) + 4.0 * l[kL3] * l[kL4] * Square(Sin(kappa / 2.0));
  const Interval heading = AngleFromY(l[kL4] * Sin(kappa), l[kL4] * Cos(kappa) - l[kL3]);
  return heading - ArcCos((squared + Square(l[kL2]) - Square(l[kL1])) / (2.0 * Sqrt(squared) * l[kL2]));
}

void DifferentiatePhi(const AxisBox& l, const Interval& kappa, const Margins& margins, Slope& phi) {
  const Interval between = kappa - phi.value;
  const Interval squared = Square(l[kL3] - l[kL4]) + 4.0 * l[kL3] * l[kL4] * Square(Sin(kappa / 2.0));
  const Interval ps = Sqrt(squared), grashof = margins.grashof_mm - 4 * kRounding_mm, order = -4 * kRounding_mm;
  const Interval past_folded = 4.0 * l[kL3] * l[kL4] * Square(Sin(kappa / 2.0)) / (ps + NotNegative(l[kL4] - l[kL3]));
  const Interval short_of_straight = 4.0 * l[kL3] * l[kL4] * Square(Cos(kappa / 2.0)) / (l[kL3] + l[kL4] + ps);
  // u.R', twice the area of P, S, R.
  const Interval area = Intersection(
      TwiceArea(l[kL1] + l[kL2] + ps, AtLeast(l[kL1] + l[kL2] - ps, grashof + short_of_straight),
                AtLeast(ps - l[kL1] + l[kL2], order + past_folded), AtLeast(ps - l[kL2] + l[kL1], order + past_folded)),
      NotNegative(l[kL2] * (l[kL4] * Sin(between) + l[kL3] * Sin(phi.value))));
  const Interval u_e = Intersection((squared - Square(l[kL1]) - Square(l[kL2])) / (2.0 * l[kL2]),
                                    l[kL4] * Cos(between) - l[kL3] * Cos(phi.value) - l[kL2]);
  phi.by[kL1] = -l[kL1] / area;
  phi.by[kL2] = -u_e / area;
  phi.by[kL3] = (l[kL3] + l[kL2] * Cos(phi.value) - l[kL4] * Cos(kappa)) / area;
  phi.by[kL4] = (l[kL4] - l[kL3] * Cos(kappa) - l[kL2] * Cos(between)) / area;
}

// u.S' / l4 and u.R' / l2 from the angles.
void AddByAngles(PoseSlopes& pose) {
  const auto& l = pose.links;
  const Slope between = pose.kappa - pose.phi;
  pose.shank = l[kL3] * Sin(pose.kappa) + l[kL2] * Sin(between);
  pose.turning = l[kL4] * Sin(between) + l[kL3] * Sin(pose.phi);
}

// The same at a given kappa, from the sides: they change less with the links than the angles do. With A = u.R', twice
// the area of P, S, R, and D = |PS|:
//   u.S' = l4 / D^2 (l3 sin kappa (D^2 + l1^2 - l2^2) / 2 + (l4 - l3 cos kappa) A)
void AddBySides(const Margins& margins, const Interval& kappa, PoseSlopes& pose) {
  const auto& l = pose.links;
  const Interval sine = Sin(kappa), half_sine = Square(Sin(kappa / 2.0)), half_cosine = Square(Cos(kappa / 2.0));
  const Slope squared = Square(l[kL3] - l[kL4]) + 4.0 * l[kL3] * l[kL4] * half_sine;
  const Slope ps = Sqrt(squared);
  Slope short_of_straight = l[kL1] + l[kL2] - ps, first = ps - l[kL1] + l[kL2], second = ps - l[kL2] + l[kL1];
  const Interval d = ps.value, past_folded = 4.0 * l[kL3].value * l[kL4].value * half_sine /
                                             (d + NotNegative(l[kL4].value - l[kL3].value));
  short_of_straight.value = AtLeast(
      short_of_straight.value, margins.grashof_mm - 4 * kRounding_mm +
                                   4.0 * l[kL3].value * l[kL4].value * half_cosine / (l[kL3].value + l[kL4].value + d));
  first.value = AtLeast(first.value, past_folded - 4 * kRounding_mm);
  second.value = AtLeast(second.value, past_folded - 4 * kRounding_mm);
  const Slope area = 0.5 * Sqrt((l[kL1] + l[kL2] + ps) * short_of_straight * first * second);
  const Slope along = l[kL3] * sine * 0.5 * (squared + Square(l[kL1]) - Square(l[kL2]));
  const Slope across = l[kL4] - l[kL3] * Cos(kappa);
  pose.turning = area / l[kL2];
  pose.shank = (along + across * area) / squared;
  pose.ratio = l[kL4] * (along / area + across) / squared;
}

// |w| from the parts of w along the bar's mount.
Slope StrokeOf(const std::array<Slope, 6>& l, const Slope& phi) {
  const Slope across = l[kL2] * Sin(phi) - l[kL5], along = l[kL2] * Cos(phi) - l[kL6];
  return Sqrt(Square(across) + Square(along));
}

}  // namespace

Interval SquaredTipDistance(const AxisBox& l) {
  return Square(l[kL2] - l[kL3]) + 4.0 * l[kL2] * l[kL3] * Square(Cos(l[kPhi] / 2.0));
}

Interval Beta1Of(const AxisBox& l) {
  return AngleFromY(l[kL2] * Sin(l[kPhi]), l[kL3] + l[kL2] * Cos(l[kPhi]));
}

Interval KappaOf(const AxisBox& l) {
  const Interval squared = SquaredTipDistance(l);
  const Interval beta2 = ArcCos((squared + Square(l[kL4]) - Square(l[kL1])) / (2.0 * Sqrt(squared) * l[kL4]));
  return beta2.IsEmpty() ? beta2 : Beta1Of(l) + beta2;
}

std::optional<PoseSlopes> PoseAtShortestStroke(const Region& region, double d_min_mm, const Margins& margins) {
  const AxisBox& box = region.box;
  PoseSlopes pose;
  pose.links = LinkSlopes(box);
  pose.phi = Slope::Axis(kPhi, box[kPhi]);
  pose.stroke = Interval(d_min_mm);
  pose.kappa.value = KappaOf(box);
  if (pose.kappa.value.IsEmpty()) return std::nullopt;
  DifferentiateKappa(box, margins, pose.kappa);
  Tighten(pose.kappa, KappaOf, region);
  if (pose.kappa.value.IsEmpty()) return std::nullopt;
  DifferentiateKappa(box, margins, pose.kappa);
  AddByAngles(pose);
  return pose;
}

std::optional<PoseSlopes> PoseAtAngle(const Region& region, const Interval& kappa_rad, double d_min_mm,
                                      const Margins& margins) {
  const AxisBox& box = region.box;
  PoseSlopes pose;
  pose.links = LinkSlopes(box);
  pose.kappa = kappa_rad;
  pose.phi.value = PhiAt(box, kappa_rad);
  if (pose.phi.value.IsEmpty()) return std::nullopt;
  DifferentiatePhi(box, kappa_rad, margins, pose.phi);
  Tighten(
      pose.phi, [&](const AxisBox& at) { return PhiAt(at, kappa_rad); }, region);
  if (pose.phi.value.IsEmpty()) return std::nullopt;
  DifferentiatePhi(box, kappa_rad, margins, pose.phi);
  pose.stroke = StrokeOf(pose.links, pose.phi);
  if (pose.stroke.value.upper < d_min_mm) return std::nullopt;
  AddBySides(margins, kappa_rad, pose);
  return pose;
}

Slope BarAngleAtShortestStroke(const AxisBox& box, const Interval& phi_rad, double d_min_mm, const Margins& margins) {
  // The set is a little larger than what phi_rad is of.
  constexpr double kRounding_rad = 1e-6;
  Slope phi(phi_rad + Interval(-kRounding_rad, kRounding_rad));
  const Interval l7 = Sqrt(Square(box[kL5]) + Square(box[kL6])), l2 = box[kL2];
  const Interval slack = AtLeast(l2 + d_min_mm - l7, margins.singularity_mm - kRounding_mm);
  // w.R', twice the area of P, R, M.
  const Interval area = Intersection(TwiceArea(l2 + d_min_mm + l7, slack, l7 - l2 + d_min_mm, l7 + l2 - d_min_mm),
                                     NotNegative(l2 * (box[kL6] * Sin(phi.value) - box[kL5] * Cos(phi.value))));
  const Interval w_e = (Square(Interval(d_min_mm)) + Square(l2) - Square(l7)) / (2.0 * l2);
  phi.by[kL2] = -w_e / area;
  phi.by[kL5] = (l2 * Sin(phi.value) - box[kL5]) / area;
  phi.by[kL6] = (l2 * Cos(phi.value) - box[kL6]) / area;
  return phi;
}

Interval BarAngleOfPoint(const AxisBox& point, double d_min_mm) {
  const Interval l2 = point[kL2], l7 = Sqrt(Square(point[kL5]) + Square(point[kL6]));
  const Interval alpha2 = ArcCos(1.0 - (l2 + d_min_mm - l7) * (d_min_mm + l7 - l2) / (2.0 * l7 * l2));
  return alpha2.IsEmpty() ? alpha2 : AngleFromY(point[kL5], point[kL6]) + alpha2;
}

Slope MountAngle(const AxisBox& box) {
  Slope angle(AngleFromY(box[kL5], box[kL6]));
  const Interval squared = Square(box[kL5]) + Square(box[kL6]);
  angle.by[kL5] = box[kL6] / squared;
  angle.by[kL6] = -box[kL5] / squared;
  return angle;
}

Slope ActuatorSlack(const AxisBox& box, double d_min_mm) {
  const auto links = LinkSlopes(box);
  return links[kL2] + d_min_mm - Sqrt(Square(links[kL5]) + Square(links[kL6]));
}

Slope SlopeQuantities::Actuator() const {
  const auto& l = pose_.links;
  return l[kL6] * Sin(pose_.phi) - l[kL5] * Cos(pose_.phi);
}

problem::Ratio<Slope> SlopeQuantities::MomentArm() const {
  const auto& l = pose_.links;
  if (pose_.ratio) return {l[kL2] * actuator_ * *pose_.ratio, pose_.stroke};
  return {l[kL4] * pose_.shank * actuator_, pose_.stroke * pose_.turning};
}

problem::Ratio<Slope> SlopeQuantities::BarForce() const {
  const auto& l = pose_.links;
  const Slope coupler_x = l[kL4] * Sin(pose_.kappa) - l[kL2] * Sin(pose_.phi);
  const Slope coupler_y = l[kL4] * Cos(pose_.kappa) - l[kL3] - l[kL2] * Cos(pose_.phi);
  const Slope actuator_x = l[kL2] * Sin(pose_.phi) - l[kL5], actuator_y = l[kL2] * Cos(pose_.phi) - l[kL6];
  return {coupler_x * actuator_y - coupler_y * actuator_x, l[kL4] * pose_.shank * actuator_};
}

}  // namespace lake::certificate
