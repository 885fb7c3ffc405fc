#include "lake/motion/marker_recording.h"

#include <array>

#include "lake/core/csv.h"
#include "lake/core/error.h"

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
  std::size_t x, y, sigma, status;
};

std::string XSuffix(LengthUnit unit) {
  return fmt::format("_x_{}", ToString(unit));
}

MarkerSample ReadSample(const CsvTable& table, std::size_t row, const MarkerColumns& columns) {
  MarkerSample sample;
  sample.status = ParseStatus(table, row, columns.status);
  if (!sample.IsKnown()) return sample;
  sample.position = {table.RequiredNumber(row, columns.x), table.RequiredNumber(row, columns.y)};
  sample.sigma = table.RequiredNumber(row, columns.sigma);
  if (sample.sigma < 0) throw Fail("{}: column '{}' is negative", table.Where(row), table.Header()[columns.sigma]);
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

void WriteMarkerCsv(const std::filesystem::path& path, const MarkerRecording& recording) {
  const std::string_view unit = ToString(recording.unit);
  std::vector<std::string> header = {"frame", "time_s"};
  for (const MarkerTrack& marker : recording.markers) {
    for (const char* quantity : {"x", "y", "sigma"})
      header.push_back(fmt::format("{}_{}_{}", marker.name, quantity, unit));
    header.push_back(marker.name + "_status");
  }
  CsvWriter csv(header);
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    csv.Add(recording.frame[i]).Add(recording.time_s[i]);
    for (const MarkerTrack& marker : recording.markers) {
      const MarkerSample& sample = marker.samples[i];
      if (sample.IsKnown())
        csv.Add(sample.position.x()).Add(sample.position.y()).Add(sample.sigma);
      else
        csv.AddEmpty().AddEmpty().AddEmpty();
      csv.Add(ToString(sample.status));
    }
    csv.EndRow();
  }
  csv.Write(path);
}

MarkerRecording ReadMarkerCsv(const std::filesystem::path& path) {
  const CsvTable table = CsvTable::Read(path);
  MarkerRecording recording;
  recording.unit = FindUnit(table, path);
  std::vector<MarkerColumns> columns;
  const std::string suffix = XSuffix(recording.unit);
  for (const std::string& column : table.Header()) {
    if (!column.ends_with(suffix)) continue;
    const std::string name = column.substr(0, column.size() - suffix.size());
    recording.markers.push_back({name, {}});
    const auto find = [&](const char* quantity) {
      return table.Column(fmt::format("{}_{}_{}", name, quantity, ToString(recording.unit)));
    };
    columns.push_back({find("x"), find("y"), find("sigma"), table.Column(name + "_status")});
  }
  const std::size_t frame = table.Column("frame"), time = table.Column("time_s");
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    recording.frame.push_back(static_cast<std::int64_t>(table.RequiredNumber(row, frame)));
    recording.time_s.push_back(table.RequiredNumber(row, time));
    if (row > 0 && recording.time_s[row] <= recording.time_s[row - 1])
      throw Fail("{}: time_s does not increase", table.Where(row));
    for (std::size_t m = 0; m < columns.size(); ++m)
      recording.markers[m].samples.push_back(ReadSample(table, row, columns[m]));
  }
  return recording;
}

}  // namespace lake::motion
