// A bound on theta(X, d_min) over a box from all requirements together: each becomes linear inequalities that hold in
// the box (cuts.h), and a linear program bounds theta by them. Their error falls with the square of the box, so boxes
// about an optimum that several limits hold need few splits.
#pragma once

#include <array>

#include "lake/certificate/interval.h"
#include "lake/problem/problem.h"
#include "pose_slopes.h"

namespace lake::certificate {

// Bounds theta(X, d_min) from above on a box of links; the mathematics is in the room's README.

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

// The clearance of the linkage from a seat (linkage/wear.h) in the pose of sitting, over a box of links: a part of two
// pins is clear of the seat's corner if for some separating direction h in [0, pi / 2]
//   cos h (surface - x) + sin h (edge - y) >= clearance + radius        for both pins.
class SeatRows {
 public:
  explicit SeatRows(const problem::SynthesisProblem& problem);

  // Rows that are >= 0 where the seat is clear, over a box and at its anchor. nullopt: nowhere in the box.
  struct Row {
    Slope over_box;
    Interval at_anchor;
  };
  std::optional<std::vector<Row>> Over(const PoseSlopes& pose, const PoseSlopes& at_anchor) const;

 private:
  struct Place {
    Slope below, behind;  // surface - x, edge - y
  };
  Place PlaceOf(linkage::Pin pin, const PoseSlopes& pose) const;
  // The directions for which both pins may be clear; empty if there are none.
  static Interval Directions(const Place& from, const Place& to, double distance_mm);

  linkage::WearOptions wear_;
  Interval surface_mm_, edge_mm_;  // in the frame of the exoskeleton
  double clearance_mm_;
};

class Relaxation {
 public:
  // `floor_rad`: what is looked for has at least this knee angle; -infinity: anything. `range` must outlive it.
  Relaxation(const problem::SynthesisProblem& problem, const RangeBound& range, double floor_rad);

  struct Result {
    LinkBox box;                        // without what is known to violate a requirement, or to be below the floor
    double bound_rad;                   // of what is left
    std::optional<std::size_t> widest;  // the link that contributes most to the bound's excess; none: not known
  };
  // nullopt if nothing is left.
  std::optional<Result> Examine(const LinkBox& box) const;

 private:
  struct Place {
    Interval kappa_rad;
    std::vector<PoseRow> rows;
  };
  struct Cuts;

  void AddPlaces(const problem::SynthesisProblem& problem, double floor_rad);
  void AddSamples(const problem::SynthesisProblem& problem, const std::vector<problem::Requirement>& requirements,
                  double floor_rad);
  std::vector<PoseRow> RowsOverRange(const problem::SynthesisProblem& problem) const;
  bool AddCuts(const Region& region, const Interval& phi_rad, Cuts& cuts) const;
  bool AddSeated(const Region& region, const std::optional<Region>& point, Cuts& cuts) const;
  void AddBarAngle(const Region& region, const Interval& phi_rad, Cuts& cuts) const;
  void AddMount(const AxisBox& box, const Interval& phi_rad, const AxisPoint& at, Cuts& cuts) const;
  bool AddPose(const PoseSlopes& pose, const std::optional<PoseSlopes>& at_anchor, const std::vector<PoseRow>& rows,
               const Region& region, Cuts& cuts) const;
  bool ContractBy(const Cuts& cuts, const LinearBound& bound, AxisBox& box) const;
  std::size_t WidestOf(const Cuts& cuts, const LinearBound& bound, const AxisBox& box) const;
  void AddLinear(const AxisBox& box, Cuts& cuts) const;
  // A design of the box that satisfies what is convex in the links, near `towards`.
  std::optional<AxisPoint> AnchorIn(const AxisBox& box, const AxisPoint& towards) const;
  bool IsInSet(const AxisPoint& at) const;

  const RangeBound& range_;
  std::vector<PoseRow> at_shortest_;
  std::vector<Place> places_;
  std::optional<SeatRows> seat_;
  Place seated_;  // rows where a person sits
  double d_min_mm_, floor_rad_;
  Margins margins_;
};

}  // namespace lake::certificate
