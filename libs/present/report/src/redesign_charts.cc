#include "lake/report/redesign_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "lake/core/colours.h"
#include "lake/core/uncertain_text.h"
#include "lake/report/uncertain.h"

namespace lake::report {

LineChart ParetoChart(const Json& summary) {
  constexpr Mark kMarks[] = {Mark::kLine, Mark::kDashed, Mark::kDotted};
  LineChart chart;
  chart.title = "Range of rotation against path difference";
  chart.alt = "Pareto fronts: the least path difference for each range of rotation";
  chart.caption =
      "Path difference: RMS, of the shank length. Each point is a design of its own. With the same stroke program none "
      "has more range and a smaller path difference; the programs differ in the time that a rise takes.";
  chart.x.label = "range of rotation (°)";
  chart.y = {"path difference (%)", 0, std::nullopt};  // short, as a legend of so many names leaves little height
  for (const Json& front : summary.at("pareto")) {
    Series series{.name = front.at("program").get<std::string>() + " program",
                  .colour = colour::kFronts[chart.series.size() % std::size(colour::kFronts)],
                  .mark = kMarks[chart.series.size() % std::size(kMarks)]};
    for (const Json& point : front.at("range_deg_and_misalignment_percent")) {
      series.x.push_back(NumberOrNaN(point.at(0)));
      series.y.push_back(NumberOrNaN(point.at(1)));
    }
    chart.series.push_back(std::move(series));
  }
  const auto add = [&](const char* design, const char* name, const char* colour) {
    const Json& of = summary.at(design);
    if (!of.is_object() || !of.at("range_deg").is_number() || !of.at("misalignment_percent").is_number()) return;
    chart.series.push_back({.name = name,
                            .x = {NumberAt(of, "range_deg")},
                            .y = {NumberAt(of, "misalignment_percent")},
                            .colour = colour,
                            .mark = Mark::kPoints});
  };
  add("before", "worn", colour::kWorn);
  add("joint_moved", "worn, joint moved", colour::kHip);
  add("other_program", "worn, other program", colour::kKnee);
  add("after", "new design", colour::kNew);
  double least_deg = NumberAt(summary, "range_deg"), most_deg = least_deg;
  for (const Series& series : chart.series)
    for (const double range_deg : series.x) {
      least_deg = std::min(least_deg, range_deg);
      most_deg = std::max(most_deg, range_deg);
    }
  chart.x.from = std::floor(least_deg / 5 - 0.2) * 5;
  chart.x.to = std::ceil(most_deg / 5 + 0.2) * 5;
  if (const Json limit = summary.value("max_misalignment_percent", Json()); limit.is_number())
    chart.series.push_back({.name = fmt::format("limit {} %", SignificantText(limit.get<double>(), 3)),
                            .x = {*chart.x.from, *chart.x.to},
                            .y = {limit.get<double>(), limit.get<double>()},
                            .colour = colour::kText,
                            .mark = Mark::kThin});
  return chart;
}

}  // namespace lake::report
