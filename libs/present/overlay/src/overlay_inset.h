// A piece of the recording, magnified, on the layer that is laid over it.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "overlay_layer.h"

namespace lake::overlay {

// Fills `square` of the layer with what lies within `half_px` of `centre` (px of the recording, pixel centres at whole
// numbers); black beyond its edge.
void DrawMagnified(OverlayLayer& layer, const cv::Mat& luma, const Eigen::Vector2d& centre, double half_px,
                   const cv::Rect2d& square);

}  // namespace lake::overlay
