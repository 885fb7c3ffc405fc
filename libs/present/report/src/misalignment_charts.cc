#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/compare/decomposition.h"
#include "lake/core/colours.h"
#include "lake/core/json.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/gait/movement.h"
#include "lake/report/misalignment_sections.h"
#include "lake/report/uncertain.h"

namespace lake::report {

namespace {

// Of the misalignment's parts, in their order.
constexpr std::array kPartColours = {colour::kAnkle, colour::kHip, colour::kWaist, colour::kKnee};
constexpr std::array kPartMarks = {Mark::kLine, Mark::kDashed, Mark::kDotted, Mark::kLine};
static_assert(compare::kParts.size() <= kPartColours.size());

Axis PercentAxis(const Json& comparison) {
  return {RepetitionIn(comparison) + " (%)", 0, 100};
}

std::vector<double> Scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

std::vector<std::string> PercentLabels(const std::vector<double>& percents) {
  std::vector<std::string> labels;
  for (const double percent : percents) labels.push_back(fmt::format("{:g} %", percent));
  return labels;
}

// Between both knees at the same percent.
Series Ties(const Series& human, const Series& exo) {
  constexpr std::size_t kStep = 10;
  Series ties{.name = fmt::format("same moment, every {} %", kStep), .colour = colour::kGuide, .mark = Mark::kThin};
  for (std::size_t i = 0; i < human.x.size(); i += kStep) {
    ties.x.insert(ties.x.end(), {human.x[i], exo.x[i], kNaN});
    ties.y.insert(ties.y.end(), {human.y[i], exo.y[i], kNaN});
    ties.labels.insert(ties.labels.end(), {human.labels[i], exo.labels[i], ""});
  }
  return ties;
}

Series Start(const Series& human, const Series& exo, const char* name) {
  return {.name = name,
          .x = {human.x.front(), exo.x.front()},
          .y = {human.y.front(), exo.y.front()},
          .colour = colour::kText,
          .mark = Mark::kPoints,
          .labels = {human.labels.front(), exo.labels.front()}};
}

Series Level(double value, std::string name, std::string colour, Mark mark) {
  return {.name = std::move(name), .x = {0, 100}, .y = {value, value}, .colour = std::move(colour), .mark = mark};
}

std::vector<double> Lengths(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < x.size(); ++i) lengths.push_back(std::hypot(x[i], y[i]));
  return lengths;
}

// The misalignment in percent of the shank, with ± 1 SD over the pairs of repetitions if there are several.
Series ErrorSeries(const Json& curves) {
  Series error{.name = "path difference",
               .x = NumbersOrNaN(curves.at("percent")),
               .y = Scaled(NumbersOrNaN(curves.at("relative_error")), 100),
               .colour = colour::kExoskeleton};
  const std::vector<double> sd = Scaled(NumbersOrNaN(curves.at("relative_error_sd")), 100);
  for (std::size_t i = 0; i < sd.size(); ++i) {
    error.lower.push_back(std::max(0.0, error.y[i] - sd[i]));
    error.upper.push_back(error.y[i] + sd[i]);
  }
  return error;
}

Series SpikesOf(const Series& error, const Json& spike) {
  Series spikes{.name = "spike", .colour = colour::kWaist, .mark = Mark::kPoints};
  for (std::size_t i = 0; i < error.x.size(); ++i) {
    if (!spike.at(i).get<bool>()) continue;
    spikes.x.push_back(error.x[i]);
    spikes.y.push_back(error.y[i]);
  }
  return spikes;
}

}  // namespace

bool IsOfWalking(const Json& comparison) {
  return comparison.value("movement", "") == gait::MovementOf(gait::MovementKind::kWalking).name;
}

std::string RepetitionIn(const Json& comparison) {
  return gait::MovementOf(IsOfWalking(comparison) ? gait::MovementKind::kWalking : gait::MovementKind::kSitToStand)
      .repetition;
}

