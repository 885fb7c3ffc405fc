// Finding the leg among tracklets.
#pragma once

#include <optional>
#include <vector>

#include "rigidity.h"

namespace lake::tracking {

// Tracklets of ankle, knee, hip and, for four, waist.
struct LegChain {
  std::vector<std::size_t> tracklets;
  double cost = 0;  // minus twice a log likelihood, up to a constant
};

struct LegChainOptions {
  std::size_t markers = 4;                        // 3: without waist
  std::vector<std::optional<std::size_t>> fixed;  // a marker that is known already, per marker
  std::vector<std::size_t> excluded;              // tracklets that have other names
  Eigen::Vector2d up = {0, 1};                    // in metric units
  double least_frames = 0;                        // in which ankle and knee, and knee and hip, are seen together
};

// All chains that can be a leg, the best first.
std::vector<LegChain> FindLegChains(const MetricTracklets& tracklets, const LegChainOptions& options);

// The first chain that says something else than `chains.front()` (another tracklet for a marker at the same time) and
// is nearly as good; nullptr if there is none.
const LegChain* FindRival(const MetricTracklets& tracklets, const std::vector<LegChain>& chains);

}  // namespace lake::tracking
