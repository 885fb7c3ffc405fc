// A figure in both forms: PNG for pages, SVG for papers.
#pragma once

#include <filesystem>
#include <string>

#include "lake/core/run.h"
#include "lake/core/threads.h"

namespace lake::commands {

// Calls draw(path) for NAME.png and NAME.svg among the run's results, both at the same time: gnuplot draws them in
// processes of its own.
template <typename Draw>
void DrawPngAndSvg(const std::string& name, Run& run, const Draw& draw) {
  const std::filesystem::path png = run.Result(name + ".png"), svg = run.Result(name + ".svg");
  ForEachInThreads(2, 2, [&](std::size_t i) { draw(i == 0 ? png : svg); });
}

}  // namespace lake::commands
