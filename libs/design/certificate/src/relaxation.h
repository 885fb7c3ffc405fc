// A bound on theta(X, d_min) over a box from all requirements together: each becomes linear inequalities that hold in
// the box (cuts.h), and a linear program bounds theta by them. Their error falls with the square of the box, so boxes
// about an optimum that several limits hold need few splits.
#pragma once

#include "pose_slopes.h"
#include "range_bound.h"
#include "seat_rows.h"

namespace lake::certificate {

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
  std::vector<problem::Requirement> linear_;
  std::vector<PoseRow> at_shortest_;
  std::vector<Place> places_;
  std::optional<SeatRows> seat_;
  Place seated_;  // rows where a person sits
  double d_min_mm_, floor_rad_;
  Margins margins_;
};

}  // namespace lake::certificate
