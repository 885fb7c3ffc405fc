#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/core/statistics.h"
#include "lake/figure/gnuplot.h"
#include "lake/figure/trial_figures.h"

namespace lake::figure {
namespace {

struct EventStyle {
  motion::StsEventKind kind;
  const char* name;
  const char* style;
};
constexpr std::array kEvents = {
    EventStyle{motion::StsEventKind::kOnset, "onset", "lc rgb '#009E73' dt 1 lw 2"},
    EventStyle{motion::StsEventKind::kSeatOff, "seat-off", "lc rgb '#CC79A7' dt (12,4) lw 2"},
    EventStyle{motion::StsEventKind::kStanding, "standing", "lc rgb '#0072B2' dt (6,4) lw 2"},
    EventStyle{motion::StsEventKind::kDescent, "descent", "lc rgb '#555555' dt (2,4) lw 2"},
    EventStyle{motion::StsEventKind::kSeated, "seated", "lc rgb '#555555' dt (10,4,2,4) lw 2"},
    EventStyle{motion::StsEventKind::kBottom, "bottom", "lc rgb '#CC79A7' dt (12,4) lw 2"},
    EventStyle{motion::StsEventKind::kHeelStrike, "heel strike", "lc rgb '#009E73' dt 1 lw 2"},
    EventStyle{motion::StsEventKind::kToeOff, "toe-off", "lc rgb '#CC79A7' dt (12,4) lw 2"}};

const char* ColourOf(const std::string& marker) {
  if (marker == "ankle") return colour::kAnkle;
  if (marker == "knee") return colour::kKnee;
  if (marker == "hip") return colour::kHip;
  if (marker == "waist") return colour::kWaist;
  return colour::kOther;
}

// Positions with x anterior and y up, from the ankle's median.
class LegAxes {
 public:
  explicit LegAxes(const gait::LegFitResult& result) : side_(result.motion.facing == motion::Facing::kRight ? 1 : -1) {
    const motion::MarkerTrack* ankle = result.trajectory.Find("ankle");
    std::vector<double> x, y;
    for (std::size_t i = 0; ankle && i < ankle->samples.size(); ++i)
      if (ankle->samples[i].IsKnown()) {
        x.push_back(ankle->samples[i].position.x());
        y.push_back(ankle->samples[i].position.y());
      }
    if (!x.empty()) origin_ = {Median(x), Median(y)};
  }
  Eigen::Vector2d Of(const Eigen::Vector2d& in_plane) const {
    return {side_ * (in_plane.x() - origin_.x()), in_plane.y() - origin_.y()};
  }

