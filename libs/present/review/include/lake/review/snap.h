// The marker near a place that somebody pointed at, measured as the tracker measures it.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "lake/tracking/marker_detector.h"

namespace lake::review {

// Of a marker that has no kind: the patch that it is in this picture, at this place. Throws Error where the picture is
// even there.
tracking::DetectorMaker DetectorOfPatch(const cv::Mat& luma, const Eigen::Vector2d& place);

// The nearest detection within `reach_px`; nullopt if there is none. `frame` has its luma; its colours are asked for if
// the detector needs them.
std::optional<tracking::MarkerDetection> SnapToMarker(video::VideoFrame frame, const Eigen::Vector2d& place,
                                                      double reach_px, const tracking::DetectorMaker& make_detector,
                                                      const std::function<cv::Mat()>& colours);

}  // namespace lake::review
