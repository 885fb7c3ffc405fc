// Boards in files: images of a board, or a video of a moving one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/camera/board.h"

namespace lake::camera {

struct BoardPicturesOptions {
  double attempts_per_s = 10;  // frames of a video in which the board is looked for
  int most_views = 25;         // of a video
  double most_missing = 0.5;   // fraction of images without a board: beyond it the run fails
  bool quiet = false;          // no progress
};

struct BoardPictures {
  int width_px = 0, height_px = 0;
  std::vector<BoardView> views;
  std::vector<std::string> without_board;  // images in which it was not seen
  int attempts = 0;                        // frames of a video in which it was looked for
  int seen = 0;                            // of them with a board; `views` are the sharp, spread ones
};

// Reads images, or one video (or image sequence as a printf pattern). Throws Error: a file that cannot be read,
// pictures of different sizes, too many images without the board (naming them), no board at all.
BoardPictures FindBoards(const std::vector<std::filesystem::path>& files, const Board& board,
                         const BoardPicturesOptions& options = {});

// Sharp views that differ most from one another, in the order of the video: those blurred more than half beyond the
// sharpest quarter are left out, then the view that is farthest from those chosen is added until there are `most`. The
// distance of two views is that of the board's four outer corners in the picture.
std::vector<BoardView> ChooseSpreadViews(const Board& board, std::vector<BoardView> views, int most);

}  // namespace lake::camera
