// The page that pose pictures and the animation share.
#pragma once

#include "lake/render/gnuplot.h"
#include "lake/render/linkage_figures.h"

namespace lake {

inline constexpr int kPosePageWidth_px = 1280, kPosePageHeight_px = 720;

void DrawPosePage(GnuplotFigure& figure, const LinkageLook& look, const Pose& pose);

}  // namespace lake
