// Walks for renderings: drawn with known heel strikes and toe-offs, or a recorded stride repeated; on a treadmill, or
// once or several times through the picture.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lake/synth/marker_motion.h"

namespace lake::synth {

// A drawn walk: the foot strikes with the heel, lies flat, rises over the toe and swings; the hip goes at constant
// speed. Heel strikes are at (k + 0.3) strides, toe-offs `stance` strides after them, those of the other leg half a
// stride later.
struct DrawnStride {
  double stride_s = 1.1, stride_mm = 1300, stance = 0.62;
};

// The markers, mm; x from the place of the heel at the first strike, positive forward; y above the ground. `phase` in
// strides; whole numbers are heel strikes.
std::map<std::string, Eigen::Vector2d> DrawWalk(double phase, const DrawnStride& stride);

struct WalkOptions {
  double stride_s = 0;        // of a recorded motion: this much from its begin on is repeated; 0: the motion as it is
  int strides = 1;            // in a pass
  bool is_treadmill = false;  // the hip's mean travel is removed
  int passes = 1;             // through the picture, in the same direction, with a pause outside of it
  double pause_s = 1;
  // Without a recorded motion.
  DrawnStride drawn;
  std::vector<std::string> drawn_markers;  // beside ankle, knee, hip and waist: heel, toe, other_ankle, …
};

// The table's stride, from its begin on, `walk.strides` times: after each the next goes on where it ends, over up to
// 0.15 s of what the table has beyond the stride. The walk does not climb or leave its lane. Throws Error where the
// table ends less than 0.04 s after the stride.
MotionTable RepeatStride(const MotionTable& table, const WalkOptions& walk);

// Throws UsageError for a marker that it does not have.
MotionTable DrawnWalkTable(const WalkOptions& walk, motion::Facing facing);

// Removes the travel if asked for, puts the middle of the way at x = 0, and repeats the pass.
std::unique_ptr<MarkerMotion> MakeWalk(MotionTable table, const WalkOptions& walk);

// The times, after the motion's begin, at which a pass ends and the next begins.
std::vector<double> PassEnds(const MarkerMotion& motion, const WalkOptions& walk);

// Adds the marker exo_knee at a constant place in the shank frame (anterior, upward) of the knee.
void AddExoKnee(MotionTable& table, const Eigen::Vector2d& from_knee_mm);

}  // namespace lake::synth
