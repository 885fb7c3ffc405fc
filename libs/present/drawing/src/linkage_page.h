// The page that pose pictures and the animation share. As one of a series a label stays where it was, beside what it
// names, while its place there is free. `labels`: of the page before, then of this one.
#pragma once

#include "label_places.h"
#include "lake/drawing/linkage_figures.h"
#include "lake/figure/gnuplot.h"

namespace lake::drawing {

inline constexpr int kPosePageWidth_px = 1280, kPosePageHeight_px = 720;

void DrawPosePage(figure::GnuplotFigure& figure, const LinkageLook& look, const linkage::Pose& pose,
                  LabelPlaces& labels);
void DrawLinkagePose(const std::filesystem::path& path, const LinkageLook& look, const linkage::Pose& pose,
                     LabelPlaces& labels);

}  // namespace lake::drawing
