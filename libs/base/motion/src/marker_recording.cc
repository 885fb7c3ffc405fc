#include "lake/motion/marker_recording.h"

#include <array>
#include <optional>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"

namespace lake::motion {
namespace {

constexpr std::array kStatuses = {SampleStatus::kMissing, SampleStatus::kDetected, SampleStatus::kFilled};

SampleStatus ParseStatus(const CsvTable& table, std::size_t row, std::size_t column) {
  for (const SampleStatus status : kStatuses)
    if (table.Text(row, column) == ToString(status)) return status;
  throw Fail("{}: column '{}': '{}' is not detected, filled or missing", table.Where(row), table.Header()[column],
             table.Text(row, column));
}

// The columns of one marker.
struct MarkerColumns {
  std::size_t x, y;
  std::optional<std::size_t> sigma, status;  // without a status, an empty cell is a marker that was not seen
};

std::string XSuffix(LengthUnit unit) {
  return fmt::format("_x_{}", ToString(unit));
}

constexpr std::string_view kRaw = "_raw";

void AddHeader(const std::string& name, std::string_view unit, std::vector<std::string>& header) {
  for (const char* quantity : {"x", "y", "sigma"}) header.push_back(fmt::format("{}_{}_{}", name, quantity, unit));
}

void AddCells(const MarkerSample& sample, bool is_known, CsvWriter& csv) {
  if (is_known)
    csv.Add(sample.position.x()).Add(sample.position.y()).Add(sample.sigma);
  else
    csv.AddEmpty().AddEmpty().AddEmpty();
}

void WriteTable(const std::filesystem::path& path, const MarkerRecording& recording,
                const MarkerRecording* measurements) {
  const std::string_view unit = ToString(recording.unit);
  std::vector<std::string> header = {"frame", "time_s"};
  for (const MarkerTrack& marker : recording.markers) {
    AddHeader(marker.name, unit, header);
    header.push_back(marker.name + "_status");
    if (measurements) AddHeader(fmt::format("{}{}", marker.name, kRaw), unit, header);
  }
  if (!recording.knee_rebuilt.empty()) header.emplace_back("knee_rebuilt");
  CsvWriter csv(header);
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    csv.Add(recording.frame[i]).Add(recording.time_s[i]);
    for (std::size_t m = 0; m < recording.markers.size(); ++m) {
      const MarkerSample& sample = recording.markers[m].samples[i];
      AddCells(sample, sample.IsKnown(), csv);
      csv.Add(ToString(sample.status));
      if (!measurements) continue;
      const MarkerSample& measured = measurements->markers[m].samples[i];
      AddCells(measured, measured.status == SampleStatus::kDetected, csv);
    }
    if (!recording.knee_rebuilt.empty()) csv.Add(static_cast<int>(recording.knee_rebuilt[i]));
    csv.EndRow();
  }
  csv.Write(path);
}

std::optional<std::size_t> FindColumn(const CsvTable& table, const std::string& name) {
  return table.Has(name) ? std::optional(table.Column(name)) : std::nullopt;
}

MarkerSample ReadSample(const CsvTable& table, std::size_t row, const MarkerColumns& columns) {
  MarkerSample sample;
  if (columns.status)
    sample.status = ParseStatus(table, row, *columns.status);
  else
    sample.status = table.Number(row, columns.x) ? SampleStatus::kDetected : SampleStatus::kMissing;
  if (!sample.IsKnown()) return sample;
  sample.position = {table.RequiredNumber(row, columns.x), table.RequiredNumber(row, columns.y)};
  if (!columns.sigma) return sample;
  sample.sigma = table.RequiredNumber(row, *columns.sigma);
  if (sample.sigma < 0) throw Fail("{}: column '{}' is negative", table.Where(row), table.Header()[*columns.sigma]);
  return sample;
}

LengthUnit FindUnit(const CsvTable& table, const std::filesystem::path& path) {
  for (const std::string& name : table.Header())
    for (const LengthUnit unit : {LengthUnit::kPx, LengthUnit::kMm})
      if (name.ends_with(XSuffix(unit))) return unit;
  throw Fail("{}: no column of a marker (M_x_px or M_x_mm)", path.string());
}

}  // namespace

