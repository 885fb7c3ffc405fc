// The one-to-one assignment of least total cost.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace lake::tracking {

// For each row of a cost matrix the column it gets, -1 for none. A pair whose cost is not below `forbidden` is never
// made; leaving a row without a column costs `forbidden`. Hungarian algorithm with potentials, O(n³) (Kuhn 1955; Jonker
// & Volgenant 1987).
std::vector<int> AssignRows(const Eigen::MatrixXd& cost, double forbidden);

}  // namespace lake::tracking
