#include "lake/figure/group_figure.h"

#include <fmt/ranges.h>

#include "lake/figure/gnuplot.h"
#include "percents.h"
#include "theme.h"

namespace lake::figure {

void DrawConditions(const std::filesystem::path& path, const std::vector<ConditionCurve>& curves,
                    const std::string& axis) {
  constexpr int kWidth_px = 900, kHeight_px = 640;
  GnuplotFigure figure(kWidth_px, kHeight_px);
  figure.Line("set xlabel 'rise (%)'; set xrange [0:100]; set xtics 25; set ylabel " + QuoteForGnuplot(axis));
  figure.Line("set key above left horizontal Left reverse");
  std::vector<std::string> bands, lines;
  for (const ConditionCurve& curve : curves) {
    const PathStyle& style = curve.with_exoskeleton ? kWornPath : kHumanPath;
    const std::vector<double> percents = Percents(static_cast<int>(curve.mean.size()));
    if (!curve.low.empty())
      bands.push_back(fmt::format("{} using 1:2:3 with filledcurves fc rgb '{}' fs transparent solid 0.25 noborder",
                                  figure.Data({percents, curve.low, curve.high}), style.colour));
    lines.push_back(fmt::format("{} using 1:2 with lines {} title '{} exoskeleton (n = {})'",
                                figure.Data({percents, curve.mean}), LineOf(style),
                                curve.with_exoskeleton ? "with" : "without", curve.people));
  }
  bands.insert(bands.end(), lines.begin(), lines.end());
  figure.Line("plot {}", fmt::join(bands, ", "));
  figure.Write(path);
}

}  // namespace lake::figure
