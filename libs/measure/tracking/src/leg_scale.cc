#include "leg_scale.h"

#include <cmath>
#include <string_view>
#include <vector>

#include "lake/core/statistics.h"
#include "lake/tracking/naming.h"

namespace lake::tracking {

double MillimetresPerPx(const motion::MarkerRecording& recording) {
  constexpr double kLeg_mm = 850;
  const auto length_px = [&](std::string_view from, std::string_view to) {
    const motion::MarkerTrack *a = recording.Find(from), *b = recording.Find(to);
    std::vector<double> lengths;
    for (std::size_t i = 0; a && b && i < recording.Frames(); ++i)
      if (a->samples[i].IsKnown() && b->samples[i].IsKnown())
        lengths.push_back((b->samples[i].position - a->samples[i].position).norm());
    return lengths.empty() ? INFINITY : Median(std::move(lengths));
  };
  return kLeg_mm / (length_px(kLegMarkers[0], kLegMarkers[1]) + length_px(kLegMarkers[1], kLegMarkers[2]));
}

}  // namespace lake::tracking
