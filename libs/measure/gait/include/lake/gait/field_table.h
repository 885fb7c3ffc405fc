// Tables of measures that fields describe: means, CSV, JSON and lines for the terminal.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lake/core/csv.h"
#include "lake/core/json_or_null.h"
#include "lake/core/statistics.h"
#include "lake/gait/field.h"

namespace lake::gait {

inline constexpr std::string_view kBegin = "begin_s";  // when a repetition begins: no mean is taken of it

// Of rows with one, whose own errors are mostly alike, so that the mean has them too: the mean with its standard
// deviation, and over the rows the standard deviation (as value; NaN of a single one).
template <typename Row>
void Average(std::span<const Field<Row>> fields, std::span<const Row> rows, Row& mean, Row& spread) {
  for (const Field<Row>& field : fields) {
    std::vector<double> values, sds;
    for (const Row& row : rows)
      if (const Measured& measured = row.*field.value; std::isfinite(measured.value)) {
        values.push_back(measured.value);
        sds.push_back(measured.sd);
      }
    if (values.empty() || field.name == kBegin) continue;
    const double over_rows = values.size() > 1 ? StandardDeviation(values) : NAN;
    const double of_mean = values.size() > 1 ? over_rows / std::sqrt(static_cast<double>(values.size())) : 0;
    mean.*field.value = {Mean(values), std::hypot(RootMeanSquare(sds), of_mean)};
    spread.*field.value = {over_rows, NAN};
  }
}

// A row for each with its number (`of` names that column), then `mean` and `sd`; the values, then their standard
// deviations (…_sd).
template <typename Row>
void WriteFieldsCsv(const std::filesystem::path& path, const char* of, int Row::*number,
                    std::span<const Field<Row>> fields, std::span<const Row> rows, const Row& mean, const Row& spread,
                    motion::LengthUnit of_plane) {
  std::vector<std::string> header = {of};
  for (const char* ending : {"", "_sd"})
    for (const Field<Row>& field : fields) header.push_back(field.Column(of_plane) + ending);
  CsvWriter csv(header);
  const auto add = [&](const std::string& name, const Row& row) {
    csv.Add(name);
    for (const Field<Row>& field : fields) csv.Add((row.*field.value).value);
    for (const Field<Row>& field : fields) csv.Add((row.*field.value).sd);
    csv.EndRow();
  };
  for (const Row& row : rows) add(std::to_string(row.*number), row);
  add("mean", mean);
  add("sd", spread);
  csv.Write(path);
}

// By column: mean, its standard deviation, that over the rows, and their coefficient of variation.
template <typename Row>
Json FieldsJson(std::span<const Field<Row>> fields, const Row& mean, const Row& spread, motion::LengthUnit of_plane) {
  Json measures = Json::object();
  for (const Field<Row>& field : fields) {
    const Measured& of = mean.*field.value;
    if (!std::isfinite(of.value)) continue;
    const double over_rows = (spread.*field.value).value;
    measures[field.Column(of_plane)] = {{"mean", of.value},
                                        {"mean_sd", NumberOrNull(of.sd)},
                                        {"sd", NumberOrNull(over_rows)},
                                        {"variation_percent", NumberOrNull(100 * over_rows / of.value)}};
  }
  return measures;
}

template <typename Row>
std::string FieldsText(std::span<const Field<Row>> fields, const Row& mean, motion::LengthUnit of_plane) {
  std::string text;
  for (const Field<Row>& field : fields)
    if (const Measured& of = mean.*field.value; std::isfinite(of.value))
      text +=
          fmt::format("{}  {:.{}f} ± {:.{}f}\n", field.Column(of_plane), of.value, field.digits, of.sd, field.digits);
  return text;
}

}  // namespace lake::gait
