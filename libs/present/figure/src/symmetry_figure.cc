#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "lake/core/colours.h"
#include "lake/figure/gnuplot.h"
#include "lake/figure/trial_figures.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/gait/squats.h"
#include "percents.h"

namespace lake::figure {
namespace {

template <typename Row>
std::optional<std::string> NameIn(const std::string& column) {
  for (const motion::LengthUnit unit : {motion::LengthUnit::kMm, motion::LengthUnit::kPx})
    for (const gait::Field<Row>& field : Row::Fields())
      if (column == field.Column(unit)) {
        const std::string label = field.meaning;  // a phase's name goes before a colon
        return fmt::format("{} ({})", label.substr(0, label.find(':')), field.Unit(unit));
      }
  return std::nullopt;
}

// In words, with the unit.
std::string NameOf(const std::string& column, gait::MovementKind movement) {
  const auto name = movement == gait::MovementKind::kWalking ? NameIn<gait::GaitCycle>(column)
                    : movement == gait::MovementKind::kSquat ? NameIn<gait::Squat>(column)
                                                             : NameIn<gait::SitToStand>(column);
  if (name) return *name;
  if (column == "load_mean_n") return "mean force under the foot (N)";
  if (column == "load_max_n") return "largest force under the foot (N)";
  return column;
}

void DrawKnees(GnuplotFigure& figure, const compare::Symmetry& symmetry) {
  std::vector<double> left, right, difference, low, high;
  for (const compare::SideDifference& at : symmetry.knee_deg) {
    left.push_back(at.left);
    right.push_back(at.right);
    difference.push_back(at.difference);
    low.push_back(at.interval.low);
    high.push_back(at.interval.high);
  }
  const std::string data = figure.Data({Percents(left.size()), left, right, difference, low, high});
  figure.Line("set lmargin at screen 0.07; set rmargin at screen 0.45")
      .Line("set tmargin at screen 0.93; set bmargin at screen 0.50; set ylabel 'knee (°)'; set format x ''")
      .Line(
          "plot {0} using 1:2 with lines lw 3 lc rgb '{1}' title 'left', {0} using 1:3 with lines lw 3 dt 2 lc rgb "
          "'{2}' title 'right'",
          data, colour::kKnee, colour::kHip)
      .Line("set tmargin at screen 0.46; set bmargin at screen 0.09; unset key")
      .Line("set ylabel 'left less right, 95 % (°)'")
      .Line("set xlabel '{} (%)'; set format x '%g'", gait::MovementOf(symmetry.movement).repetition)
      .Line(
          "plot {0} using 1:5:6 with filledcurves fc rgb '{1}' fs transparent solid 0.3 noborder notitle, {0} using "
          "1:4 with lines lw 3 lc rgb '{1}' notitle, 0 with lines lw 1 lc rgb '#222222' notitle",
          data, colour::kKnee);
}

void DrawIndices(GnuplotFigure& figure, const compare::Symmetry& symmetry) {
  std::vector<double> row, index, low, high;
  std::string names;
  for (std::size_t i = 0; i < symmetry.quantities.size(); ++i) {
    const compare::SideDifference& of = symmetry.quantities[i];
    row.push_back(-static_cast<double>(i));
    index.push_back(of.index_percent);
    const bool has_interval = std::isfinite(of.index_interval.low);
    low.push_back(has_interval ? of.index_interval.low : of.index_percent);
    high.push_back(has_interval ? of.index_interval.high : of.index_percent);
    std::string name = NameOf(of.name, symmetry.movement);
    if (const auto percent = name.find('%'); percent != std::string::npos) name.insert(percent, 1, '%');  // a format
    names += fmt::format("{}{} -{}", names.empty() ? "" : ", ", QuoteForGnuplot(name), i);
  }
  figure.Line("set lmargin at screen 0.76; set rmargin at screen 0.97; set tmargin at screen 0.93")
      .Line("set bmargin at screen 0.09; set ytics ({}) noenhanced; unset ylabel", names)
      .Line("set yrange [-{}:0.5]; set xlabel 'symmetry index (%)'",
            static_cast<double>(symmetry.quantities.size()) - 0.5)
      .Line("set arrow from 0, graph 0 to 0, graph 1 nohead lw 1 lc rgb '#222222'")
      .Line("plot {} using 2:1:3:4 with xerrorbars pt 7 ps 1.2 lw 2 lc rgb '{}' notitle",
            figure.Data({row, index, low, high}), colour::kText);
}

}  // namespace

void DrawSymmetry(const std::filesystem::path& path, const compare::Symmetry& symmetry) {
  GnuplotFigure figure(1500, 800);
  figure.Line("set multiplot").Line("set key top right samplen 2.5");
  DrawKnees(figure, symmetry);
  DrawIndices(figure, symmetry);
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
