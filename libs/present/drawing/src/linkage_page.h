// The page that pose pictures and the animation share.
#pragma once

#include "lake/drawing/linkage_figures.h"
#include "lake/figure/gnuplot.h"

namespace lake::drawing {

inline constexpr int kPosePageWidth_px = 1280, kPosePageHeight_px = 720;

// `labels`: of the page before, then of this one.
void DrawPosePage(figure::GnuplotFigure& figure, const LinkageLook& look, const linkage::Pose& pose,
                  LabelPlaces& labels);

}  // namespace lake::drawing
