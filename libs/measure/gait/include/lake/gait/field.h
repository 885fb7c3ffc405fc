// One measure of a movement, described once: CSV, summary, lines for the terminal and the reference of columns follow.
#pragma once

#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/csv.h"
#include "lake/core/json_or_null.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/motion/marker_recording.h"

namespace lake::gait {

// A value with its standard deviation; NaN where not known.
struct Measured {
  double value = NAN, sd = NAN;
};

inline constexpr const char* kLake = "lake";  // the source of what is defined here

enum class FieldKind {
  kUsual,
  kMoment,  // a time of the recording, of which there is no mean
  kOnlyMm   // not measured in px
};

template <typename Row>
struct Field {
  const char* name;  // of the column, with its unit; lengths are in mm, which px replaces where there is no scale
  const char* unit;
  const char* meaning;
  const char* source;  // a publication, or kLake
  Measured Row::*value;
  int digits;  // decimals at the terminal, where the standard deviation is not known
  FieldKind kind = FieldKind::kUsual;

  std::string Column(motion::LengthUnit of_plane) const { return InUnit(name, of_plane); }
  std::string Unit(motion::LengthUnit of_plane) const {  // for pages and figures
    const std::string in_unit = InUnit(unit, of_plane);
    return in_unit.starts_with("deg") ? "°" + in_unit.substr(3) : in_unit;
  }

 private:
  std::string InUnit(std::string text, motion::LengthUnit of_plane) const {
    const auto mm = text.starts_with("mm") ? 0 : text.find("_mm");  // no part of a word
    if (mm != std::string::npos && kind != FieldKind::kOnlyMm) text.replace(text.find("mm", mm), 2, ToString(of_plane));
    return text;
  }
};

// What is measured of each repetition of a movement. A Row has a number, `repetition` as in events.csv, and Fields().
template <typename Row>
struct Measures {
  std::vector<Row> rows;
  Row mean = {};    // with the standard deviations of the means
  Row spread = {};  // values: standard deviations over the rows; NaN of a single one
};

// The rows' own errors are mostly alike, so that their means have them too.
template <typename Row>
Measures<Row> WithMeans(std::vector<Row> rows) {
  Measures<Row> of{std::move(rows)};
  for (const Field<Row>& field : Row::Fields()) {
    std::vector<double> values, sds;
    for (const Row& row : of.rows)
      if (const Measured& measured = row.*field.value; std::isfinite(measured.value)) {
        values.push_back(measured.value);
        sds.push_back(measured.sd);
      }
    if (values.empty() || field.kind == FieldKind::kMoment) continue;
    const double over_rows = values.size() > 1 ? StandardDeviation(values) : NAN;
    const double of_mean = values.size() > 1 ? over_rows / std::sqrt(static_cast<double>(values.size())) : 0;
    of.mean.*field.value = {Mean(values), std::hypot(RootMeanSquare(sds), of_mean)};
    of.spread.*field.value = {over_rows, NAN};
  }
  return of;
}

// Rows with their names; `of` names that column; the values of the fields, then their standard deviations (…_sd).
template <typename Row>
void WriteRows(const std::filesystem::path& path, const char* of, std::span<const Field<Row>> fields,
               const std::vector<std::pair<std::string, Row>>& rows, motion::LengthUnit of_plane) {
  std::vector<std::string> header = {of};
  for (const char* ending : {"", "_sd"})
    for (const Field<Row>& field : fields) header.push_back(field.Column(of_plane) + ending);
  CsvWriter csv(header);
  for (const auto& [name, row] : rows) {
    csv.Add(name);
    for (const Field<Row>& field : fields) csv.Add((row.*field.value).value);
    for (const Field<Row>& field : fields) csv.Add((row.*field.value).sd);
    csv.EndRow();
  }
  csv.Write(path);
}

// The repetitions, then `mean` and `sd`.
template <typename Row>
void WriteMeasures(const std::filesystem::path& path, const char* of, const Measures<Row>& measures,
                   motion::LengthUnit of_plane) {
  std::vector<std::pair<std::string, Row>> rows;
  for (const Row& row : measures.rows) rows.emplace_back(std::to_string(row.repetition), row);
  rows.insert(rows.end(), {{"mean", measures.mean}, {"sd", measures.spread}});
  WriteRows<Row>(path, of, Row::Fields(), rows, of_plane);
}

// By column: mean, its standard deviation, that over the rows, and their coefficient of variation.
template <typename Row>
Json MeasuresJson(const Measures<Row>& measures, motion::LengthUnit of_plane) {
  Json json = Json::object();
  for (const Field<Row>& field : Row::Fields()) {
    const Measured& of = measures.mean.*field.value;
    if (!std::isfinite(of.value)) continue;
    const double over_rows = (measures.spread.*field.value).value;
    json[field.Column(of_plane)] = {{"mean", of.value},
                                    {"mean_sd", NumberOrNull(of.sd)},
                                    {"sd", NumberOrNull(over_rows)},
                                    {"variation_percent", NumberOrNull(100 * over_rows / of.value)}};
  }
  return json;
}

// The means at the terminal.
template <typename Row>
std::string MeasuresText(const Measures<Row>& measures, motion::LengthUnit of_plane) {
  if (measures.rows.empty()) return "";
  std::string text = measures.rows.size() > 1 ? "means ± standard deviation of the mean:\n" : "± standard deviation:\n";
  for (const Field<Row>& field : Row::Fields())
    if (const Measured& of = measures.mean.*field.value; std::isfinite(of.value))
      text += field.Column(of_plane) + "  " + PlusMinusText(of.value, of.sd, field.digits) + "\n";
  return text;
}

}  // namespace lake::gait
