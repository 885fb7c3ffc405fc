#include "lake/figure/measures_figure.h"

#include <fmt/format.h>

#include <algorithm>

#include "lake/core/colours.h"
#include "lake/figure/gnuplot.h"

namespace lake::figure {
void DrawMeasures(const std::filesystem::path& path, const motion::MarkerRecording& recording,
                  const std::vector<gait::MeasuredCourse>& courses) {
  constexpr std::size_t kMost = 6;
  const std::size_t shown = std::min(courses.size(), kMost);
  GnuplotFigure figure(1200, 200 + 200 * static_cast<int>(shown));
  figure.Line("set multiplot layout {},1", shown);
  figure.Line("set lmargin 13; set key tmargin right horizontal samplen 2.5");  // the same axis of time, free curves
  for (std::size_t k = 0; k < shown; ++k) {
    const gait::MeasuredCourse& course = courses[k];
    std::vector<double> low, high;
    for (std::size_t i = 0; i < course.value.size(); ++i) {
      low.push_back(course.value[i] - 2 * course.sd[i]);
      high.push_back(course.value[i] + 2 * course.sd[i]);
    }
    if (k + 1 == shown) figure.Line("set xlabel 'time (s)'");
    const std::string label =
        fmt::format("{} ({})", course.measure.name, gait::UnitForPeople(gait::UnitOf(course, recording.unit)));
    const std::string data = figure.Data({recording.time_s, course.value, low, high});
    figure.Line("set ylabel {} noenhanced", QuoteForGnuplot(label))
        .Line(
            "plot {0} using 1:3:4 with filledcurves fc rgb '{1}' fs transparent solid 0.3 noborder title '± 2 SD', {0} "
            "using 1:2 with lines lw 2 lc rgb '{1}' notitle",
            data, colour::kKnee);
  }
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
