#include "lake/figure/tracks_figure.h"

#include <array>
#include <limits>

#include "lake/core/colours.h"
#include "lake/core/error.h"
#include "lake/figure/gnuplot.h"

namespace lake::figure {

void DrawTracksFigure(const std::filesystem::path& path, const motion::MarkerRecording& recording,
                      const std::string& title) {
  constexpr std::array kColours = {colour::kAnkle, colour::kKnee,  colour::kHip,
                                   colour::kWaist, colour::kOther, colour::kExoskeleton};
  GnuplotFigure figure(1200, 800);
  std::array<std::string, 2> plots;
  for (std::size_t m = 0; m < recording.markers.size(); ++m) {
    const motion::MarkerTrack& marker = recording.markers[m];
    std::vector<double> x, y;
    for (const motion::MarkerSample& sample : marker.samples) {
      constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
      x.push_back(sample.IsKnown() ? sample.position.x() : kGap);
      y.push_back(sample.IsKnown() ? sample.position.y() : kGap);
    }
    const std::string data = figure.Data({recording.time_s, x, y});
    for (std::size_t axis = 0; axis < 2; ++axis)
      plots[axis] += fmt::format("{}{} using 1:{} with lines lw 2 lc rgb '{}' title {}", m ? ", " : "", data, axis + 2,
                                 kColours[m % kColours.size()], QuoteForGnuplot(marker.name));
  }
  const std::string_view unit = motion::ToString(recording.unit);
  figure.Line("set multiplot layout 2,1 title {} noenhanced", QuoteForGnuplot(title))
      .Line("set key outside right top noenhanced")
      .Line("set ylabel 'x ({})'", unit)
      .Line("plot {}", plots[0])
      .Line("set xlabel 'time (s)'; set ylabel 'y ({})'", unit)
      .Line(recording.unit == motion::LengthUnit::kPx ? "set yrange [*:*] reverse" : "")  // pixels count downwards
      .Line("plot {}", plots[1])
      .Line("unset multiplot");
  figure.Write(path);
}

}  // namespace lake::figure
