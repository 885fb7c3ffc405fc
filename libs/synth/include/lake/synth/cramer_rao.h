// How well a marker could be located at best.
#pragma once

#include <string>

#include "lake/synth/scene.h"

namespace lake::synth {

// The Cramér–Rao bound of a marker's position in one frame, as recorded without compression: standard deviation in px
// per axis (x, y).
//
// The noise is the rendering's own (NoiseVariance at each pixel, rounding included; pixels that saturate count by the
// information that a clipped normal value keeps). Everything but the two coordinates is taken as known: radius, level,
// point-spread, what lies behind. For a symmetric marker before an even background, estimating those too does not
// change the bound, as they move the picture evenly and the position oddly. Derivatives are central differences of
// noise-free renderings. Throws Error if the marker is outside the picture or cannot be located at all (wholly hidden).
Eigen::Vector2d CramerRaoBound(const Scene& scene, int frame, const std::string& marker);

}  // namespace lake::synth
