// Whether what a seed leads to behaves like the marker that it names: a seed is a hint, and a click may be a lamp's or
// the marker's beside.
#pragma once

#include <string>
#include <vector>

#include "lake/tracking/marker_detector.h"
#include "leg_chain.h"

namespace lake::tracking {

// What a seed leads to.
struct Seeded {
  std::size_t tracklet;
  const MarkerSeed* seed;
};

// A leg whose markers are all known, some of them by seeds.
struct SeededLeg {
  std::vector<std::string> names;        // from the ground up
  std::vector<std::size_t> tracklets;    // one per name
  std::vector<const MarkerSeed*> seeds;  // one per name; nullptr where the marker was found otherwise
  std::vector<Seeded> others;            // markers that are no part of the leg
  Eigen::Vector2d up = {0, 1};           // metric
};

// Throws Error naming the seed, what contradicts it, and what to do: it leads to an object that rests while the leg
// moves, to one whose distances to its neighbours in the leg change as no limb's do, or to one whose distances change
// far more than those of another object, seen at the same time, would in its place.
void CheckSeededLeg(const MetricTracklets& tracklets, const SeededLeg& leg);

// The same for a marker on the exoskeleton's knee: it moves when the leg's knee does.
void CheckSeededJoint(const MetricTracklets& tracklets, const MarkerSeed& seed, std::size_t joint, std::size_t knee);

// As it stood on the command line.
std::string SeedText(const MarkerSeed& seed);

}  // namespace lake::tracking
