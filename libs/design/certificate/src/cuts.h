// Linear inequalities that hold over a box, and what follows from them together: a smaller box, and a bound on a linear
// function by the duality of linear programs. Multipliers come from plain floating point, the bound that they give is
// computed in verified arithmetic and holds for any multipliers >= 0 (Neumaier & Shcherbina, Math. Program. 99, 2004).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "slope.h"

namespace lake::certificate {

using AxisBox = std::array<Interval, kAxes>;

// constant + coefficients . y, y the distances from the lower ends of a box; `spread` is how wide the derivative was
// that each coefficient stands for, so what the inequality gives away grows with it.
struct Cut {
  double constant = 0;
  std::array<double, kAxes> coefficients{}, spread{};
};

using AxisPoint = std::array<double, kAxes>;
AxisBox BoxOf(const AxisPoint& point);

// A linear function nowhere below f in the box, at the points that a segment from the anchor reaches along which the
// slopes hold: f at the anchor, and for each axis the chord over the steepest of its slopes on either side (at a corner
// of the box: Araya, Trombettoni & Neveu, "A contractor based on convex interval Taylor", CPAIOR 2012). nullopt where
// the slopes are unbounded.
std::optional<Cut> UpperCut(const Slope& slope, const Interval& at_anchor, const AxisPoint& anchor, const AxisBox& box);

// Removes of the box what has cut < 0; false if nothing is left. `lower_ends`: the box that the cut was made for.
bool Contract(const Cut& cut, const AxisBox& lower_ends, AxisBox& box);

struct LinearBound {
  double upper = 0;                     // of the goal where all cuts are >= 0; -infinity: proved that they nowhere are
  Cut combined;                         // goal + sum of multipliers x cuts, which is nowhere below the goal there
  std::vector<double> multipliers;      // of the cuts
  std::array<double, kAxes> optimum{};  // of the linear program, approximately: 0 at the lower end, 1 at the upper
};
LinearBound BoundBy(const Cut& goal, const std::vector<Cut>& cuts, const AxisBox& box);

}  // namespace lake::certificate
