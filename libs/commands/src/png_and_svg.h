// A figure in both forms: PNG for pages, SVG for papers.
#pragma once

#include <filesystem>
#include <string>

#include "lake/core/run.h"

namespace lake::commands {

// Calls draw(path) for NAME.png and NAME.svg among the run's results.
template <typename Draw>
void DrawPngAndSvg(const std::string& name, Run& run, const Draw& draw) {
  for (const char* ending : {".png", ".svg"}) draw(run.Result(name + ending));
}

}  // namespace lake::commands
