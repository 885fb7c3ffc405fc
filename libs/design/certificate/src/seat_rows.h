// The clearance of the linkage from a seat (linkage/wear.h) in the pose of sitting, over a box of links: a part of two
// pins is clear of the seat's corner if for some separating direction h in [0, pi / 2]
//   cos h (surface - x) + sin h (edge - y) >= clearance + radius        for both pins.
#pragma once

#include "lake/problem/problem.h"
#include "pose_slopes.h"

namespace lake::certificate {

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

}  // namespace lake::certificate
