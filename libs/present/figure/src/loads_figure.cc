#include <fmt/format.h>

#include <cmath>

#include "lake/core/colours.h"
#include "lake/core/numbers.h"
#include "lake/figure/design_figures.h"
#include "lake/figure/gnuplot.h"
#include "percents.h"

namespace lake::figure {
namespace {

std::vector<double> Column(const loads::RiseLoads& rise, double loads::LoadsRow::*member) {
  std::vector<double> values;
  for (const loads::LoadsRow& row : rise.rows) values.push_back(row.*member);
  return values;
}

// A column where the knee's moment is known, or only where it is not.
std::vector<double> Masked(const loads::RiseLoads& rise, double loads::LoadsRow::*member, bool known) {
  std::vector<double> values = Column(rise, member);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(rise.rows[i].knee_nm) != known) values[i] = loads::LoadsRow::kUnknown;
  return values;
}

std::string CurveOf(GnuplotFigure& figure, const loads::RiseLoads& rise, double loads::LoadsRow::*member,
                    const std::string& style) {
  return fmt::format("{} using 1:2 with lines {}", figure.Data({Percents(loads::kPercents), Column(rise, member)}),
                     style);
}

// All rises thin, then their mean.
std::string RisesAndMean(GnuplotFigure& figure, const loads::LoadsResult& result, double loads::LoadsRow::*member,
                         const char* colour) {
  std::string plot;
  for (const loads::RiseLoads& rise : result.rises)
    plot += CurveOf(figure, rise, member, fmt::format("lw 1 lc rgb '{}'", colour::kGuide)) + ", ";
  return plot + CurveOf(figure, result.mean, member, fmt::format("lw 4 lc rgb '{}' title 'mean'", colour));
}

void DrawKnee(GnuplotFigure& figure, const loads::LoadsResult& result) {
  using loads::LoadsRow;
  figure.Line(
      "set lmargin at screen 0.09; set rmargin at screen 0.60; set tmargin at screen 0.90; set bmargin at screen 0.09");
  figure.Line("set xlabel '{} (%)'; set ylabel 'knee extension moment, one leg (N m)'", result.repetition);
  const loads::RiseLoads& mean = result.mean;
  const auto band = [&](bool known) {
    return figure.Data({Percents(loads::kPercents), Masked(mean, &LoadsRow::knee_low_nm, known),
                        Masked(mean, &LoadsRow::knee_high_nm, known)});
  };
  std::string plot = fmt::format(
      "plot {} using 1:2:3 with filledcurves fc rgb '{}' fs transparent solid 0.30 noborder title '95 % band of the "
      "mean', ",
      band(true), colour::kKnee);
  if (!result.from_ground)
    plot += fmt::format(
        "{} using 1:2:3 with filledcurves fc rgb '{}' fs solid 1 noborder title 'seat: all weight to none', ",
        band(false), colour::kGap);
  plot += RisesAndMean(figure, result, &LoadsRow::knee_nm, colour::kKnee);
  std::vector<double> percents, peaks;
  for (const loads::RiseLoads& rise : result.rises) {
    percents.push_back(rise.peak.percent);
    peaks.push_back(rise.peak.knee_nm);
  }
  plot += fmt::format(", {} using 1:2 with points pt 7 ps 1.3 lc rgb '{}' title 'peak of each {}'",
                      figure.Data({percents, peaks}), colour::kText, result.repetition);
  figure.Line(plot + ", 0 with lines lw 1 lc rgb '#222222'");
}

void DrawJoints(GnuplotFigure& figure, const loads::LoadsResult& result) {
  using loads::LoadsRow;
  figure.Line(
      "set lmargin at screen 0.70; set rmargin at screen 0.98; set tmargin at screen 0.90; set bmargin at screen 0.70");
  figure.Line("set key at graph 1, graph 1.02 right bottom horizontal samplen 1.5 width -1 noautotitle");
  figure.Line("unset xlabel; set format x ''; set ytics 20; set ylabel 'moments (N m)'");
  const auto joint = [&](double LoadsRow::*member, const char* colour, const char* name) {
    return CurveOf(figure, result.mean, member, fmt::format("lw 3 lc rgb '{}' title '{}'", colour, name));
  };
  const std::string hip = joint(&LoadsRow::hip_nm, colour::kHip, "hip"),
                    knee = joint(&LoadsRow::knee_nm, colour::kKnee, "knee"),
                    ankle = joint(&LoadsRow::ankle_nm, colour::kAnkle, "ankle");
  figure.Line("plot " + hip + ", " + knee + ", " + ankle + ", 0 with lines lw 1 lc rgb '#222222'");
}

void DrawPressure(GnuplotFigure& figure, const loads::LoadsResult& result) {
  const double heel_mm = -kMmPerM * result.body.sole.heel_m, toe_mm = kMmPerM * result.body.sole.toe_m;
  figure.Line(
      "set tmargin at screen 0.61; set bmargin at screen 0.41; set ytics 100; set ylabel 'centre of pressure (mm)'");
  figure.Line("set yrange [{}:{}]", heel_mm - 60, toe_mm + 60);
  figure.Line("plot " + RisesAndMean(figure, result, &loads::LoadsRow::zmp_mm, colour::kAnkle) +
              fmt::format(", {} with lines lw 2 dt 2 lc rgb '{}' title 'heel, toe', {} with lines lw 2 dt 2 lc rgb "
                          "'{}', 0 with lines lw 1 lc rgb '#222222'",
                          heel_mm, colour::kText, toe_mm, colour::kText));
}

void DrawPower(GnuplotFigure& figure, const loads::LoadsResult& result) {
  figure.Line(
      "set tmargin at screen 0.32; set bmargin at screen 0.09; set yrange [*:*]; set ytics autofreq; set format x "
      "'%g'");
  figure.Line("set xlabel '{} (%)'; set ylabel 'knee power (W)'", result.repetition);
  figure.Line("plot " + RisesAndMean(figure, result, &loads::LoadsRow::knee_power_w, colour::kKnee) +
              ", 0 with lines lw 1 lc rgb '#222222'");
}

}  // namespace

void DrawLoads(const std::filesystem::path& path, const loads::LoadsResult& result, const std::string& title) {
  GnuplotFigure figure(1100, 860);
  figure.Line("set multiplot title {} noenhanced font ',14'",
              QuoteForGnuplot(title + (result.from_ground ? ", from the ground's forces" : ", without force plates")));
  figure.Line("set xrange [0:100]; set key top right samplen 2.5 noautotitle");
  DrawKnee(figure, result);
  DrawJoints(figure, result);
  DrawPressure(figure, result);
  DrawPower(figure, result);
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
