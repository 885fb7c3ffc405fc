// ChArUco boards as OpenCV's aruco module knows them: all of this room that its version touches, the dictionaries
// aside.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "lake/camera/board.h"

namespace lake::camera {

// How many codes the board's dictionary has.
int DictionarySize(const Board& board);

// The black cells of the markers, their borders included.
std::vector<BoardRectangle> MarkerInk(const Board& board);

// Corners of a board that were found: indices into BoardCorners, increasing, and their places in px.
struct FoundCorners {
  std::vector<int> corner;
  std::vector<cv::Point2f> pixel;
};

// Of a ChArUco board of either layout: of the one in which the markers that are seen lie to one another as on the
// board. Empty where in neither most of them do. Not yet refined to fractions of a pixel.
FoundCorners FindCharuco(const cv::Mat& grey, const Board& board);

}  // namespace lake::camera
