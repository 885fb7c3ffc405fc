// The kinds of markers that can be tracked: a row each. Not part of the interface.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "lake/tracking/track_markers.h"

namespace lake::tracking {

struct DetectorKind {
  // How it measures a marker that a person points at: near the click, anywhere in the picture, not at all.
  enum class Click { kNear, kAnywhere, kNot };

  const char* name;
  DetectorMaker (*prepare)(const std::filesystem::path& video, const TrackOptions& options);
  std::vector<int> (*identities)(const TrackOptions& options);  // that it gives to the names; empty: none
  void (*check)(const TrackOptions& options);                   // throws UsageError naming the option that cannot be
  Click click;
};

std::span<const DetectorKind> DetectorKinds();
const DetectorKind& KindOf(const TrackOptions& options);

// 0, 1, … of the names in order.
std::vector<int> IdentitiesInOrder(const TrackOptions& options);

// The decoder's own chroma beside the luma.
video::VideoReaderOptions WithChroma(video::VideoReaderOptions options);

}  // namespace lake::tracking
