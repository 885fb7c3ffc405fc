// The short texts in which a command line and a study file say how a video is to be tracked.
#pragma once

#include <opencv2/core/types.hpp>
#include <span>
#include <string>

#include "lake/tracking/track_markers.h"

namespace lake::commands {

// reflective, color, template or aruco. Throws UsageError.
tracking::DetectorKind ParseDetector(const std::string& text);

// bright or dark. Throws UsageError.
tracking::Polarity ParsePolarity(const std::string& text);

// NAME=X,Y[@FRAME], a place in px, or NAME=#N, the number of a candidate. Throws UsageError.
tracking::MarkerSeed ParseSeed(const std::string& text);

// X,Y,W,H. Throws UsageError unless they are whole px with a positive width and height.
cv::Rect CropOf(std::span<const double> numbers);

}  // namespace lake::commands
