#include "cuts.h"

#include <algorithm>
#include <cmath>

namespace lake::certificate {
namespace {

// constant + sum of multipliers x cuts.
Cut Combined(const Cut& goal, const std::vector<Cut>& cuts, const std::vector<double>& multipliers) {
  Interval constant = goal.constant;
  std::array<Interval, kAxes> coefficients;
  for (std::size_t j = 0; j < kAxes; ++j) coefficients[j] = goal.coefficients[j];
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    if (multipliers[i] == 0) continue;
    constant = constant + multipliers[i] * Interval(cuts[i].constant);
    for (std::size_t j = 0; j < kAxes; ++j)
      coefficients[j] = coefficients[j] + multipliers[i] * Interval(cuts[i].coefficients[j]);
  }
  Cut combined;
  combined.constant = constant.upper;
  for (std::size_t j = 0; j < kAxes; ++j) combined.coefficients[j] = coefficients[j].upper;
  return combined;
}

// How far the box reaches from the lower ends that cuts count from.
AxisBox DistancesFrom(const AxisBox& lower_ends, const AxisBox& box) {
  AxisBox distances;
  for (std::size_t j = 0; j < kAxes; ++j) distances[j] = box[j] - Interval(lower_ends[j].lower);
  return distances;
}

// What one axis adds to a cut at most.
Interval MostOf(double coefficient, const Interval& distance) {
  return Interval(coefficient) * (coefficient > 0 ? distance.upper : distance.lower);
}

Interval Largest(const Cut& cut, const AxisBox& distances) {
  Interval largest = cut.constant;
  for (std::size_t j = 0; j < kAxes; ++j)
    if (cut.coefficients[j] != 0) largest = largest + MostOf(cut.coefficients[j], distances[j]);
  return largest;
}

// The dual of  max goal . z  s.t. cuts >= 0, 0 <= z <= 1  by the simplex method on a full tableau: one row per axis and
// one column per cut, so it is small, and its first basis is at hand. z = y / width.
//   min  sum k_i m_i + sum p_j     s.t.  p_j - q_j - sum_i a_ij m_i = c_j,   m, p, q >= 0
class DualSimplex {
 public:
  DualSimplex(const Cut& goal, const std::vector<Cut>& cuts, const AxisBox& box)
      : cuts_(cuts.size()), columns_(cuts.size() + 2 * kAxes + 1), tableau_((kAxes + 1) * columns_, 0.0) {
    for (std::size_t j = 0; j < kAxes; ++j) {
      const double width = box[j].Width();
      const double sign = goal.coefficients[j] * width >= 0 ? 1 : -1;  // rows are turned so that the basis is positive
      for (std::size_t i = 0; i < cuts_; ++i) At(j, i) = -sign * cuts[i].coefficients[j] * width;
      At(j, P(j)) = sign;
      At(j, Q(j)) = -sign;
      At(j, columns_ - 1) = sign * goal.coefficients[j] * width;
      basis_[j] = sign > 0 ? P(j) : Q(j);
    }
    for (std::size_t i = 0; i < cuts_; ++i) At(kAxes, i) = cuts[i].constant;
    for (std::size_t j = 0; j < kAxes; ++j) At(kAxes, P(j)) = 1;
    for (std::size_t j = 0; j < kAxes; ++j)
      if (basis_[j] == P(j)) Subtract(kAxes, j, 1);
  }

  // False if it is unbounded: the multipliers are then those of a proof that the cuts contradict each other.
  bool Solve() {
    constexpr int kMostPivots = 200;
    constexpr double kNothing = 1e-12;
    for (int pivot = 0; pivot < kMostPivots; ++pivot) {
      std::size_t entering = columns_;
      double least = -kNothing;
      for (std::size_t c = 0; c + 1 < columns_; ++c)
        if (At(kAxes, c) < least) {
          least = At(kAxes, c);
          entering = c;
        }
      if (entering == columns_) break;
      std::size_t leaving = kAxes;
      double least_ratio = kInfinity;
      for (std::size_t r = 0; r < kAxes; ++r)
        if (At(r, entering) > kNothing && At(r, columns_ - 1) / At(r, entering) < least_ratio) {
          least_ratio = At(r, columns_ - 1) / At(r, entering);
          leaving = r;
        }
      if (leaving == kAxes) {
        ray_ = entering;
        return false;
      }
      Pivot(leaving, entering);
    }
    return true;
  }

  // Of the solution, or of the ray along which it is unbounded.
  std::vector<double> Multipliers() const {
    std::vector<double> multipliers(cuts_, 0.0);
    for (std::size_t r = 0; r < kAxes; ++r)
      if (basis_[r] < cuts_) multipliers[basis_[r]] = std::max(0.0, ray_ ? -At(r, *ray_) : At(r, columns_ - 1));
    if (ray_ && *ray_ < cuts_) multipliers[*ray_] = 1;
    return multipliers;
  }