 private:
  double side_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
};

void AddPaths(GnuplotFigure& figure, const gait::LegFitResult& result, const LegAxes& axes,
              std::vector<std::string>& parts) {
  for (const motion::MarkerTrack& marker : result.trajectory.markers) {
    std::vector<double> x, y;
    for (const motion::MarkerSample& sample : marker.samples) {
      const Eigen::Vector2d p = axes.Of(sample.position);
      x.push_back(sample.IsKnown() ? p.x() : motion::LegSample::kUnknown);
      y.push_back(sample.IsKnown() ? p.y() : motion::LegSample::kUnknown);
    }
    parts.push_back(fmt::format("{} using 1:2 with lines lw 2 lc rgb '{}' title {}", figure.Data({x, y}),
                                ColourOf(marker.name), QuoteForGnuplot(marker.name)));
  }
}

// The frames of the first repetition at 0, 25, … 100 %.
std::vector<std::size_t> PoseFrames(const motion::LegMotion& motion) {
  std::vector<std::size_t> frames;
  double next_percent = 0;
  for (std::size_t i = 0; i < motion.samples.size() && next_percent <= 100; ++i)
    if (motion.samples[i].repetition == 1 && motion.samples[i].percent >= next_percent - 1e-9) {
      frames.push_back(i);
      next_percent += 25;
    }
  return frames;
}

void AddPoses(GnuplotFigure& figure, const gait::LegFitResult& result, const LegAxes& axes,
              std::vector<std::string>& parts) {
  std::vector<double> x, y;
  for (const std::size_t i : PoseFrames(result.motion)) {
    for (const char* name : {"ankle", "knee", "hip", "waist"}) {
      const motion::MarkerTrack* marker = result.trajectory.Find(name);
      if (!marker || !marker->samples[i].IsKnown()) continue;
      const Eigen::Vector2d p = axes.Of(marker->samples[i].position);
      x.push_back(p.x());
      y.push_back(p.y());
    }
    x.push_back(motion::LegSample::kUnknown);
    y.push_back(motion::LegSample::kUnknown);
  }
  if (!x.empty())
    parts.push_back(fmt::format("{} using 1:2 with linespoints lw 1 pt 7 ps 0.5 lc rgb '{}' notitle",
                                figure.Data({x, y}), colour::kGuide));
}

std::string Join(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "plot " : ", ") + part;
  return text;
}

void ShadeGaps(GnuplotFigure& figure, const motion::LegMotion& motion) {
  const std::size_t n = motion.samples.size();
  const auto unseen = [&](std::size_t i) { return !std::isfinite(motion.samples[i].knee_raw_deg); };
  for (std::size_t begin = 0; begin < n; ++begin) {
    if (!unseen(begin)) continue;
    std::size_t end = begin;
    while (end + 1 < n && unseen(end + 1)) ++end;
    figure.Line(
        "set object rectangle from first {}, graph 0 to first {}, graph 1 behind fillcolor rgb '{}' fillstyle solid "
        "noborder",
        motion.time_s[begin == 0 ? 0 : begin - 1], motion.time_s[std::min(end + 1, n - 1)], colour::kGap);
    begin = end;
  }
}

void MarkEvents(GnuplotFigure& figure, const std::vector<motion::StsEvent>& events) {
  for (const motion::StsEvent& event : events)
    for (const EventStyle& style : kEvents)
      if (style.kind == event.kind)
        figure.Line("set arrow from first {0}, graph 0 to first {0}, graph 1 nohead {1} back", event.time_s,
                    style.style);
}

struct KneeColumns {
  std::vector<double> raw, fit, difference, lower, upper;
};

KneeColumns ColumnsOf(const motion::LegMotion& motion) {
  KneeColumns columns;
  for (const motion::LegSample& sample : motion.samples) {
    columns.raw.push_back(sample.knee_raw_deg);
    columns.fit.push_back(sample.knee_deg);
    columns.difference.push_back(sample.knee_raw_deg - sample.knee_deg);
    columns.lower.push_back(-2 * sample.knee_sigma_deg);
    columns.upper.push_back(2 * sample.knee_sigma_deg);
  }
  return columns;
}

// Half the height of the panel of differences: its ordinary points, not its outliers, nor the wide bands of gaps.
double DifferenceRange(const KneeColumns& columns) {
  std::vector<double> sizes;
  for (const double d : columns.difference)
    if (std::isfinite(d)) sizes.push_back(std::abs(d));
  for (const double u : columns.upper)
    if (std::isfinite(u)) sizes.push_back(u);
  return sizes.empty() ? 1 : std::max(1.6 * Quantile(sizes, 0.99), 1e-6);
}

// A step of 1, 2 or 5 times a power of ten that makes about four of a range.
double TicStep(const motion::MarkerRecording& trajectory) {
  double low = INFINITY, high = -INFINITY;
  for (const motion::MarkerTrack& marker : trajectory.markers)
    for (const motion::MarkerSample& sample : marker.samples)
      if (sample.IsKnown()) {
        low = std::min(low, sample.position.x());
        high = std::max(high, sample.position.x());
      }
  if (!(high > low)) return 1;
  const double step = (high - low) / 3, power = std::pow(10, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (step <= factor * power) return factor * power;
  return 10 * power;
}

void DrawPaths(GnuplotFigure& figure, const gait::LegFitResult& result) {
  const LegAxes axes(result);
  std::vector<std::string> parts;
  AddPoses(figure, result, axes, parts);
  AddPaths(figure, result, axes, parts);
  figure.Line(
      "set lmargin at screen 0.075; set rmargin at screen 0.355; set tmargin at screen 0.88; set bmargin at screen "
      "0.10");
  figure.Line(
      "set size ratio -1; set key at screen 0.37, screen 0.86 right top samplen 1.5 spacing 1.1 noautotitle "
      "noenhanced");
  figure.Line("set xtics {0}; set ytics {0}", TicStep(result.trajectory));
  figure.Line(
      "set xlabel 'anterior ({0})'; set ylabel 'up ({0})' offset 1,0; set offsets graph 0.05, graph 0.05, graph 0.05, "
      "graph 0.05",
      ToString(result.motion.unit));
  figure.Line(Join(parts));
  figure.Line("set size noratio; unset offsets; set xtics autofreq; set ytics autofreq");
}

void DrawAngle(GnuplotFigure& figure, const gait::LegFitResult& result, const KneeColumns& columns,
               const OtherAngle& other) {
  const std::vector<double>& time_s = result.motion.time_s;
  std::vector<std::string> parts = {
      fmt::format("{} using 1:2 with points pt 6 ps 0.7 lc rgb '#2E8BC0' title 'single frames'",
                  figure.Data({time_s, columns.raw})),
      fmt::format("{} using 1:2 with lines lw 2 lc rgb '{}' title 'fit'", figure.Data({time_s, columns.fit}),
                  colour::kText)};
  if (!other.angle_deg.empty())
    parts.push_back(fmt::format("{} using 1:2 with lines lw 2 dt (8,4) lc rgb '{}' title {}",
                                figure.Data({time_s, other.angle_deg}), colour::kExoskeleton,
                                QuoteForGnuplot(other.name)));
  for (const EventStyle& style : kEvents)
    if (std::any_of(result.events.begin(), result.events.end(),
                    [&](const motion::StsEvent& e) { return e.kind == style.kind; }))
      parts.push_back(fmt::format("NaN with lines {} title '{}'", style.style, style.name));
  figure.Line(
      "set lmargin at screen 0.435; set rmargin at screen 0.985; set tmargin at screen 0.87; set bmargin at screen "
      "0.43");
  figure.Line("set xlabel ''; set format x ''; set ylabel 'knee flexion (°)' offset 1,0");
  figure.Line("set key at graph 1, graph 1.02 right bottom horizontal samplen 1.5 width -1 noautotitle");
  figure.Line(Join(parts));
}

void DrawDifference(GnuplotFigure& figure, const gait::LegFitResult& result, const KneeColumns& columns) {
  const std::vector<double>& time_s = result.motion.time_s;
  const double range_deg = DifferenceRange(columns);
  figure.Line("set tmargin at screen 0.37; set bmargin at screen 0.10; set format x '%g'; set xlabel 'time (s)'");
  figure.Line("set ylabel 'single frame − fit (°)' offset 1,0; set yrange [{}:{}]", -range_deg, range_deg);
  figure.Line(Join(
      {fmt::format(
           "{} using 1:2:3 with filledcurves fc rgb '{}' fs transparent solid 0.45 noborder title '± 2 SD of the fit'",
           figure.Data({time_s, columns.lower, columns.upper}), colour::kHuman),
       fmt::format("{} using 1:2 with points pt 7 ps 0.4 lc rgb '#0072B2' notitle",
                   figure.Data({time_s, columns.difference}))}));
}

}  // namespace

void DrawLegFigure(const std::filesystem::path& path, const gait::LegFitResult& result, const OtherAngle& other) {
  GnuplotFigure figure(1400, 800);
  const std::vector<double>& time_s = result.motion.time_s;
  const KneeColumns columns = ColumnsOf(result.motion);
  figure.Line("set multiplot");
  DrawPaths(figure, result);
  figure.Line("set xrange [{}:{}]", time_s.front(), time_s.back());
  ShadeGaps(figure, result.motion);
  MarkEvents(figure, result.events);
  DrawAngle(figure, result, columns, other);
  DrawDifference(figure, result, columns);
  figure.Line("unset multiplot");
  figure.Write(path);
}

}  // namespace lake::figure
