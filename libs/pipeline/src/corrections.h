#pragma once

#include <filesystem>

#include "lake/motion/marker_recording.h"

namespace lake {

// Rows of frame,marker,x_px,y_px overrule the detector; an empty x and y say that the marker is not visible. A click is
// taken to be right to half a pixel. Returns how many samples changed. Throws Error naming file and line: a marker or a
// frame that is not there, a place outside the picture.
int ApplyCorrections(const std::filesystem::path& path, int width, int height, MarkerRecording& recording);

}  // namespace lake
