#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/figure/gnuplot.h"
#include "lake/figure/trial_figures.h"

namespace lake::figure {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

// Across the axis: y from the mean of the shank's markers to the axis, x to its right seen along the axis.
struct View {
  Vector3d x, y;

  explicit View(const axis::MeanAxis& whole) : y(whole.in_shank.normalized()) { x = y.cross(whole.direction_shank); }
  Vector2d operator()(const Vector3d& place) const { return {place.dot(x), place.dot(y)}; }
};

std::string PlotAxes(GnuplotFigure& figure, const axis::MeanAxesResult& axes, const View& view) {
  std::vector<double> x, y, radius;
  for (const axis::MeanAxis& axis : axes.windows) {
    const Vector2d place = view(axis.in_shank);
    x.push_back(place.x());
    y.push_back(place.y());
    radius.push_back(kEllipse95 * axis.sd_mm);
  }
  std::string plot;
  if (!x.empty())
    plot = fmt::format(
        "{0} using 1:2:3 with circles lc rgb '{1}' fs transparent solid 0.08 title 'windows, 95 %', {0} "
        "using 1:2 with points pt 7 ps 0.8 lc rgb '{1}', ",
        figure.Data({x, y, radius}), colour::kAnkle);
  const Vector2d whole = view(axes.whole.in_shank);
  return plot + fmt::format(
                    "{0} using 1:2:3 with circles lc rgb '{1}' fs transparent solid 0.25 title 'whole, 95 %', "
                    "{0} using 1:2 with points pt 2 ps 2 lw 3 lc rgb '{1}'",
                    figure.Data({{whole.x()}, {whole.y()}, {kEllipse95 * axes.whole.sd_mm}}), colour::kKnee);
}

// A square that holds the axes' ellipses and nearly all centres.
struct Square {
  Vector2d middle = Vector2d::Zero();
  double half_mm = 1;
};

Square SquareAround(const axis::MeanAxesResult& axes, const View& view, const std::vector<double> (&place)[2]) {
  Vector2d low = Vector2d::Constant(1e9), high = -low;
  const auto hold = [&](const Vector2d& at, double radius) {
    low = low.cwiseMin(Vector2d(at.array() - radius));
    high = high.cwiseMax(Vector2d(at.array() + radius));
  };
  hold(view(axes.whole.in_shank), kEllipse95 * axes.whole.sd_mm);
  for (const axis::MeanAxis& axis : axes.windows) hold(view(axis.in_shank), kEllipse95 * axis.sd_mm);
  constexpr double kNearlyAll[] = {0.005, 0.995};
  for (const double share : kNearlyAll)
    if (!place[0].empty()) hold({Quantile(place[0], share), Quantile(place[1], share)}, 0);
  constexpr double kRoom = 1.05;
  return {(low + high) / 2, kRoom * (high - low).maxCoeff() / 2};
}

// Over the knee angle: means of two degrees each.
struct Course {
  std::vector<double> angle_deg, place[2], low[2], high[2];
};

Course CourseOf(const std::vector<const axis::InstantaneousCentre*>& by_angle, const View& view) {
  constexpr double kBin_deg = 2;
  Course course;
  for (auto first = by_angle.begin(); first != by_angle.end();) {
    const auto last = std::find_if(first, by_angle.end(), [&](const axis::InstantaneousCentre* centre) {
      return centre->knee_deg > (*first)->knee_deg + kBin_deg;
    });
    const auto mean = [&](auto figure) {
      double sum = 0;
      for (auto one = first; one != last; ++one) sum += figure(**one);
      return sum / static_cast<double>(last - first);
    };
    using Centre = axis::InstantaneousCentre;
    course.angle_deg.push_back(mean([](const Centre& c) { return c.knee_deg; }));
    const double half_mm = kNormal95 * mean([](const Centre& c) { return c.sd_mm.norm() / std::sqrt(2); });
    for (int k = 0; k < 2; ++k) {
      const double at = mean([&](const Centre& c) { return view(c.in_shank)[k]; });
      course.place[k].push_back(at);
      course.low[k].push_back(at - half_mm);
      course.high[k].push_back(at + half_mm);
    }
    first = last;
  }
  return course;
}

}  // namespace

void DrawAxis(const std::filesystem::path& path, const axis::SegmentMotion& motion, const axis::MeanAxesResult& axes,
              const std::vector<axis::InstantaneousCentre>& centres) {
  const View view(axes.whole);
  std::vector<const axis::InstantaneousCentre*> by_angle;
  for (const axis::InstantaneousCentre& centre : centres) by_angle.push_back(&centre);
  std::ranges::sort(by_angle, {}, &axis::InstantaneousCentre::knee_deg);
  std::vector<double> angle, place[2];
  for (const axis::InstantaneousCentre* centre : by_angle) {
    angle.push_back(centre->knee_deg);
    for (int k = 0; k < 2; ++k) place[k].push_back(view(centre->in_shank)[k]);
  }
  const Course course = CourseOf(by_angle, view);
  GnuplotFigure figure(1600, 800);
  figure.Line(
      "set multiplot title {} noenhanced font ',14'",
      QuoteForGnuplot(fmt::format("Axis over {:.0f} degrees of flexion; markers deviate by {:.1f} mm "
                                  "on the shank, {:.1f} mm on the thigh",
                                  axes.whole.flexion_deg, motion.shank.marker_sd_mm, motion.thigh.marker_sd_mm)));
  const Square square = SquareAround(axes, view, place);
  figure.Line(
      "set lmargin at screen 0.07; set rmargin at screen 0.455; set tmargin at screen 0.88; set bmargin at screen "
      "0.11; set key at screen 0.2625, screen 0.93 center horizontal Left reverse maxrows 1 samplen 1 width -2 font "
      "',12' noautotitle");
  figure.Line("set xrange [{}:{}]; set yrange [{}:{}]", square.middle.x() - square.half_mm,
              square.middle.x() + square.half_mm, square.middle.y() - square.half_mm,
              square.middle.y() + square.half_mm);
  figure.Line("set xlabel 'across the shank (mm)'; set ylabel 'along the shank, from the mean of its markers (mm)'");
  figure.Line("plot " + PlotAxes(figure, axes, view) +
              fmt::format(", {} using 1:2 with points pt 7 ps 0.3 lc rgb '{}' title 'axis frame by frame'",
                          figure.Data({place[0], place[1]}), colour::kText));
  figure.Line("set autoscale; set lmargin at screen 0.57; set rmargin at screen 0.97; unset key");
  const char* names[] = {"across the shank (mm)", "along the shank (mm)"};
  for (int k = 0; k < 2; ++k) {
    figure.Line("set tmargin at screen {}; set bmargin at screen {}; set ylabel '{}'; set xlabel '{}'",
                k == 0 ? 0.88 : 0.46, k == 0 ? 0.53 : 0.11, names[k], k == 0 ? "" : "knee angle (degrees)");
    figure.Line(
        "plot {} using 1:2:3 with filledcurves fc rgb '{}' fs transparent solid 0.25 noborder, {} using 1:2 with "
        "points pt 7 ps 0.2 lc rgb '{}', {} using 1:2 with lines lw 2 lc rgb '{}'",
        figure.Data({course.angle_deg, course.low[k], course.high[k]}), colour::kKnee, figure.Data({angle, place[k]}),
        colour::kText, figure.Data({course.angle_deg, course.place[k]}), colour::kKnee);
  }
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
