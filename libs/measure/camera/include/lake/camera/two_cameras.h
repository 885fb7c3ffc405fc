// A test whether all views are of one camera.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "lake/camera/calibration.h"

namespace lake::camera {

// Two groups of views, each of which has a camera of its own, or one camera before and after its zoom or focus changed.
struct TwoCameras {
  std::vector<std::size_t> first, second;  // indices of the views, increasing
  double rms_one_px = 0, rms_two_px = 0;   // of all corners: with the one camera, and with two
  // Whether the groups are those of the views' names or of their order, or two cameras halve the error: else it may be
  // a camera whose picture is stabilised, or a board that bends.
  bool is_certain = false;
};

// Groups by the names without their digits, by order and by chance are tried; views go to the group whose camera leaves
// them the smaller residuals, with only the board's pose free, until none changes. nullopt where two cameras are hardly
// better than one: of one camera's views the best groups lower the RMS by a tenth at the most (measured on a published
// set, 6 to 13 views), two of one model, 5 px of fx and 15 px of cx apart, by a sixth to a quarter.
std::optional<TwoCameras> FindTwoCameras(const Board& board, const std::vector<BoardView>& views,
                                         const CalibrationResult& result, const CalibrationOptions& options);

// For messages: the views of each group and its RMS.
std::string Describe(const TwoCameras& cameras, const std::vector<BoardView>& views);

}  // namespace lake::camera
