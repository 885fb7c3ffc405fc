// The board as OpenCV's aruco module knows it.
#pragma once

#include <opencv2/aruco/charuco.hpp>

#include "lake/camera/board.h"

namespace lake {

cv::Ptr<cv::aruco::Dictionary> PredefinedDictionary(const Board& board);

// Origin at the lower left corner of the whole board, one square left of and below the Board's own.
cv::Ptr<cv::aruco::CharucoBoard> CharucoOf(const Board& board);

}  // namespace lake
