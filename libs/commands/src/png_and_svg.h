// A figure in both forms: PNG for pages, SVG for papers.
#pragma once

#include <filesystem>
#include <string>

#include "lake/core/run.h"

namespace lake::commands {

// Calls draw(path) for NAME.png and NAME.svg among the run's results: the path without extension, of which
// figure::GnuplotFigure makes both.
template <typename Draw>
void DrawPngAndSvg(const std::string& name, Run& run, const Draw& draw) {
  std::filesystem::path both = run.Result(name + ".png");
  run.Result(name + ".svg");
  draw(both.replace_extension());
}

}  // namespace lake::commands
