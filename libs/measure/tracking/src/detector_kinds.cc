#include "detector_kinds.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "lake/core/error.h"

namespace lake::tracking {

// Each in its detector's source.
DetectorKind ReflectiveKind();
DetectorKind ColorKind();
DetectorKind TemplateKind();
DetectorKind ArucoKind();

std::span<const DetectorKind> DetectorKinds() {
  static const std::array kKinds = {ReflectiveKind(), ColorKind(), TemplateKind(), ArucoKind()};
  return kKinds;
}

const DetectorKind& KindOf(const TrackOptions& options) {
  const auto found =
      std::ranges::find_if(DetectorKinds(), [&](const DetectorKind& kind) { return options.detector == kind.name; });
  if (found == DetectorKinds().end()) throw UsageError("--detector {}: there is none of this name", options.detector);
  return *found;
}

std::vector<std::string> DetectorNames() {
  std::vector<std::string> names;
  for (const DetectorKind& kind : DetectorKinds()) names.emplace_back(kind.name);
  return names;
}

DetectorMaker ClickDetector(const std::filesystem::path& video, const TrackOptions& options) {
  const DetectorKind& kind = KindOf(options);
  if (kind.click == DetectorKind::Click::kNot) return {};
  DetectorMaker make = kind.prepare(video, options);
  if (kind.click == DetectorKind::Click::kNear) return make;
  return [make = std::move(make)](const DetectorRegion&) { return make({}); };
}

std::vector<int> IdentitiesInOrder(const TrackOptions& options) {
  std::vector<int> identities(options.names.size());
  std::iota(identities.begin(), identities.end(), 0);
  return identities;
}

video::VideoReaderOptions WithChroma(video::VideoReaderOptions options) {
  options.preview_max_width_px = std::numeric_limits<int>::max();
  options.luma_too = options.preview_as_stored = true;
  return options;
}

}  // namespace lake::tracking
