#include "chart_data.h"

#include <array>

#include "lake/core/colours.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"

namespace lake::report {
namespace {

// Okabe & Ito (2008), as colours.h has them for the figures.
constexpr std::array kPalette = {colour::kAnkle, colour::kExoskeleton, colour::kHip,
                                 colour::kWaist, colour::kHuman,       colour::kOther};

std::string ColourOr(const std::string& colour, std::size_t index) {
  return colour.empty() ? kPalette[index % kPalette.size()] : colour;
}

// Infinities, like NaN, are gaps.
Json Numbers(const std::vector<double>& values) {
  Json numbers = Json::array();
  for (const double value : values) numbers.push_back(NumberOrNull(value));
  return numbers;
}

Json AxisData(const Axis& axis) {
  return {{"label", axis.label}, {"from", ValueOrNull(axis.from)}, {"to", ValueOrNull(axis.to)}};
}

void CheckLength(const std::string& chart, const std::string& series, const char* column, std::size_t length,
                 std::size_t expected, bool may_be_empty) {
  if (length == expected || (may_be_empty && length == 0)) return;
  throw Fail("report: chart '{}', series '{}': {} values in {} where {} are needed", chart, series, length, column,
             expected);
}

const char* ToString(Mark mark) {
  switch (mark) {
    case Mark::kLine:
      return "line";
    case Mark::kThin:
      return "thin";
    case Mark::kDashed:
      return "dashed";
    case Mark::kDotted:
      return "dotted";
    case Mark::kPoints:
      return "points";
  }
  return "line";
}

Json SeriesData(const LineChart& chart, const Series& series, std::size_t index) {
  const auto check = [&](const char* column, std::size_t length, bool may_be_empty) {
    CheckLength(chart.title, series.name, column, length, series.x.size(), may_be_empty);
  };
  check("y", series.y.size(), false);
  check("labels", series.labels.size(), true);
  check("lower", series.lower.size(), true);
  check("upper", series.upper.size(), series.lower.empty());
  return {{"name", series.name},
          {"x", Numbers(series.x)},
          {"y", Numbers(series.y)},
          {"lower", Numbers(series.lower)},
          {"upper", Numbers(series.upper)},
          {"colour", ColourOr(series.colour, index)},
          {"mark", ToString(series.mark)},
          {"labels", series.labels}};
}

Json BarSeriesData(const BarChart& chart, const BarSeries& series, std::size_t index) {
  const std::size_t bars = chart.categories.size();
  const auto check = [&](const char* column, std::size_t length, bool may_be_empty) {
    CheckLength(chart.title, series.name, column, length, bars, may_be_empty);
  };
  check("values", series.values.size(), false);
  check("lower", series.lower.size(), true);
  check("upper", series.upper.size(), series.lower.empty());
  Json colours = Json::array();
  if (series.colours.size() <= 1) {
    colours.push_back(ColourOr(series.colours.empty() ? "" : series.colours[0], index));
  } else {
    check("colours", series.colours.size(), false);
    colours = series.colours;
  }
  return {{"name", series.name},
          {"values", Numbers(series.values)},
          {"lower", Numbers(series.lower)},
          {"upper", Numbers(series.upper)},
          {"colours", colours}};
}

}  // namespace

Json ChartData(const LineChart& chart) {
  Json data = {{"kind", "line"},         {"title", chart.title},        {"x", AxisData(chart.x)},
               {"y", AxisData(chart.y)}, {"equal", chart.equal_scales}, {"series", Json::array()},
               {"lines", Json::array()}, {"intervals", Json::array()}};
  for (std::size_t i = 0; i < chart.series.size(); ++i) data["series"].push_back(SeriesData(chart, chart.series[i], i));
  for (const VerticalLine& line : chart.lines) data["lines"].push_back({{"x", line.x}, {"label", line.label}});
  for (const ShadedInterval& interval : chart.intervals)
    data["intervals"].push_back({{"from", interval.from}, {"to", interval.to}, {"label", interval.label}});
  return data;
}

Json ChartData(const BarChart& chart) {
  Json data = {{"kind", "bar"},
               {"title", chart.title},
               {"x", AxisData(chart.value_axis)},
               {"decimals", chart.decimals},
               {"categories", chart.categories},
               {"series", Json::array()}};
  for (std::size_t i = 0; i < chart.series.size(); ++i)
    data["series"].push_back(BarSeriesData(chart, chart.series[i], i));
  return data;
}

}  // namespace lake::report
