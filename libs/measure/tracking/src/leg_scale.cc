#include "leg_scale.h"

#include <cmath>

#include "lake/tracking/naming.h"

namespace lake::tracking {

double MillimetresPerPx(const motion::MarkerRecording& recording) {
  constexpr double kLeg_mm = 850, kUnknown = 2;
  const double length_px = motion::MedianDistance(recording, kLegMarkers[0], kLegMarkers[1]) +
                           motion::MedianDistance(recording, kLegMarkers[1], kLegMarkers[2]);
  return std::isnan(length_px) ? kUnknown : kLeg_mm / length_px;
}

}  // namespace lake::tracking