// Of walking the legs hang from one hip, and 100 % is 0 % again.
LineChart LegsChart(const Json& comparison) {
  const Json& curves = comparison.at("curves");
  const bool is_walking = IsOfWalking(comparison);
  const auto legs = [&](const std::string& trial, const char* name, const char* colour, Mark mark) {
    Series series{.name = name, .colour = colour, .mark = mark};
    for (const std::size_t percent : {0, 50, 100}) {
      if (is_walking && percent == 100) continue;
      for (const char* joint : {"ankle", "knee", "hip"}) {
        series.x.push_back(NumberOrNaN(curves.at(fmt::format("{}_{}_x_mm", trial, joint)).at(percent)));
        series.y.push_back(NumberOrNaN(curves.at(fmt::format("{}_{}_y_mm", trial, joint)).at(percent)));
      }
      series.x.push_back(kNaN);
      series.y.push_back(kNaN);
    }
    return series;
  };
  return {.title = is_walking ? "Legs at 0 and 50 % of the stride, relative to the hip" : "Legs at 0, 50 and 100 %",
          .x = {.label = "anterior (mm)"},
          .y = {.label = "up (mm)"},
          .series = {legs("human", "human", colour::kHuman, Mark::kLine),
                     legs("exo", "worn exoskeleton", colour::kExoskeleton, Mark::kDotted)},
          .equal_scales = true};
}

LineChart KneePathsChart(const Json& comparison) {
  const Json& curves = comparison.at("curves");
  const auto path = [&](const std::string& prefix, const char* name, const char* colour) {
    return Series{.name = name,
                  .x = NumbersOrNaN(curves.at(prefix + "_x_mm")),
                  .y = NumbersOrNaN(curves.at(prefix + "_y_mm")),
                  .colour = colour,
                  .labels = PercentLabels(NumbersOrNaN(curves.at("percent")))};
  };
  const Series human = path("human_knee", "human knee", colour::kHuman);
  const Series exo = path("exo_knee", "exoskeleton knee", colour::kExoskeleton);
  const bool is_walking = IsOfWalking(comparison);
  return {.title = "Both knees on the sagittal plane",
          .alt = fmt::format("Paths of the human knee and of the exoskeleton's knee over the {}, seen from the side",
                             RepetitionIn(comparison)),
          .caption = is_walking ? "Mean paths relative to the hip, x in the direction of walking, y up."
                                : "Mean paths in the leg frame: origin at the seated ankle, x forward, y up.",
          .x = {.label = "anterior (mm)"},
          .y = {.label = "up (mm)"},
          .series = {human, exo, Ties(human, exo), Start(human, exo, is_walking ? "heel strike" : "onset")},
          .equal_scales = true};
}

LineChart PathDifferenceChart(const Json& comparison) {
  const Json& curves = comparison.at("curves");
  const Uncertain rms = FactOf(comparison, kPathPercent);
  const double floor = 100 * NumberAt(comparison, "noise_floor_relative");
  LineChart chart;
  chart.title = "Path difference over the " + RepetitionIn(comparison);
  chart.alt = fmt::format("Distance of the knees in percent of the shank over the {}; RMS {} %",
                          RepetitionIn(comparison), rms.Text());
  chart.x = PercentAxis(comparison);
  chart.y = {"path difference (% of the shank)", 0, std::nullopt};
  const Series error = ErrorSeries(curves);
  if (!error.lower.empty())
    chart.caption =
        fmt::format("Band: ± 1 SD over all pairs of a human and an exoskeleton {}.", RepetitionIn(comparison));
  chart.series = {
      error, Level(rms.value, fmt::format("RMS {} %", rms.Text()), colour::kText, Mark::kDashed),
      Level(floor, fmt::format("noise floor {} %", SignificantText(floor, 2)), colour::kAnkle, Mark::kDotted)};
  Series spikes = SpikesOf(error, curves.at("spike"));
  if (!spikes.x.empty()) chart.series.push_back(std::move(spikes));
  return chart;
}

