// Signals on an even grid of times, low-passed: recordings are compared by these.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace lake::sync {

struct Series {
  double start_s = 0, step_s = 1;
  Eigen::MatrixXd value = {};             // a row to each time, 0 where not known
  std::vector<unsigned char> known = {};  // of all columns

  Eigen::Index Rows() const { return value.rows(); }
  double TimeAt(Eigen::Index row) const { return start_s + step_s * static_cast<double>(row); }
};

// The low-pass and the grid that two recordings share. A person's movement lies below 4 Hz; slow recordings show less.
struct Band {
  double cutoff_hz = 0, step_s = 0;
};
Band BandOf(const std::vector<double>& time_a_s, const std::vector<double>& time_b_s);

// Columns of a recording, NaN where missing, at multiples of the step; gaps of 0.25 s are bridged.
Series Sample(const std::vector<double>& time_s, const Eigen::MatrixXd& values, const Band& band);

// By central differences over two steps to each side.
Series Derivative(const Series& series);

// Every `stride`th time.
Series Thinned(const Series& series, Eigen::Index stride);

// Values and their slopes between the times, cubic; false where not known.
bool ValuesAt(const Series& series, double time_s, Eigen::RowVectorXd& value, Eigen::RowVectorXd& slope);

}  // namespace lake::sync
