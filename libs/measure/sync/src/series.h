// Signals on an even grid of times, low-passed: what movements are compared by. Not part of the interface.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lake/sync/movement.h"

namespace lake::sync {

struct Series {
  double start_s = 0, step_s = 1;
  Eigen::MatrixXd value = {};             // a row to each time, 0 where not known
  std::vector<unsigned char> known = {};  // of all columns

  Eigen::Index Rows() const { return value.rows(); }
  double TimeAt(Eigen::Index row) const { return start_s + step_s * static_cast<double>(row); }
};

// Columns of a recording at multiples of `step_s`; where its samples lie farther apart than `gap_s` nothing is known.
Series Sample(const std::vector<double>& time_s, const Eigen::MatrixXd& values, double cutoff_hz, double step_s);

// By central differences over two steps to each side.
Series Derivative(const Series& series);

// Every `stride`th time.
Series Thinned(const Series& series, Eigen::Index stride);

// Values and their slopes between the times, cubic; false where not known.
bool ValuesAt(const Series& series, double time_s, Eigen::RowVectorXd& value, Eigen::RowVectorXd& slope);

}  // namespace lake::sync
