// Figures in both forms: PNG for pages, SVG for papers.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "lake/core/run.h"
#include "lake/core/threads.h"

namespace lake::commands {

struct NamedFigure {
  std::string name;
  std::function<void(const std::filesystem::path& both)> draw;
};

// NAME.png and NAME.svg among the run's results, without extension.
inline std::filesystem::path ResultInBoth(const std::string& name, Run& run) {
  std::filesystem::path both = run.Result(name + ".png").replace_extension();
  run.Result(name + ".svg");
  return both;
}

// Calls draw(path, …) with the path without extension, of which figure::GnuplotFigure makes both.
template <typename Draw, typename... Content>
void DrawPngAndSvg(const std::string& name, Run& run, const Draw& draw, const Content&... content) {
  draw(ResultInBoth(name, run), content...);
}

// Likewise several at the same time: drawing is mostly waiting for a gnuplot, of which each has its own.
inline void DrawTogether(const std::vector<NamedFigure>& figures, Run& run) {
  std::vector<std::filesystem::path> paths;
  paths.reserve(figures.size());
  for (const NamedFigure& figure : figures) paths.push_back(ResultInBoth(figure.name, run));
  ForEachInThreads(figures.size(), Threads(), [&](std::size_t i) { figures[i].draw(paths[i]); });
}

}  // namespace lake::commands