std::string_view ToString(SampleStatus status) {
  switch (status) {
    case SampleStatus::kMissing:
      return "missing";
    case SampleStatus::kDetected:
      return "detected";
    case SampleStatus::kFilled:
      return "filled";
  }
  return "missing";
}

std::string_view ToString(LengthUnit unit) {
  return unit == LengthUnit::kPx ? "px" : "mm";
}

const MarkerTrack* MarkerRecording::Find(std::string_view name) const {
  for (const MarkerTrack& marker : markers)
    if (marker.name == name) return &marker;
  return nullptr;
}

double MedianDistance(const MarkerRecording& recording, std::string_view marker, std::string_view other) {
  const MarkerTrack *a = recording.Find(marker), *b = recording.Find(other);
  std::vector<double> distances;
  for (std::size_t i = 0; a && b && i < recording.Frames(); ++i)
    if (a->samples[i].IsKnown() && b->samples[i].IsKnown())
      distances.push_back((b->samples[i].position - a->samples[i].position).norm());
  return distances.empty() ? kNaN : Median(std::move(distances));
}

MarkerRecording Measurements(MarkerRecording recording) {
  for (MarkerTrack& marker : recording.markers)
    for (MarkerSample& sample : marker.samples)
      if (sample.status != SampleStatus::kDetected) sample = MarkerSample();
  return recording;
}

void WriteMarkerCsv(const std::filesystem::path& path, const MarkerRecording& recording) {
  WriteTable(path, recording, nullptr);
}

void WriteTrajectoryCsv(const std::filesystem::path& path, const MarkerRecording& estimates,
                        const MarkerRecording& measurements) {
  WriteTable(path, estimates, &measurements);
}

MarkerRecording ReadMarkerCsv(const std::filesystem::path& path, MarkerValues values) {
  const CsvTable table = CsvTable::Read(path);
  MarkerRecording recording;
  recording.unit = FindUnit(table, path);
  std::vector<MarkerColumns> columns;
  const std::string_view unit = ToString(recording.unit);
  const std::string suffix = XSuffix(recording.unit);
  for (const std::string& column : table.Header()) {
    if (!column.ends_with(suffix)) continue;
    const std::string name = column.substr(0, column.size() - suffix.size());
    if (name.ends_with(kRaw) && !table.Has(name + "_status")) continue;
    recording.markers.push_back({name, {}});
    const bool raw = values == MarkerValues::kMeasured && table.Has(fmt::format("{}{}{}", name, kRaw, suffix));
    const auto name_of = [&](const char* quantity) {
      return fmt::format("{}{}_{}_{}", name, raw ? kRaw : "", quantity, unit);
    };
    const auto column_of = [&](const char* quantity) { return table.Column(name_of(quantity)); };
    columns.push_back({column_of("x"), column_of("y"), FindColumn(table, name_of("sigma")),
                       raw ? std::nullopt : FindColumn(table, name + "_status")});
  }
  const std::optional<std::size_t> frame = FindColumn(table, "frame");
  const std::size_t time = table.Column("time_s");
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    recording.frame.push_back(static_cast<std::int64_t>(frame ? table.RequiredNumber(row, *frame) : row));
    recording.time_s.push_back(table.RequiredNumber(row, time));
    if (row > 0 && recording.time_s[row] <= recording.time_s[row - 1])
      throw Fail("{}: time_s does not increase", table.Where(row));
    for (std::size_t m = 0; m < columns.size(); ++m)
      recording.markers[m].samples.push_back(ReadSample(table, row, columns[m]));
  }
  return recording;
}

}  // namespace lake::motion
