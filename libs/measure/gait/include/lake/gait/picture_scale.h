// How positions in a picture get their lengths: the options --camera, --scale and --plane-points of all programs that
// read some.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "lake/core/options.h"
#include "lake/gait/leg_view.h"

namespace lake::gait {

struct PictureScale {
  std::optional<std::filesystem::path> camera;  // camera.yaml
  std::optional<std::array<double, 5>> scale;   // x1 y1 x2 y2 in px, length in mm
  std::string plane_points;                     // as camera::ParsePlanePoints reads it
  MarkerDepths depths;                          // an option of its own, --depth
  double pixel_aspect = 1;                      // width over height of a pixel: no option, but what the video says

  bool IsGiven() const { return camera || scale || !plane_points.empty(); }
  const char* OptionName() const { return camera ? "--camera" : scale ? "--scale" : "--plane-points"; }
  bool operator==(const PictureScale&) const = default;
};

void Describe(PictureScale& o, OptionList& options);

// The same of another recording beside it, as --exo-camera with the prefix `exo`; `whose`: "the exoskeleton trial".
// Where none of them is given, it is for the program to take what holds for the first recording.
void DescribeOther(const std::string& prefix, const std::string& whose, PictureScale& o, OptionList& options);

using Warn = std::function<void(const std::string&)>;

// The view of a camera with this profile, if there is one. Its calibrated plane holds; else known points give the
// plane, through the lens where that is known; else a scale bar, its ends freed from the lens's distortion, gives mm
// per px, else `mm_per_px` does. What is not used is said by a warning. Throws UsageError for a bar without a length,
// Error as camera::FitPlane and camera::PlaneHomography.
LegView MakeView(const PictureScale& picture, const std::optional<camera::CameraProfile>& profile,
                 std::optional<double> mm_per_px, const Warn& warn);

// The view of a recording in px whose picture's size is not known. `mm_per_px`: of the recording's own file, where no
// bar is given. Throws Error as camera::ReadCameraProfile, and for positions outside the picture that the camera was
// calibrated with.
LegView ViewOf(const PictureScale& picture, const motion::MarkerRecording& recording, std::optional<double> mm_per_px,
               const Warn& warn);

}  // namespace lake::gait
