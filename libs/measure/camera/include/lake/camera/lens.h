// OpenCV's models of lens distortion, as templates over the scalar.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace lake::camera {

enum class LensModel {
  kBrownConrady,  // D. C. Brown, Close-range camera calibration, 1971; with OpenCV's rational, thin-prism and tilt
                  // terms
  kFisheye,       // J. Kannala & S. S. Brandt, 2006: the angle from the axis, not its tangent, as an odd polynomial
};

// k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 τx τy; of a fisheye k1 k2 k3 k4 and zeros.
inline constexpr std::size_t kLensCoefficients = 14;

// Of the normalised point (x, y) = (X/Z, Y/Z).
template <typename T>
Eigen::Matrix<T, 2, 1> DistortFisheye(const T* c, const T& x, const T& y) {
  using std::atan, std::sqrt;
  const T r2 = x * x + y * y;
  if (r2 < T(1e-16)) return {x, y};
  const T r = sqrt(r2), theta = atan(r), t2 = theta * theta;
  const T scale = theta * (T(1) + t2 * (c[0] + t2 * (c[1] + t2 * (c[2] + t2 * c[3])))) / r;
  return {x * scale, y * scale};
}

// The image of a distorted point on a sensor tilted by τx about x, then by τy about y.
template <typename T>
Eigen::Matrix<T, 2, 1> OnTiltedSensor(const T& tau_x, const T& tau_y, const T& x, const T& y) {
  using std::cos, std::sin;
  const T cx = cos(tau_x), sx = sin(tau_x), cy = cos(tau_y), sy = sin(tau_y);
  // R = R_y(τy) R_x(τx); the point is projected onto the turned plane: [R33 0 −R13; 0 R33 −R23; 0 0 1] R (x, y, 1).
  const T rx = cy * x + sy * sx * y - sy * cx, ry = cx * y + sx, rz = sy * x - cy * sx * y + cy * cx;
  const T r33 = cy * cx, r13 = -sy * cx, r23 = sx;
  return {(r33 * rx - r13 * rz) / rz, (r33 * ry - r23 * rz) / rz};
}

template <typename T>
Eigen::Matrix<T, 2, 1> DistortBrownConrady(const T* c, const T& x, const T& y) {
  const T r2 = x * x + y * y, r4 = r2 * r2;
  const T radial = (T(1) + r2 * (c[0] + r2 * (c[1] + r2 * c[4]))) / (T(1) + r2 * (c[5] + r2 * (c[6] + r2 * c[7])));
  const T xd = x * radial + T(2) * c[2] * x * y + c[3] * (r2 + T(2) * x * x) + c[8] * r2 + c[9] * r4;
  const T yd = y * radial + c[2] * (r2 + T(2) * y * y) + T(2) * c[3] * x * y + c[10] * r2 + c[11] * r4;
  if (c[12] == T(0) && c[13] == T(0)) return {xd, yd};
  return OnTiltedSensor(c[12], c[13], xd, yd);
}

// The pixel of a point in the camera frame with z > 0. intrinsics: fx fy cx cy; coefficients as above.
template <typename T>
Eigen::Matrix<T, 2, 1> ProjectLens(LensModel model, const T* intrinsics, const T* coefficients,
                                   const Eigen::Matrix<T, 3, 1>& point) {
  const T x = point.x() / point.z(), y = point.y() / point.z();
  const Eigen::Matrix<T, 2, 1> d =
      model == LensModel::kFisheye ? DistortFisheye(coefficients, x, y) : DistortBrownConrady(coefficients, x, y);
  return {intrinsics[0] * d.x() + intrinsics[2], intrinsics[1] * d.y() + intrinsics[3]};
}

}  // namespace lake::camera
