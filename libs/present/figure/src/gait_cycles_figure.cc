#include "lake/figure/gait_cycles_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/core/counted.h"
#include "lake/core/statistics.h"
#include "lake/figure/gnuplot.h"
#include "lake/gait/butterworth.h"
#include "percents.h"

namespace lake::figure {
namespace {

constexpr int kPercents = 101;

struct Panel {
  double motion::LegSample::*angle;
  const char* name;
};
constexpr std::array kPanels = {Panel{&motion::LegSample::knee_deg, "knee flexion (°)"},
                                Panel{&motion::LegSample::ankle_deg, "ankle dorsiflexion (°)"},
                                Panel{&motion::LegSample::thigh_deg, "thigh (°)"},
                                Panel{&motion::LegSample::shank_deg, "shank (°)"}};

using Curves = std::vector<std::vector<double>>;

// An angle of each stride at 0, 1, … 100 %, less that of quiet standing where it is known; none of a stride in which
// too little of it is known.
Curves CurvesOf(double motion::LegSample::*angle, const motion::LegMotion& motion,
                const std::vector<gait::GaitCycle>& cycles) {
  const double zero_deg = motion.neutral ? (*motion.neutral).*angle : 0;
  constexpr double kBeside = 5;  // percent, so that the curve does not end before the stride
  Curves curves;
  for (const gait::GaitCycle& cycle : cycles) {
    std::vector<double> percent, values;
    for (std::size_t i = 0; i < motion.samples.size(); ++i) {
      const double at = 100 * (motion.time_s[i] - cycle.begin_s.value) / cycle.stride_s.value;
      if (at < -kBeside || at > 100 + kBeside || !std::isfinite(motion.samples[i].*angle)) continue;
      percent.push_back(at);
      values.push_back(motion.samples[i].*angle - zero_deg);
    }
    if (values.size() > 1) curves.push_back(gait::InterpolateCubic(values, percent, Percents(kPercents)));
  }
  return curves;
}

std::string Band(GnuplotFigure& figure, const std::vector<double>& percent, const std::vector<double>& mean,
                 const std::vector<double>& sd, const char* colour, const char* title) {
  return fmt::format(
      "{} using 1:($2-$3):($2+$3) with filledcurves fc rgb '{}' fs transparent solid 0.25 noborder title '{} ± 1 SD', ",
      figure.Data({percent, mean, sd}), colour, title);
}

void DrawPanel(GnuplotFigure& figure, const std::string& name, const Curves& curves,
               const gait::ReferenceCurve* reference) {
  std::vector<double> mean, sd;
  for (int i = 0; i < kPercents; ++i) {
    std::vector<double> at;
    at.reserve(curves.size());
    for (const std::vector<double>& curve : curves) at.push_back(curve[static_cast<std::size_t>(i)]);
    mean.push_back(Mean(at));
    sd.push_back(at.size() > 1 ? StandardDeviation(at) : 0);
  }
  std::string plot = "plot ";
  if (reference)
    plot += Band(figure, reference->percent, reference->mean_deg, reference->sd_deg, colour::kOther, "reference");
  plot += Band(figure, Percents(kPercents), mean, sd, colour::kKnee, "mean");
  for (const std::vector<double>& curve : curves)
    plot += fmt::format("{} using 1:2 with lines lw 1 lc rgb '{}' notitle, ", figure.Data({Percents(kPercents), curve}),
                        colour::kGuide);
  plot += fmt::format("{} using 1:2 with lines lw 3 lc rgb '{}' title 'mean of {}'",
                      figure.Data({Percents(kPercents), mean}), colour::kKnee, Counted(curves.size(), "stride"));
  figure.Line("set ylabel '{}'", name).Line(plot);
}

}  // namespace

void DrawGaitCycles(const std::filesystem::path& path, const gait::LegFitResult& leg,
                    const gait::Measures<gait::GaitCycle>& cycles,
                    const std::optional<gait::ReferenceCurve>& reference) {
  std::vector<std::pair<Panel, Curves>> panels;
  for (const Panel& panel : kPanels)
    if (Curves curves = CurvesOf(panel.angle, leg.motion, cycles.rows); !curves.empty())
      panels.emplace_back(panel, std::move(curves));
  const int count = std::max(1, static_cast<int>(panels.size()));
  GnuplotFigure figure(1000, 400 * count);
  figure.Line("set multiplot layout {},1", count)
      .Line("set xrange [0:100]; set xlabel 'gait cycle (%)'; set key outside top center horizontal");
  if (const double off = cycles.mean.stance_percent.value; std::isfinite(off))
    figure.Line("set arrow from {0}, graph 0 to {0}, graph 1 nohead lw 2 dt (6,4) lc rgb '{1}'", off, colour::kText)
        .Line("set label 'toe-off' at {}, graph 0.05 offset 0.5,0", off);
  for (const auto& [panel, curves] : panels)
    DrawPanel(figure, std::string(panel.name) + (leg.motion.neutral ? " from quiet standing" : ""), curves,
              reference && panel.angle == &motion::LegSample::knee_deg ? &*reference : nullptr);
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
