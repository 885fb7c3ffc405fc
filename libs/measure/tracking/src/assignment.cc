#include "lake/tracking/assignment.h"

#include <algorithm>
#include <limits>

namespace lake::tracking {

std::vector<int> AssignRows(const Eigen::MatrixXd& cost, double forbidden) {
  const int rows = static_cast<int>(cost.rows()), real_columns = static_cast<int>(cost.cols());
  // Every row has a column of its own for "none", so that a full assignment exists.
  const int columns = real_columns + rows;
  const auto at = [&](int row, int column) {
    if (column < real_columns) return std::min(cost(row, column), 2 * forbidden);
    return column - real_columns == row ? forbidden : 2 * forbidden;
  };
  std::vector<double> row_potential(rows + 1), column_potential(columns + 1);
  std::vector<int> row_of(columns + 1, 0), way(columns + 1, 0);  // counted from 1; 0 is none
  for (int row = 1; row <= rows; ++row) {
    row_of[0] = row;
    int column = 0;
    std::vector<double> least(columns + 1, std::numeric_limits<double>::infinity());
    std::vector<bool> used(columns + 1, false);
    do {
      used[column] = true;
      int next = 0;
      double delta = std::numeric_limits<double>::infinity();
      for (int j = 1; j <= columns; ++j) {
        if (used[j]) continue;
        const double reduced = at(row_of[column] - 1, j - 1) - row_potential[row_of[column]] - column_potential[j];
        if (reduced < least[j]) {
          least[j] = reduced;
          way[j] = column;
        }
        if (least[j] < delta) {
          delta = least[j];
          next = j;
        }
      }
      for (int j = 0; j <= columns; ++j) {
        if (used[j]) {
          row_potential[row_of[j]] += delta;
          column_potential[j] -= delta;
        } else
          least[j] -= delta;
      }
      column = next;
    } while (row_of[column] != 0);
    for (; column != 0; column = way[column]) row_of[column] = row_of[way[column]];
  }
  std::vector<int> assigned(rows, -1);
  for (int j = 1; j <= real_columns; ++j)
    if (row_of[j] > 0 && cost(row_of[j] - 1, j - 1) < forbidden) assigned[row_of[j] - 1] = j - 1;
  return assigned;
}

}  // namespace lake::tracking
