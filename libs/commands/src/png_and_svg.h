// Figures in both forms: PNG for pages, SVG for papers.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "lake/core/run.h"
#include "lake/core/threads.h"

namespace lake::commands {

// Calls draw(path) for NAME.png and NAME.svg among the run's results: the path without extension, of which
// figure::GnuplotFigure makes both.
template <typename Draw>
void DrawPngAndSvg(const std::string& name, Run& run, const Draw& draw) {
  std::filesystem::path both = run.Result(name + ".png");
  run.Result(name + ".svg");
  draw(both.replace_extension());
}

struct NamedFigure {
  std::string name;
  std::function<void(const std::filesystem::path& both)> draw;
};

// Likewise several at the same time: drawing is mostly waiting for a gnuplot, of which each has its own.
inline void DrawTogether(const std::vector<NamedFigure>& figures, Run& run) {
  std::vector<std::filesystem::path> paths;
  paths.reserve(figures.size());
  for (const NamedFigure& figure : figures) {
    paths.push_back(run.Result(figure.name + ".png").replace_extension());
    run.Result(figure.name + ".svg");
  }
  ForEachInThreads(figures.size(), Threads(), [&](std::size_t i) { figures[i].draw(paths[i]); });
}

}  // namespace lake::commands
