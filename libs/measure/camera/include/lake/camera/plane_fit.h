// The sagittal plane's pose from one picture of points that lie in it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lake/camera/board.h"
#include "lake/camera/camera.h"
#include "lake/camera/homography.h"

namespace lake::camera {

struct PlaneFitOptions {
  // Least standard deviation of a point: four points leave two degrees of freedom, too few to estimate the noise. 0.05
  // px is a good corner of a board; a mouse click is 0.5 px.
  double least_sigma_px = 0.05;
};

// The second solution: from far away, a plane tilted the other way has almost the same image.
struct OtherPose {
  PlanePose camera_from_plane;
  double rms_px = 0;
  double apart_deg = 0;  // between the two planes' normals
  bool as_likely =
      false;  // its squared residuals are larger by less than 25 sigma²: five standard deviations do not tell
};

struct PlaneFit {
  PlanePose camera_from_plane;
  PlaneUncertainty uncertainty;              // of the pose, given the camera and this choice of the two poses
  double sigma_px = 0;                       // noise of one coordinate
  std::vector<Eigen::Vector2d> residual_px;  // per point, seen − predicted
  std::optional<OtherPose> other;            // where there is a second minimum
  double roll_deg = 0;                       // of the plane's x axis from the picture's, counter-clockwise
  std::vector<std::string> warnings;         // each names its cause and the way out
};

// Both solutions of T. Collins and A. Bartoli, Infinitesimal plane-based pose estimation, 2014, each refined by least
// squares of the residuals in the picture; the better one is taken. The known points define the plane frame. Throws
// Error as PlaneHomography does, and if the millimetres are mirrored (seen from the camera they must be right-handed: y
// up where x is right).
PlaneFit FitPlane(const Camera& camera, std::span<const PlaneCorrespondence> points,
                  const PlaneFitOptions& options = {});

// The same for a board that stands in the plane. The axes are those of the board's sides that are nearest to right and
// up in the picture, the origin is the inner corner that is then lower left, however the board is turned.
PlaneFit FitPlaneToBoard(const Camera& camera, const Board& board, const BoardView& view,
                         const PlaneFitOptions& options = {});

// "X,Y=XMM,YMM; …". Throws UsageError quoting the part that is wrong.
std::vector<PlaneCorrespondence> ParsePlanePoints(std::string_view text);

}  // namespace lake::camera
