#include "lake/figure/charts.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "lake/core/colours.h"
#include "lake/figure/gnuplot.h"

namespace lake::figure {
namespace {

using report::LineChart, report::Mark, report::Series;

constexpr int kPanelWidth_px = 700, kOnlyPanelWidth_px = 1000, kPanelHeight_px = 450, kTallPanelHeight_px = 650,
              kTitle_px = 40;

std::string Quoted(const std::string& text) {
  return QuoteForGnuplot(text) + " noenhanced";
}

const char* StyleOf(const Series& series) {
  constexpr std::size_t kMany = 60;
  switch (series.mark) {
    case Mark::kLine:
      return "lines lw 3";
    case Mark::kThin:
      return "lines lw 1";
    case Mark::kDashed:
      return "lines lw 3 dt (12,5)";
    case Mark::kDotted:
      return "lines lw 3 dt (3,4)";
    case Mark::kPoints:
      return series.x.size() > kMany ? "points pt 7 ps 0.7" : "points pt 7 ps 1.5";
  }
  return "lines";
}

std::string EndOf(const std::optional<double>& end) {
  return end ? fmt::format("{}", *end) : "*";
}

// Points with their error bars, or a line over its band.
void AddSeries(GnuplotFigure& figure, const Series& series, const std::string& colour, std::vector<std::string>& bands,
               std::vector<std::string>& curves) {
  const std::string title = series.name.empty() ? "notitle" : "title " + Quoted(series.name);
  const bool has_band = !series.lower.empty();
  if (has_band && series.mark == Mark::kPoints) {
    curves.push_back(fmt::format("{} using 1:2:3:4 with yerrorbars pt 7 ps 1.5 lw 2 lc rgb '{}' {}",
                                 figure.Data({series.x, series.y, series.lower, series.upper}), colour, title));
    return;
  }
  if (has_band)
    bands.push_back(
        fmt::format("{} using 1:2:3 with filledcurves fc rgb '{}' fs transparent solid 0.25 noborder notitle",
                    figure.Data({series.x, series.lower, series.upper}), colour));
  curves.push_back(fmt::format("{} using 1:2 with {} lc rgb '{}' {}", figure.Data({series.x, series.y}),
                               StyleOf(series), colour, title));
}

struct Extent {
  double low = std::numeric_limits<double>::infinity(), high = -low;

  explicit Extent(const LineChart& chart, std::vector<double> Series::*values) {
    for (const Series& series : chart.series)
      for (const double value : series.*values)
        if (std::isfinite(value)) {
          low = std::min(low, value);
          high = std::max(high, value);
        }
  }
  double Length() const { return std::max(high - low, 1e-6); }
};

// A mm is as long on both axes, whose tics have one step; a high panel gets room beside its data.
void SetEqualScales(GnuplotFigure& figure, const LineChart& chart, double room) {
  const double width = Extent(chart, &Series::x).Length(), height = Extent(chart, &Series::y).Length();
  const double rough = std::max(width, height) / 6, power = std::pow(10, std::floor(std::log10(rough)));
  const double step = rough > 5 * power ? 10 * power : rough > 2 * power ? 5 * power : 2 * power;
  const double beside = std::max(0.06 * width, (height - width) / 2);
  figure.Line("set size ratio -1; set offsets {0}, {0}, graph {1}, graph 0.06; set xtics {2}; set ytics {2}", beside,
              room, step);
}

void DrawPanel(GnuplotFigure& figure, const LineChart& chart) {
  figure.Line("unset object; unset arrow; unset label; set key top right noautotitle invert");
  figure.Line("set title {}; set xlabel {}; set ylabel {}", Quoted(chart.title), Quoted(chart.x.label),
              Quoted(chart.y.label));
  figure.Line("set xrange [{}:{}]; set autoscale xfix; set yrange [{}:{}]{}", EndOf(chart.x.from), EndOf(chart.x.to),
              EndOf(chart.y.from), EndOf(chart.y.to), chart.y.downwards ? " reverse" : "");
  const auto named = std::ranges::count_if(chart.series, [](const Series& series) { return !series.name.empty(); });
  // The share of the panel's height that the legend has; with equal scales the axis ends farther from the data.
  const double legend = (chart.equal_scales ? 0.12 : 0.05) + 0.08 * static_cast<double>(named);
  const double room = chart.y.to ? 0 : legend / (1 - legend);
  if (chart.equal_scales)
    SetEqualScales(figure, chart, room);
  else
    figure.Line("set size noratio; set offsets 0, 0, graph {}, graph {}; set xtics autofreq; set ytics autofreq", room,
                chart.y.from ? 0 : 0.05);
  for (const report::ShadedInterval& interval : chart.intervals)
    figure.Line("set object rectangle from first {}, graph 0 to first {}, graph 1 behind fc rgb '{}' fs solid noborder",
                interval.from, interval.to, colour::kGap);
  for (const report::VerticalLine& line : chart.lines)
    figure.Line(
        "set arrow from first {0}, graph 0 to first {0}, graph 1 nohead lw 2 dt (6,4) lc rgb '{1}' back; set label {2} "
        "at first {0}, graph 0.05 offset 0.5,0",
        line.x, colour::kText, Quoted(line.label));
  std::vector<std::string> bands, curves;
  for (std::size_t i = 0; i < chart.series.size(); ++i)
    AddSeries(figure, chart.series[i], report::ColourOf(chart.series[i], i), bands, curves);
  bands.insert(bands.end(), curves.rbegin(), curves.rend());  // the first is drawn last, on top, as in the page
  figure.Line("plot {}", bands.empty() ? "1/0 notitle" : fmt::format("{}", fmt::join(bands, ", ")));
}

}  // namespace

void DrawCharts(const std::filesystem::path& path, const std::vector<LineChart>& charts, int columns,
                const std::string& title) {
  const int rows = (static_cast<int>(charts.size()) + columns - 1) / columns;
  const bool are_tall = std::ranges::all_of(charts, &LineChart::equal_scales);
  const int title_px = title.empty() ? 0 : kTitle_px, panel_px = are_tall ? kTallPanelHeight_px : kPanelHeight_px,
            height_px = panel_px * rows + title_px,
            width_px = columns == 1 ? kOnlyPanelWidth_px : kPanelWidth_px * columns;
  GnuplotFigure figure(width_px, height_px);
  figure.Line("set multiplot layout {},{} margins {},{},{},{} spacing {},{}{}", rows, columns, 125.0 / width_px,
              1 - 25.0 / width_px, 70.0 / height_px, 1 - (55.0 + title_px) / height_px, 150.0 / width_px,
              130.0 / height_px, title.empty() ? "" : " title " + Quoted(title));
  for (const LineChart& chart : charts) DrawPanel(figure, chart);
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
