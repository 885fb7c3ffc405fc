#include "lake/figure/gait_cycles_figure.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "lake/core/colours.h"
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
                                Panel{&motion::LegSample::thigh_deg, "thigh (°)"},
                                Panel{&motion::LegSample::shank_deg, "shank (°)"}};

// An angle of one stride at 0, 1, … 100 %; empty if too little of it is known.
std::vector<double> CurveOf(const motion::LegMotion& motion, const gait::GaitCycle& cycle,
                            double motion::LegSample::*angle) {
  constexpr double kBeside = 5;  // percent, so that the curve does not end before the stride
  std::vector<double> percent, values;
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    const double at = 100 * (motion.time_s[i] - cycle.begin_s.value) / cycle.stride_s.value;
    if (at < -kBeside || at > 100 + kBeside || !std::isfinite(motion.samples[i].*angle)) continue;
    percent.push_back(at);
    values.push_back(motion.samples[i].*angle);
  }
  if (values.size() < 2) return {};
  return gait::InterpolateCubic(values, percent, Percents(kPercents));
}

void DrawPanel(GnuplotFigure& figure, const Panel& panel, const gait::LegFitResult& leg,
               const gait::GaitCycles& cycles) {
  std::vector<std::vector<double>> curves;
  for (const gait::GaitCycle& cycle : cycles.strides)
    if (auto curve = CurveOf(leg.motion, cycle, panel.angle); !curve.empty()) curves.push_back(std::move(curve));
  if (curves.empty()) return;
  std::vector<double> mean, low, high;
  for (int i = 0; i < kPercents; ++i) {
    std::vector<double> at;
    at.reserve(curves.size());
    for (const std::vector<double>& curve : curves) at.push_back(curve[static_cast<std::size_t>(i)]);
    const double spread = at.size() > 1 ? StandardDeviation(at) : 0;
    mean.push_back(Mean(at));
    low.push_back(mean.back() - spread);
    high.push_back(mean.back() + spread);
  }
  std::string plot = fmt::format(
      "plot {} using 1:2:3 with filledcurves fc rgb '{}' fs transparent solid 0.25 noborder title 'mean ± 1 SD'",
      figure.Data({Percents(kPercents), low, high}), colour::kKnee);
  for (const std::vector<double>& curve : curves)
    plot += fmt::format(", {} using 1:2 with lines lw 1 lc rgb '{}' notitle", figure.Data({Percents(kPercents), curve}),
                        colour::kGuide);
  plot += fmt::format(", {} using 1:2 with lines lw 3 lc rgb '{}' title 'mean of {} strides'",
                      figure.Data({Percents(kPercents), mean}), colour::kKnee, curves.size());
  figure.Line("set ylabel '{}'", panel.name).Line(plot);
}

}  // namespace

void DrawGaitCycles(const std::filesystem::path& path, const gait::LegFitResult& leg, const gait::GaitCycles& cycles) {
  GnuplotFigure figure(1000, 1200);
  figure.Line("set multiplot layout 3,1").Line("set xrange [0:100]; set xlabel 'gait cycle (%)'; set key top left");
  if (const double off = cycles.mean.stance_percent.value; std::isfinite(off))
    figure.Line("set arrow from {0}, graph 0 to {0}, graph 1 nohead lw 2 dt (6,4) lc rgb '{1}'", off, colour::kText)
        .Line("set label 'toe-off' at {}, graph 0.05 offset 0.5,0", off);
  for (const Panel& panel : kPanels) DrawPanel(figure, panel, leg, cycles);
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
