// The loop equations and derived quantities, as templates over the scalar: double, or ceres::Jet for exact derivatives.
//
// With the stroke d, the bar angle phi and the knee angle theta as variables everything here is smooth (no arccos),
// also on the singular surfaces. `l` points to l1..l6 in mm; angles rad. Frame and joints as in linkage.h.
#pragma once

#include <array>
#include <cmath>

namespace lake::linkage {

// Squared lengths are divided by twice this, which makes residuals mm-like and keeps Hessians free of divisions by
// variables.
inline constexpr double kLoopScale_mm = 100.0;

template <typename T>
struct Planar {
  T x, y;
};
template <typename T>
T Dot(const Planar<T>& a, const Planar<T>& b) {
  return a.x * b.x + a.y * b.y;
}

// The vectors that close the loops, and the velocities of R and S.
template <typename T>
struct LoopVectors {
  Planar<T> actuator;      // w = R - M
  Planar<T> coupler;       // u = S - R
  Planar<T> tip_motion;    // dR / dphi
  Planar<T> shank_motion;  // dS / dkappa, kappa = pi - theta
};

template <typename T>
LoopVectors<T> LoopVectorsOf(const T* l, const T& phi, const T& theta) {
  using std::cos, std::sin;
  const T bar_x = l[1] * sin(phi), bar_y = l[1] * cos(phi);
  const T shank_x = l[3] * sin(theta), shank_y = -l[3] * cos(theta);
  return {
      {bar_x - l[4], bar_y - l[5]}, {shank_x - bar_x, shank_y - l[2] - bar_y}, {bar_y, -bar_x}, {shank_y, -shank_x}};
}

// (|R - M|^2 - d^2) / (2 scale) and (|R - S|^2 - l1^2) / (2 scale): both zero in an assembled pose.
template <typename T>
std::array<T, 2> LoopResiduals(const T* l, const T& d, const T& phi, const T& theta) {
  const LoopVectors<T> v = LoopVectorsOf(l, phi, theta);
  return {(Dot(v.actuator, v.actuator) - d * d) / (2.0 * kLoopScale_mm),
          (Dot(v.coupler, v.coupler) - l[0] * l[0]) / (2.0 * kLoopScale_mm)};
}

// l7 l2 sin(alpha2) / scale^2 and l8 l4 sin(beta2) / scale^2: both >= 0 on the assembled branch.
template <typename T>
std::array<T, 2> BranchExpressions(const T* l, const T& phi, const T& theta) {
  using std::cos, std::sin;
  constexpr double kScale = kLoopScale_mm * kLoopScale_mm;
  const T tip_x = l[1] * sin(phi), tip_y = l[2] + l[1] * cos(phi);
  return {(tip_x * l[5] - (tip_y - l[2]) * l[4]) / kScale, l[3] * (sin(theta) * tip_y + cos(theta) * tip_x) / kScale};
}

// d d / d theta in mm per rad, negative where a longer stroke straightens the knee. Its absolute value is the moment
// arm. From the velocities: (u . dS) kappa' = (u . dR) phi' and (w . dR) phi' = d d'. Infinite where theta turns (u .
// dR = 0).
template <typename T>
T StrokePerRadian(const T* l, const T& d, const T& phi, const T& theta) {
  const LoopVectors<T> v = LoopVectorsOf(l, phi, theta);
  return -Dot(v.coupler, v.shank_motion) * Dot(v.actuator, v.tip_motion) / (d * Dot(v.coupler, v.tip_motion));
}

// Sine and cosine of the transmission angle RSK (coupler against shank link); the sine is >= 0 on the assembled branch.
template <typename T>
std::array<T, 2> SinCosTransmission(const T* l, const T& phi, const T& theta) {
  using std::cos, std::sin;
  const LoopVectors<T> v = LoopVectorsOf(l, phi, theta);
  const T scale = l[0] * l[3];
  return {Dot(v.coupler, v.shank_motion) / scale, l[3] * (v.coupler.x * sin(theta) - v.coupler.y * cos(theta)) / scale};
}

// Sine and cosine of the angle PRM between slewing bar and actuator; the sine is >= 0 on the assembled branch.
template <typename T>
std::array<T, 2> SinCosActuator(const T* l, const T& d, const T& phi, const T& theta) {
  using std::cos, std::sin;
  const LoopVectors<T> v = LoopVectorsOf(l, phi, theta);
  return {Dot(v.actuator, v.tip_motion) / (l[1] * d), (v.actuator.x * sin(phi) + v.actuator.y * cos(phi)) / d};
}

}  // namespace lake::linkage
