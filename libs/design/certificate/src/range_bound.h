// Bounds theta(X, d_min) from above on a box of links; the mathematics is in the room's README.
#pragma once

#include <array>

#include "lake/certificate/interval.h"
#include "lake/problem/problem.h"
#include "pose_slopes.h"

namespace lake::certificate {

// l1..l6, mm.
using LinkBox = std::array<Interval, 6>;

class RangeBound {
 public:
  explicit RangeBound(const problem::SynthesisProblem& problem);

  LinkBox Root() const { return root_; }
  const std::vector<problem::Requirement>& Linear() const { return linear_; }  // requirements
  Margins Margin() const { return margins_; }

  // Removes what the constraints exclude; false if nothing is left.
  bool Contract(LinkBox& box) const;

  // No design in the box that satisfies the constraints has a larger knee angle, rad.
  double UpperBound(const LinkBox& box) const;

  struct BarAngle {
    Interval phi;
    double least;  // smallest phi of the box's feasible designs
  };
  // At d_min, of the designs of the box that satisfy the constraints.
  BarAngle BarAngleOf(const LinkBox& box) const;

 private:
  // The best l1 = max(lower bound, l3 + l4 + g - l2), and how steeply it follows l3 and l4: 0, 1 or undecided.
  struct Coupler {
    Interval l1, slope;
  };
  Coupler LeastCoupler(const LinkBox& box) const;

  LinkBox root_;
  std::vector<problem::Requirement> linear_;
  double d_min_;
  Margins margins_;
};

}  // namespace lake::certificate
