// The figure of one trial: marker paths, knee angle with its uncertainty, events, gaps. lake-track's track.png and
// lake-gait's gait.png.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/gait/leg_fit.h"

namespace lake::figure {

// Another program's knee angle in the same frames; none where it is empty.
struct OtherAngle {
  std::string name = {};
  std::vector<double> angle_deg = {};
};

// PNG or SVG by the extension. Left: the paths in the leg frame's axes, with the leg at a few moments of the first
// repetition; right: the knee angle with the markers' own angle frame by frame, then the difference of the two with the
// band of ± 2 SD. Events are vertical lines; frames in which ankle, knee or hip was not seen are shaded. Throws Error
// if it cannot be drawn.
void DrawLegFigure(const std::filesystem::path& path, const gait::LegFitResult& result, const OtherAngle& other = {});

}  // namespace lake::figure
