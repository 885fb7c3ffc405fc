// Figures by gnuplot: a script is collected, then drawn to PNG, SVG or (several pages) animated GIF by the file's
// extension.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lake::figure {

class GnuplotFigure {
 public:
  // Size of the PNG in px; an SVG gets the same proportions.
  GnuplotFigure(int width_px, int height_px);

  // Appends a line of script. Text from outside must go through QuoteForGnuplot. Between `set multiplot` and
  // `unset multiplot` each line that begins with `plot` draws a panel, which gets a letter where there are several.
  GnuplotFigure& Line(std::string_view script);
  template <typename... Args>
  requires(sizeof...(Args) > 0) GnuplotFigure& Line(fmt::format_string<Args...> format, Args&&... args) {
    return Line(fmt::format(format, std::forward<Args>(args)...));
  }

  // A table to plot, columns of equal length; NaN interrupts a line. Returns its name in the script, e.g. "$data0".
  std::string Data(const std::vector<std::vector<double>>& columns);

  // Starts a new page, with the settings as at the start; tables stay known.
  GnuplotFigure& NextPage();

  // Draws, atomically; to a path without extension as PATH.png and PATH.svg, by one gnuplot, whose start takes longer
  // than most drawings. Throws Error with gnuplot's own words if it fails or is not installed.
  void Write(const std::filesystem::path& path) const;

  // Draws the pages as an endless animation.
  void WriteGif(const std::filesystem::path& path, double pages_per_s) const;

  // Draws every page to a PNG of its own, folder/00000.png and so on; the folder must exist.
  void WritePages(const std::filesystem::path& folder) const;

 private:
  int width_px_, height_px_;
  int tables_ = 0;
  std::vector<std::string> pages_;   // each begins with the theme
  std::vector<std::size_t> panels_;  // where in the last page the plots of its multiplot stand
};

// A gnuplot string literal that shows the text as it is.
std::string QuoteForGnuplot(std::string_view text);

}  // namespace lake::figure
