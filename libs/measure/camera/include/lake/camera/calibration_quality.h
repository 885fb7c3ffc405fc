// Quality of a calibration: coverage of the picture, tilt of the views, agreement of two halves, and warnings with
// their causes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lake/camera/calibration.h"

namespace lake::camera {

struct Coverage {
  int columns = 0, rows = 0;               // cells of about a tenth of the picture's longer side
  std::vector<int> corners;                // seen in each cell, row by row from the top left
  double fraction = 0;                     // of cells with a corner
  double empty_left = 0, empty_right = 0;  // strips of the picture that no corner reached, as fractions of its width
  double empty_top = 0, empty_bottom = 0;  // and height
};

Coverage CoverageOf(const std::vector<BoardView>& views, int width_px, int height_px);

// The difference of two calibrations of one camera over the picture.
struct CameraDifference {
  int columns = 0, rows = 0;
  std::vector<Eigen::Vector2d> pixel;  // a grid over the picture, row by row from the top left
  std::vector<Eigen::Vector2d>
      difference_px;  // where b sees what a sees there, minus that pixel; NaN where a sees nothing
  double rms_px = 0, largest_px = 0;
};

// Each pixel's ray of camera a is seen through camera b after the rotation of b that brings both together best: a small
// turn of the camera and a shift of the principal point are nearly the same, and only what remains is a difference of
// the lens (the "implied transformation" of mrcal, D. Kogan; at infinity it is a rotation).
CameraDifference CompareCameras(const Camera& a, const Camera& b);

// Calibrates with the odd and with the even views alone and compares; nullopt with fewer than 6 views, or if a half has
// no solution.
std::optional<CameraDifference> CrossValidate(const Board& board, const std::vector<BoardView>& views, int width_px,
                                              int height_px, const CalibrationOptions& options = {});

// The largest angle between the planes of two views: with parallel planes focal length and distance cannot be
// distinguished apart.
double LargestTiltDeg(const CalibrationResult& result);

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

struct CalibrationQuality {
  Coverage coverage;
  std::optional<CameraDifference> cross_validation;
  double largest_tilt_deg = 0;
  std::size_t worst_view = 0;             // the largest RMS
  std::optional<TwoCameras> two_cameras;  // looked for where odd and even views disagree by far more than their RMS
  std::vector<std::string> warnings;      // each names its cause and the way out
};

CalibrationQuality AssessCalibration(const Board& board, const std::vector<BoardView>& views,
                                     const CalibrationResult& result, const CalibrationOptions& options = {});

}  // namespace lake::camera
