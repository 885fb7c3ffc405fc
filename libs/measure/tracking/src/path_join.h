// Whether what is seen before a gap and what is seen after it may be one marker.
#pragma once

#include <vector>

#include "lake/dynamics/marker_path.h"
#include "lake/tracking/marker_physics.h"
#include "lake/tracking/tracklet.h"

namespace lake::tracking {

// Times and places, px, of one object beside a gap: the farthest first, those of repeated pictures left out. Eight tell
// as much as more do. Their sigmas are
// not used: a place is as uncertain as coding and the clock make it.
using PathEnd = std::vector<dynamics::PathSample>;
inline constexpr std::size_t kPathEndSamples = 8;

PathEnd FirstSamples(const Tracklet& tracklet);
PathEnd LastSamples(const Tracklet& tracklet);

struct PathJoin {
  // Squared distance of the two sides' positions, velocities and accelerations over what a quick movement makes
  // possible in between: 6 on average, beyond 22.5 in one of a thousand (χ²).
  double squares = 0;
  double log_odds = 0;  // of one path against two unrelated ones within a person's reach
};

double GapBetween(const PathEnd& before, const PathEnd& after);  // s

// Both ends need one sample. A gap counts for no longer than a marker goes on before it turns back.
PathJoin JoinPaths(const PathEnd& before, const PathEnd& after, double gap_s, double radius_px,
                   const MarkerPhysics& physics);

}  // namespace lake::tracking