std::optional<LineChart> JointChart(const Json& comparison) {
  const Json uncertainty = comparison.value("uncertainty", Json::object());
  const Json& curves = comparison.at("curves");
  // A rise in which the leg's own knee is hidden leaves no mean path of it.
  if (!uncertainty.contains("joint_frame_mm") || curves.at("exo_leg_knee_x_mm").empty()) return std::nullopt;
  const Json& frame = uncertainty.at("joint_frame_mm");
  const auto joint_less_knee = [&](const char* axis) {
    std::vector<double> joint = NumbersOrNaN(curves.at(fmt::format("exo_knee_{}_mm", axis)));
    const std::vector<double> knee = NumbersOrNaN(curves.at(fmt::format("exo_leg_knee_{}_mm", axis)));
    for (std::size_t i = 0; i < joint.size(); ++i) joint[i] -= knee[i];
    return joint;
  };
  const std::vector<double> distance_mm = Lengths(joint_less_knee("x"), joint_less_knee("y"));
  const auto with_band = [&](const char* name, const char* sd, const char* colour, Mark mark) {
    const double half_mm = kNormal95 * NumberOrNaN(frame.at(sd));
    Series series{
        .name = name, .x = NumbersOrNaN(curves.at("percent")), .y = distance_mm, .colour = colour, .mark = mark};
    for (const double distance : distance_mm) {
      series.lower.push_back(std::max(0.0, distance - half_mm));
      series.upper.push_back(distance + half_mm);
    }
    return series;
  };
  LineChart chart;
  chart.title = "Joint misalignment over the " + RepetitionIn(comparison);
  chart.alt = "Distance of the exoskeleton's joint from the knee of the leg that wears it, with both bands";
  chart.caption =
      "Bands: where a frame's distance is with 95 %, as the markers tell it, and from the knee beneath the skin, which "
      "slides as the knee bends.";
  chart.x = PercentAxis(comparison);
  chart.y = {"joint from the knee (mm)", 0, std::nullopt};
  chart.series = {with_band("from the knee beneath the skin", "anatomical_sd", colour::kGuide, Mark::kThin),
                  with_band("from the knee's marker", "marker_sd", colour::kExoskeleton, Mark::kLine)};
  return chart;
}

BarChart DecompositionChart(const Json& comparison) {
  BarChart chart;
  chart.title = "What the misalignment is made of";
  chart.value_axis.label = "share of the mean square distance (%)";
  BarSeries share;
  share.name = "share";
  std::vector<std::string> shares;
  for (const compare::Part& of : compare::kParts) {
    const Json& part = comparison.at("decomposition").at(of.name);
    share.colours.push_back(kPartColours[chart.categories.size()]);
    chart.categories.push_back(of.name);
    share.values.push_back(100 * NumberAt(part, "fraction"));
    shares.push_back(fmt::format("{} {} %", of.name, NumberText(share.values.back(), 1)));
    if (part.at("interval").is_null()) continue;
    share.lower.push_back(100 * NumberAt(part, "interval/0"));
    share.upper.push_back(100 * NumberAt(part, "interval/1"));
  }
  chart.alt = std::isfinite(share.values[0]) ? fmt::format("Shares: {}", fmt::join(shares, ", "))
                                             : "Both paths are one; there are no parts";
  if (!share.lower.empty()) chart.caption = "Whiskers: 95 % intervals.";
  chart.series = {std::move(share)};
  return chart;
}

LineChart PartsChart(const Json& comparison) {
  const Json& curves = comparison.at("curves");
  LineChart chart;
  chart.title = "Size of each part over the " + RepetitionIn(comparison);
  chart.caption = "Lengths of three vectors that add up to the distance vector; they need not add up as lengths.";
  chart.x = PercentAxis(comparison);
  chart.y = {"length (mm)", 0, std::nullopt};
  for (const compare::Part& part : compare::kParts) {
    const std::string name = part.name;
    chart.series.push_back(
        {.name = name,
         .x = NumbersOrNaN(curves.at("percent")),
         .y = Lengths(NumbersOrNaN(curves.at(name + "_x_mm")), NumbersOrNaN(curves.at(name + "_y_mm"))),
         .colour = kPartColours[chart.series.size()],
         .mark = kPartMarks[chart.series.size()]});
  }
  return chart;
}

LineChart KneeAnglesChart(const Json& comparison) {
  const Json& curves = comparison.at("curves");
  const auto angle = [&](const char* name, const char* column, const char* colour, Mark mark) {
    return Series{.name = name,
                  .x = NumbersOrNaN(curves.at("percent")),
                  .y = NumbersOrNaN(curves.at(column)),
                  .colour = colour,
                  .mark = mark};
  };
  return {.title = "Knee angles",
          .alt = "Knee angles of both trials over the " + RepetitionIn(comparison),
          .caption = fmt::format("0° is straight. RMS difference {}°.", FactOf(comparison, kKneeRmse).Text()),
          .x = PercentAxis(comparison),
          .y = {.label = "knee flexion (°)"},
          .series = {angle("human", "human_knee_deg", colour::kHuman, Mark::kLine),
                     angle("exoskeleton", "exo_knee_deg", colour::kExoskeleton, Mark::kDashed)}};
}

}  // namespace lake::report
