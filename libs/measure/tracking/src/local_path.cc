#include "local_path.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace lake::tracking {

PathPoint LocalPath::Fit() const {
  constexpr int kMost = 5;  // coefficients
  using Powers = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;
  double span_s = 0;
  for (const Sample& sample : samples_) span_s = std::max(span_s, std::abs(sample.since_s));
  const int n = degree_ + 1;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost> normal(n, n);
  Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMost, 2> right(n, 2);
  normal.setZero();
  right.setZero();
  bool any_at = false;
  for (const Sample& sample : samples_) {
    Powers powers(n);
    powers[0] = 1;
    for (int k = 1; k < n; ++k) powers[k] = powers[k - 1] * sample.since_s / span_s;
    normal += powers * powers.transpose();
    right += powers * sample.position.transpose();
    any_at |= sample.since_s == 0;
  }
  const auto solver = normal.ldlt();
  const Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMost, 2> c = solver.solve(right);
  PathPoint point{c.row(0), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), 0};
  if (degree_ >= 1) point.velocity = c.row(1) / span_s;
  if (degree_ >= 2) point.acceleration = 2 * c.row(2) / (span_s * span_s);
  double squares = 0;
  for (const Sample& sample : samples_) {
    Eigen::RowVector2d on_path = c.row(degree_);
    for (int k = degree_; k-- > 0;) on_path = on_path * (sample.since_s / span_s) + c.row(k);
    squares += (sample.position.transpose() - on_path).squaredNorm();
  }
  point.off_px = std::sqrt(squares / static_cast<double>(samples_.size()));
  if (any_at) point.own_weight = solver.solve(Powers::Unit(n, 0))[0];
  return point;
}

}  // namespace lake::tracking
