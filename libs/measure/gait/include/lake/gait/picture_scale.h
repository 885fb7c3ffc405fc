// How positions in a picture get their lengths: the options --camera and --scale of all programs that read some.
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

  bool IsGiven() const { return camera || scale; }
};

void Describe(PictureScale& o, OptionList& options);

using Warn = std::function<void(const std::string&)>;

// mm per px of the scale bar, its ends freed from the lens's distortion if that is known; nullopt without a bar, and,
// with a warning, where the plane is calibrated. Throws UsageError for a bar without a length.
std::optional<double> MmPerPx(const PictureScale& picture, const std::optional<camera::CameraProfile>& profile,
                              const Warn& warn);

// The view of a recording in px whose picture's size is not known. `mm_per_px`: of the recording's own file, where no
// bar is given. Throws Error as camera::ReadCameraProfile, and for positions outside the picture that the camera was
// calibrated with.
LegView ViewOf(const PictureScale& picture, const motion::MarkerRecording& recording, std::optional<double> mm_per_px,
               const Warn& warn);

}  // namespace lake::gait
