// The style of all plots, in one place: frame, grid, key and sizes of text, and how the three knees that are compared
// are drawn. The same thing has the same colour, dash and mark in every figure, so that it is known in grey too.
#pragma once

#include <fmt/format.h>

#include <string>

#include "lake/core/colours.h"

namespace lake::figure {

inline constexpr const char* kFont = "DejaVu Sans,14";  // readable where a figure is shown at half its size
inline constexpr const char* kTheme =
    "set border 3 lc rgb '#222222'; set tics nomirror out scale 0.6; set grid lc rgb '#E4E4E4' lt 1 lw 1; set key "
    "samplen 3 spacing 1.2 noautotitle\n";

struct PathStyle {
  const char* colour;
  const char* dash;
  int mark;
  double width;
};
inline constexpr PathStyle kHumanPath{colour::kHuman, "1", 7, 4};
inline constexpr PathStyle kWornPath{colour::kWorn, "(3,4)", 9, 3.5};
// The worn links, repaired: their colour, another mark.
inline constexpr PathStyle kMovedPath{colour::kWorn, "(3,4)", 11, 3.5};
inline constexpr PathStyle kOtherProgramPath{colour::kWorn, "(3,4)", 13, 3.5};
inline constexpr PathStyle kNewPath{colour::kNew, "(12,5)", 5, 3.5};

// "lw 4 dt 1 lc rgb '#C17F00'", for `with lines`.
inline std::string LineOf(const PathStyle& style) {
  return fmt::format("lw {} dt {} lc rgb '{}'", style.width, style.dash, style.colour);
}
// The same for `with points`.
inline std::string MarkOf(const PathStyle& style) {
  return fmt::format("pt {} ps 1.5 lc rgb '{}'", style.mark, style.colour);
}

}  // namespace lake::figure
