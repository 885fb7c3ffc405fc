#include "lake/figure/calibration_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "lake/core/colours.h"
#include "lake/figure/gnuplot.h"

namespace lake::figure {
namespace {

struct Arrows {
  std::vector<double> x, y, dx, dy;

  std::vector<std::vector<double>> Columns() const { return {x, y, dx, dy}; }
};

// The largest of 1, 2, 5 times a power of ten that is not above the value.
double RoundBelow(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  return value >= 5 * power ? 5 * power : value >= 2 * power ? 2 * power : power;
}

// Makes a typical residual about a fiftieth of the picture.
double Magnification(const camera::CalibrationResult& result) {
  return RoundBelow(result.camera.image_width / 50.0 / std::max(result.sigma_px, 1e-6));
}

void Split(const std::vector<camera::BoardView>& views, const camera::CalibrationResult& result, double magnification,
           Arrows& inliers, Arrows& outliers) {
  std::set<std::pair<std::size_t, int>> out;
  for (const camera::CornerOutlier& o : result.outliers) out.emplace(o.view, o.corner);
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t i = 0; i < views[v].pixel.size(); ++i) {
      Arrows& arrows = out.count({v, views[v].corner[i]}) ? outliers : inliers;
      arrows.x.push_back(views[v].pixel[i].x());
      arrows.y.push_back(views[v].pixel[i].y());
      arrows.dx.push_back(magnification * result.residual_px[v][i].x());
      arrows.dy.push_back(magnification * result.residual_px[v][i].y());
    }
  }
}

// Axes of a picture: y down, its proportions, both in px.
void PictureAxes(GnuplotFigure& figure, int width_px, int height_px) {
  figure.Line("set xrange [-0.5:{}]\nset yrange [{}:-0.5]\nset size ratio -1", width_px - 0.5, height_px - 0.5)
      .Line("set xlabel 'x [px]'\nset ylabel 'y [px]' offset 1,0\nset tics out nomirror\nset border lw 1");
}

// Grey where no corner was seen.
void ShadeEmptyCells(GnuplotFigure& figure, const camera::Coverage& coverage, int width_px, int height_px) {
  const double width = static_cast<double>(width_px) / coverage.columns,
               height = static_cast<double>(height_px) / coverage.rows;
  for (int row = 0; row < coverage.rows; ++row)
    for (int column = 0; column < coverage.columns; ++column)
      if (coverage.corners[static_cast<std::size_t>(row * coverage.columns + column)] == 0)
        figure.Line("set object rectangle from {},{} to {},{} fc rgb '{}' fs solid noborder behind",
                    column * width - 0.5, row * height - 0.5, (column + 1) * width - 0.5, (row + 1) * height - 0.5,
                    colour::kGap);
}

// The RMS of each view as a bar, that of all as a line.
void DrawViews(GnuplotFigure& figure, const std::vector<camera::BoardView>& views,
               const camera::CalibrationResult& result) {
  std::vector<double> number, rms;
  for (std::size_t v = 0; v < views.size(); ++v) {
    number.push_back(static_cast<double>(v));
    rms.push_back(result.view_rms_px[v]);
  }
  const double worst = *std::max_element(rms.begin(), rms.end());
  figure
      .Line(
          "unset key\nunset object\nset size noratio\nset lmargin at screen 0.79\nset rmargin at screen 0.98\nset "
          "xlabel 'RMS [px]'\nset ylabel ''")
      .Line("set title 'Views'\nset xrange [0:{}]\nset xtics {}\nset yrange [{}:-0.7]", 1.1 * worst,
            RoundBelow(std::max(worst, 1e-9) / 3), static_cast<double>(views.size()) - 0.3);
  std::string tics;
  for (std::size_t v = 0; v < views.size(); ++v)
    tics += fmt::format("{}{} {}", v ? "," : "", QuoteForGnuplot(views[v].name), v);
  figure.Line("set ytics ({}) font ',{}' noenhanced", tics, views.size() > 30 ? 7 : 10)
      .Line("set style fill solid 0.8 noborder\nset arrow 1 from {0},graph 0 to {0},graph 1 nohead dt 2 lc '{1}'",
            result.rms_px, colour::kText)
      .Line("plot {} using ($2/2):1:($2/2):(0.35) with boxxyerror lc '{}'", figure.Data({number, rms}), colour::kOther);
}

}  // namespace

void WriteResidualFigure(const std::filesystem::path& path, const std::vector<camera::BoardView>& views,
                         const camera::CalibrationResult& result) {
  const camera::Camera& camera = result.camera;
  const double magnification = Magnification(result);
  Arrows inliers, outliers;
  Split(views, result, magnification, inliers, outliers);
  GnuplotFigure figure(1500, 720);
  figure.Line("set multiplot")
      .Line(
          "set lmargin at screen 0.06\nset rmargin at screen 0.62\nset tmargin at screen 0.90\nset bmargin at screen "
          "0.12");
  PictureAxes(figure, camera.image_width, camera.image_height);
  ShadeEmptyCells(figure, camera::CoverageOf(views, camera.image_width, camera.image_height), camera.image_width,
                  camera.image_height);
  figure.Line(
      "set title 'Corners and residuals, {}× magnified: RMS {:.3f} px, inliers {:.3f} px; grey: no corner seen'",
      magnification, result.rms_px, result.inlier_rms_px);
  const std::string in = figure.Data(inliers.Columns()), out = figure.Data(outliers.Columns());
  std::string plot = fmt::format(
      "plot {} using 1:2:3:4 with vectors nohead lc '{}' lw 1 notitle, '' using 1:2 with points pt 7 ps 0.25 "
      "lc '{}' notitle",
      in, colour::kAnkle, colour::kText);
  if (!outliers.x.empty())
    plot += fmt::format(
        ", {0} using 1:2:3:4 with vectors nohead lc '{1}' lw 1.5 notitle, '' using 1:2 with points pt 6 ps 1.2 lc "
        "'{1}' "
        "title 'outliers: {2}'",
        out, colour::kExoskeleton, outliers.x.size());
  figure.Line("set key top right opaque").Line(plot);

  DrawViews(figure, views, result);
  figure.Line("unset multiplot").Write(path);
}

void WriteCrossValidationFigure(const std::filesystem::path& path, const camera::CameraDifference& difference,
                                int width_px, int height_px) {
  std::vector<double> x, y, size;
  for (std::size_t i = 0; i < difference.pixel.size(); ++i) {
    x.push_back(difference.pixel[i].x());
    y.push_back(difference.pixel[i].y());
    size.push_back(difference.difference_px[i].norm());
  }
  GnuplotFigure figure(1000, 100 + 800 * height_px / std::max(width_px, height_px));
  PictureAxes(figure, width_px, height_px);
  const std::string title = fmt::format("Cameras of the odd and even views: {:.3f} px RMS, {:.3f} px at most",
                                        difference.rms_px, difference.largest_px);
  figure.Line("set title " + QuoteForGnuplot(title))
      .Line(
          "set cblabel 'difference [px]' offset 1,0\nset logscale cb\nset cbrange [0.01:10]\nset key off\nset palette "
          "defined (0 '#440154', "
          "1 '#3b528b', 2 '#21918c', 3 '#5ec962', 4 '#fde725')\nset view map")
      .Line("plot {} using 1:2:3 with image", figure.Data({x, y, size}))
      .Write(path);
}

}  // namespace lake::figure
