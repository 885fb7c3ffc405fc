// What the limits on a pose are made of, each once for all kinds of number: double, or ceres::Jet for exact
// derivatives. The certificate has the same quantities as slopes over a box of links, in sharper forms.
#pragma once

#include "lake/core/angles.h"
#include "lake/linkage/loop_equations.h"
#include "lake/linkage/wear.h"

namespace lake::problem {

// over / under, with under >= 0 in every pose of the assembled branch before the knee angle turns; infinite where under
// is 0.
template <typename T>
struct Ratio {
  T over, under;
};
template <typename T>
Ratio(T, T) -> Ratio<T>;

template <typename T>
Ratio<T> operator*(double factor, const Ratio<T>& ratio) {
  return {factor * ratio.over, ratio.under};
}
template <typename T>
Ratio<T> Inverse(const Ratio<T>& ratio) {
  return {ratio.under, ratio.over};
}
// ratio / divisor
template <typename T, typename Divisor>
Ratio<T> Under(const Ratio<T>& ratio, const Divisor& divisor) {
  return {ratio.over, divisor * ratio.under};
}
template <typename T>
Ratio<T> OverOne(const T& over) {
  return {over, over * 0.0 + 1.0};
}

inline constexpr double kMillimetresPerMetre = 1000;

// A pin in the thigh frame of the exoskeleton, whose y is up and x backward, by the vectors of the bar PR and the shank
// link KS.
template <typename T>
linkage::Planar<T> PinAt(linkage::Pin pin, const T* l, const linkage::Planar<T>& bar, const linkage::Planar<T>& shank) {
  switch (pin) {
    case linkage::kPinK:
      return {T{}, T{}};
    case linkage::kPinP:
      return {T{}, l[2]};
    case linkage::kPinR:
      return {bar.x, l[2] + bar.y};
    case linkage::kPinS:
      return shank;
    default:
      return {l[4], l[2] + l[5]};
  }
}

// By the velocities of R and S: (u . S') kappa' = (u . R') phi', (w . R') phi' = d d', with w = R - M, u = S - R and a
// prime for the derivative by phi or kappa = pi - theta.
template <typename T>
class PoseQuantities {
 public:
  // l1..l6 in mm, the stroke in mm, bar and knee angle in rad.
  PoseQuantities(const T* l, const T& stroke, const T& phi, const T& theta)
      : l1_(l[0]), l2_(l[1]), l4_(l[3]), stroke_(stroke), theta_(theta), of_(linkage::LoopVectorsOf(l, phi, theta)) {}

  T Constant(double value) const { return stroke_ * 0.0 + value; }
  const T& Stroke_mm() const { return stroke_; }
  T Theta_deg() const { return theta_ * kDegreesPerRadian; }
  // |dd / dtheta|, mm per rad.
  Ratio<T> MomentArm() const {
    return {Shank() * Actuator() / (stroke_ * kArea_mm2), linkage::Dot(of_.coupler, of_.tip_motion) / kArea_mm2};
  }
  // Of the angle between coupler and shank link.
  Ratio<T> TransmissionSine() const { return OverOne(T(Shank() / (l1_ * l4_))); }
  // Forces in the members per torque in N mm, as linkage/statics.h has them; the bar's with its sign.
  Ratio<T> CouplerForce() const { return {l1_ / kArea_mm2, Shank() / kArea_mm2}; }
  Ratio<T> BarForce() const {
    constexpr double kScale = kArea_mm2 * kArea_mm2;
    const T cross = of_.coupler.x * of_.actuator.y - of_.coupler.y * of_.actuator.x;
    return {l2_ * cross / kScale, Shank() * Actuator() / kScale};
  }

 private:
  static constexpr double kArea_mm2 = 1e4;  // brings products near one
  T Shank() const { return linkage::Dot(of_.coupler, of_.shank_motion); }
  T Actuator() const { return linkage::Dot(of_.actuator, of_.tip_motion); }

  T l1_, l2_, l4_, stroke_, theta_;
  linkage::LoopVectors<T> of_;
};

}  // namespace lake::problem
