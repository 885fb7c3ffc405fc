#include "lake/figure/trial_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/core/counted.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/figure/charts.h"
#include "lake/gait/butterworth.h"
#include "percents.h"

namespace lake::figure {
namespace {

using report::LineChart, report::Mark, report::Series;

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

// With a band of ± so many standard deviations.
Series WithBand(std::string name, std::vector<double> x, std::vector<double> y, const std::vector<double>& sd,
                double deviations, const char* colour) {
  Series series{.name = std::move(name), .x = std::move(x), .y = std::move(y), .colour = colour};
  for (std::size_t i = 0; i < sd.size(); ++i) {
    series.lower.push_back(series.y[i] - deviations * sd[i]);
    series.upper.push_back(series.y[i] + deviations * sd[i]);
  }
  return series;
}

LineChart ChartOf(const Panel& panel, const Curves& curves, bool from_standing, const gait::ReferenceCurve* reference) {
  std::vector<double> mean, sd;
  for (std::size_t i = 0; i < kPercents; ++i) {
    std::vector<double> at;
    at.reserve(curves.size());
    for (const std::vector<double>& curve : curves) at.push_back(curve[i]);
    mean.push_back(Mean(at));
    sd.push_back(at.size() > 1 ? StandardDeviation(at) : 0);
  }
  LineChart chart{.x = {.label = "gait cycle (%)", .from = 0, .to = 100},
                  .y = {.label = std::string(panel.name) + (from_standing ? " from quiet standing" : "")}};
  chart.series.push_back(WithBand(fmt::format("mean of {} ± 1 SD", Counted(curves.size(), "stride")),
                                  Percents(kPercents), mean, sd, 1, colour::kKnee));
  for (const std::vector<double>& curve : curves)
    chart.series.push_back(OverPercent("", curve, colour::kGuide, Mark::kThin));
  if (reference)
    chart.series.push_back(
        WithBand("reference ± 1 SD", reference->percent, reference->mean_deg, reference->sd_deg, 1, colour::kOther));
  return chart;
}

}  // namespace

void DrawTracksFigure(const std::filesystem::path& path, const motion::MarkerRecording& recording,
                      const std::string& title) {
  const std::string_view unit = motion::ToString(recording.unit);
  std::vector<LineChart> charts = {
      {.x = {.label = "time (s)"}, .y = {.label = fmt::format("x ({})", unit)}},
      {.x = {.label = "time (s)"},
       .y = {.label = fmt::format("y ({})", unit), .downwards = recording.unit == motion::LengthUnit::kPx}}};
  for (const motion::MarkerTrack& marker : recording.markers)
    for (int axis = 0; axis < 2; ++axis) {
      Series series{.name = marker.name, .x = recording.time_s};
      for (const motion::MarkerSample& sample : marker.samples)
        series.y.push_back(sample.IsKnown() ? sample.position[axis] : kNaN);
      charts[static_cast<std::size_t>(axis)].series.push_back(std::move(series));
    }
  DrawCharts(path, charts, 1, title);
}

void DrawMeasures(const std::filesystem::path& path, const motion::MarkerRecording& recording,
                  const std::vector<gait::MeasuredCourse>& courses) {
  constexpr std::size_t kMost = 6;
  std::vector<LineChart> charts;
  for (std::size_t k = 0; k < std::min(courses.size(), kMost); ++k) {
    const gait::MeasuredCourse& course = courses[k];
    charts.push_back({.x = {.label = "time (s)"},
                      .y = {.label = fmt::format("{} ({})", course.measure.name,
                                                 gait::UnitForPeople(gait::UnitOf(course, recording.unit)))},
                      .series = {WithBand("± 2 SD", recording.time_s, course.value, course.sd, 2, colour::kKnee)}});
  }
  DrawCharts(path, charts);
}

void DrawGaitCycles(const std::filesystem::path& path, const gait::LegFitResult& leg,
                    const gait::Measures<gait::GaitCycle>& cycles,
                    const std::optional<gait::ReferenceCurve>& reference) {
  std::vector<LineChart> charts;
  for (const Panel& panel : kPanels) {
    const Curves curves = CurvesOf(panel.angle, leg.motion, cycles.rows);
    if (curves.empty()) continue;
    const bool has_reference = reference && panel.angle == &motion::LegSample::knee_deg;
    charts.push_back(ChartOf(panel, curves, leg.motion.neutral.has_value(), has_reference ? &*reference : nullptr));
    if (const double off = cycles.mean.stance_percent.value; std::isfinite(off))
      charts.back().lines.push_back({off, "toe-off"});
  }
  DrawCharts(path, charts);
}

void DrawSync(const std::filesystem::path& path, const sync::Alignment& alignment, const std::string& title) {
  const sync::Comparison& compared = alignment.comparison;
  std::vector<LineChart> charts;
  if (!compared.time_s.empty()) {
    charts.push_back(
        {.x = {.label = "time of A (s)"},
         .y = {.label = compared.name},
         .series = {{.name = "from the other recording",
                     .x = compared.time_s,
                     .y = compared.predicted,
                     .colour = colour::kText,
                     .mark = Mark::kDashed},
                    {.name = "measured", .x = compared.time_s, .y = compared.measured, .colour = colour::kKnee}}});
    charts.push_back({.x = {.label = "offset (s)"},
                      .y = {.label = "log likelihood ratio"},
                      .series = {{.x = alignment.offset_s, .y = alignment.log_likelihood, .colour = colour::kKnee}}});
  }
  Series departures{.name = "parts, ± 2 SD", .colour = colour::kText, .mark = Mark::kPoints};
  for (const sync::PartOffset& part : alignment.parts) {
    departures.x.push_back(part.time_s);
    departures.y.push_back(1000 * part.departure_s);
    departures.lower.push_back(1000 * (part.departure_s - 2 * part.sd_s));
    departures.upper.push_back(1000 * (part.departure_s + 2 * part.sd_s));
  }
  charts.push_back(
      {.x = {.label = "time of A (s)"}, .y = {.label = "departure (ms)"}, .series = {std::move(departures)}});
  DrawCharts(path, charts, 1, title);
}

}  // namespace lake::figure
