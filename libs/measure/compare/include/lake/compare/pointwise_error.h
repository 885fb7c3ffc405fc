// The misalignment of two knee paths, sample by sample: one template over the scalar, so that the comparison (double)
// and an optimisation (ceres::Jet) measure with the same code.
#pragma once

#include <Eigen/Core>
#include <cassert>
#include <cstddef>
#include <vector>

namespace lake::compare {

// |e − h|² in mm². The square, as its derivative exists where the paths meet.
template <typename T>
T SquaredDistance(const Eigen::Matrix<T, 2, 1>& exo_knee, const Eigen::Vector2d& human_knee) {
  const T dx = exo_knee.x() - human_knee.x(), dy = exo_knee.y() - human_knee.y();
  return dx * dx + dy * dy;
}

// (|e − h| / L)², L = |AK| of the human at the same sample, in mm.
template <typename T>
T SquaredMisalignment(const Eigen::Matrix<T, 2, 1>& exo_knee, const Eigen::Vector2d& human_knee, double shank_mm) {
  return SquaredDistance(exo_knee, human_knee) / (shank_mm * shank_mm);
}

// mean((|e − h| / L)²); its root is the RMS misalignment that report, constraint and penalty share.
template <typename T>
T MeanSquaredMisalignment(const std::vector<Eigen::Matrix<T, 2, 1>>& exo_knee,
                          const std::vector<Eigen::Vector2d>& human_knee, const std::vector<double>& shank_mm) {
  assert(!exo_knee.empty() && exo_knee.size() == human_knee.size() && exo_knee.size() == shank_mm.size());
  T sum = SquaredMisalignment(exo_knee[0], human_knee[0], shank_mm[0]);
  for (std::size_t i = 1; i < exo_knee.size(); ++i) sum += SquaredMisalignment(exo_knee[i], human_knee[i], shank_mm[i]);
  return sum / static_cast<double>(exo_knee.size());
}

// mean(|e − h|²) in mm².
template <typename T>
T MeanSquaredDistance(const std::vector<Eigen::Matrix<T, 2, 1>>& exo_knee,
                      const std::vector<Eigen::Vector2d>& human_knee) {
  return MeanSquaredMisalignment(exo_knee, human_knee, std::vector<double>(human_knee.size(), 1.0));
}

// mean(|v|²).
inline double MeanSquare(const std::vector<Eigen::Vector2d>& vectors) {
  double sum = 0;
  for (const Eigen::Vector2d& v : vectors) sum += v.squaredNorm();
  return sum / static_cast<double>(vectors.size());
}

}  // namespace lake::compare