  // z.
  std::array<double, kAxes> Optimum() const {
    std::array<double, kAxes> z{};
    for (std::size_t j = 0; j < kAxes; ++j) z[j] = std::clamp(At(kAxes, Q(j)), 0.0, 1.0);
    return z;
  }

 private:
  double& At(std::size_t row, std::size_t column) { return tableau_[row * columns_ + column]; }
  double At(std::size_t row, std::size_t column) const { return tableau_[row * columns_ + column]; }
  std::size_t P(std::size_t axis) const { return cuts_ + axis; }
  std::size_t Q(std::size_t axis) const { return cuts_ + kAxes + axis; }

  void Subtract(std::size_t row, std::size_t other, double factor) {
    if (factor == 0) return;
    for (std::size_t c = 0; c < columns_; ++c) At(row, c) -= factor * At(other, c);
  }
  void Pivot(std::size_t row, std::size_t column) {
    const double by = At(row, column);
    for (std::size_t c = 0; c < columns_; ++c) At(row, c) /= by;
    for (std::size_t r = 0; r <= kAxes; ++r)
      if (r != row) Subtract(r, row, At(r, column));
    basis_[row] = column;
  }

  std::size_t cuts_, columns_;
  std::vector<double> tableau_;
  std::array<std::size_t, kAxes> basis_{};
  std::optional<std::size_t> ray_;
};

}  // namespace

AxisBox BoxOf(const AxisPoint& point) {
  AxisBox box;
  std::copy(point.begin(), point.end(), box.begin());
  return box;
}

std::optional<Cut> UpperCut(const Slope& slope, const Interval& at_anchor, const AxisPoint& anchor,
                            const AxisBox& box) {
  if (at_anchor.IsEmpty()) return std::nullopt;
  Cut cut;
  Interval constant = at_anchor;
  for (std::size_t j = 0; j < kAxes; ++j) {
    const Interval& by = slope.by[j];
    if (!std::isfinite(by.lower) || !std::isfinite(by.upper)) return std::nullopt;
    if (by.lower == 0 && by.upper == 0) continue;
    const Interval below = Interval(anchor[j]) - box[j].lower, above = Interval(box[j].upper) - anchor[j];
    const double width = below.upper + above.upper;
    const double chord = width > 0 ? (by.upper * above.upper + by.lower * below.upper) / width : 0;
    // Both ends lie on the chord but for rounding; between them what is convex lies below.
    constant = constant + Max(-(by.lower * below), by.upper * above - chord * (below + above));
    cut.coefficients[j] = chord;
    cut.spread[j] = by.Width() * box[j].Width();
  }
  cut.constant = constant.upper;
  return std::isfinite(cut.constant) ? std::optional(cut) : std::nullopt;
}

bool Contract(const Cut& cut, const AxisBox& lower_ends, AxisBox& box) {
  const AxisBox distances = DistancesFrom(lower_ends, box);
  const Interval largest = Largest(cut, distances);
  if (largest.upper < 0) return false;
  if (!std::isfinite(largest.upper)) return true;
  for (std::size_t j = 0; j < kAxes; ++j) {
    const double coefficient = cut.coefficients[j];
    if (coefficient == 0) continue;
    const Interval others = largest - MostOf(coefficient, distances[j]);
    const Interval end = Interval(lower_ends[j].lower) - Interval(others.upper) / Interval(coefficient);
    if (coefficient > 0)
      box[j].lower = std::max(box[j].lower, end.lower);
    else
      box[j].upper = std::min(box[j].upper, end.upper);
    if (box[j].IsEmpty()) return false;
  }
  return true;
}

LinearBound BoundBy(const Cut& goal, const std::vector<Cut>& cuts, const AxisBox& box) {
  const AxisBox distances = DistancesFrom(box, box);
  DualSimplex simplex(goal, cuts, box);
  const bool is_bounded = simplex.Solve();
  LinearBound bound;
  bound.multipliers = simplex.Multipliers();
  if (!is_bounded && Largest(Combined(Cut{}, cuts, bound.multipliers), distances).upper < 0) {
    bound.upper = -kInfinity;
    return bound;
  }
  if (!is_bounded) bound.multipliers.assign(cuts.size(), 0.0);
  bound.optimum = simplex.Optimum();
  bound.combined = Combined(goal, cuts, bound.multipliers);
  bound.upper = Largest(bound.combined, distances).upper;
  return bound;
}

}  // namespace lake::certificate
