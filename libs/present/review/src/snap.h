// The marker near a place that somebody pointed at, measured as the tracker measures it.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "lake/tracking/marker_detector.h"

namespace lake::review {

// The nearest detection within `reach_px`, of markers brighter (or darker) than what is round them; nullopt if there is
// none.
std::optional<tracking::MarkerDetection> SnapToMarker(const cv::Mat& luma, const Eigen::Vector2d& place,
                                                      double reach_px, tracking::Polarity polarity);

}  // namespace lake::review
