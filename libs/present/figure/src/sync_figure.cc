#include "lake/figure/sync_figure.h"

#include "lake/core/colours.h"
#include "lake/figure/gnuplot.h"

namespace lake::figure {
namespace {

void DrawSignals(GnuplotFigure& figure, const sync::Comparison& comparison) {
  figure.Line("set xlabel 'time of A (s)'; set format y ''")
      .Line("set ylabel {} noenhanced", QuoteForGnuplot(comparison.name))
      .Line(
          "plot {0} using 1:2 with lines lw 4 lc rgb '{1}' title 'measured', {0} using 1:3 with lines lw 2 dt 2 lc rgb "
          "'{2}' title 'from the other recording'",
          figure.Data({comparison.time_s, comparison.measured, comparison.predicted}), colour::kKnee, colour::kText)
      .Line("set format y '%g'");
}

void DrawLikelihood(GnuplotFigure& figure, const sync::Alignment& alignment) {
  figure.Line("set xlabel 'offset (s)'; set ylabel 'log likelihood ratio'")
      .Line("plot {} using 1:2 with lines lw 2 lc rgb '{}' notitle",
            figure.Data({alignment.offset_s, alignment.log_likelihood}), colour::kKnee);
}

void DrawDepartures(GnuplotFigure& figure, const sync::Alignment& alignment) {
  std::vector<double> time_s, departure_ms, two_sd_ms;
  for (const sync::PartOffset& part : alignment.parts) {
    time_s.push_back(part.time_s);
    departure_ms.push_back(1000 * part.departure_s);
    two_sd_ms.push_back(2 * 1000 * part.sd_s);
  }
  figure.Line("set xlabel 'time of A (s)'; set ylabel 'departure (ms)'")
      .Line(
          "plot {} using 1:2:3 with yerrorbars pt 7 ps 1.2 lw 2 lc rgb '{}' title 'parts, ± 2 SD', 0 with lines lw 1 "
          "lc rgb '#222222' notitle",
          figure.Data({time_s, departure_ms, two_sd_ms}), colour::kText);
}

}  // namespace

void DrawSync(const std::filesystem::path& path, const sync::Alignment& alignment, const std::string& title) {
  GnuplotFigure figure(1400, 900);
  figure.Line("set multiplot title {} noenhanced", QuoteForGnuplot(title));
  figure.Line("set key tmargin right horizontal samplen 2.5");
  if (alignment.comparison.time_s.empty()) {
    DrawDepartures(figure, alignment);
  } else {
    figure.Line("set size 1,0.5; set origin 0,0.46");
    DrawSignals(figure, alignment.comparison);
    figure.Line("set size 0.5,0.46; set origin 0,0");
    DrawLikelihood(figure, alignment);
    figure.Line("set size 0.5,0.46; set origin 0.5,0");
    DrawDepartures(figure, alignment);
  }
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
