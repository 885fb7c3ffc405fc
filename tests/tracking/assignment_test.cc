#include "lake/tracking/assignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace lake {
namespace {

constexpr double kForbidden = 1.0;

// Each row with a column below `forbidden`, or none at the price of `forbidden`.
double TotalCost(const Eigen::MatrixXd& cost, const std::vector<int>& columns) {
  double total = 0;
  for (std::size_t row = 0; row < columns.size(); ++row)
    total += columns[row] < 0 ? kForbidden : cost(static_cast<Eigen::Index>(row), columns[row]);
  return total;
}

double LeastCost(const Eigen::MatrixXd& cost, Eigen::Index row, unsigned taken) {
  if (row == cost.rows()) return 0;
  double least = kForbidden + LeastCost(cost, row + 1, taken);
  for (Eigen::Index column = 0; column < cost.cols(); ++column)
    if (!(taken >> column & 1) && cost(row, column) < kForbidden)
      least = std::min(least, cost(row, column) + LeastCost(cost, row + 1, taken | 1u << column));
  return least;
}

TEST(Assignment, IsTheCheapestOfAll) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> side(0, 6);
  std::uniform_real_distribution<double> level(0, 1.5);  // a third is forbidden
  for (int trial = 0; trial < 400; ++trial) {
    Eigen::MatrixXd cost(side(random), side(random));
    for (Eigen::Index i = 0; i < cost.size(); ++i) cost.data()[i] = level(random);
    const std::vector<int> columns = tracking::AssignRows(cost, kForbidden);
    ASSERT_EQ(columns.size(), static_cast<std::size_t>(cost.rows()));
    unsigned taken = 0;
    for (std::size_t row = 0; row < columns.size(); ++row) {
      if (columns[row] < 0) continue;
      ASSERT_LT(columns[row], cost.cols());
      ASSERT_FALSE(taken >> columns[row] & 1) << "a column twice";
      taken |= 1u << columns[row];
      ASSERT_LT(cost(static_cast<Eigen::Index>(row), columns[row]), kForbidden);
    }
    ASSERT_NEAR(TotalCost(cost, columns), LeastCost(cost, 0, 0), 1e-12) << cost;
  }
}

}  // namespace
}  // namespace lake
