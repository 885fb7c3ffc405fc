// The board as OpenCV's aruco module knows it.
#pragma once

#include <opencv2/aruco/charuco.hpp>

#include "lake/camera/board.h"

namespace lake::camera {

cv::Ptr<cv::aruco::Dictionary> PredefinedDictionary(const Board& board);

// Its frame has x right and y down from the top left corner of the whole board; its corners are numbered from the top.
cv::Ptr<cv::aruco::CharucoBoard> CharucoOf(const Board& board);

}  // namespace lake::camera
