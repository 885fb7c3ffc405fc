#include "lake/motion/corrections.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/nearest_name.h"

namespace lake::motion {

std::vector<Correction> ReadCorrections(const std::filesystem::path& path, const std::vector<std::string>& names,
                                        int width, int height) {
  constexpr double kMostFrames = 1e12;
  const CsvTable table = CsvTable::Read(path);
  const std::size_t frame = table.Column("frame"), marker = table.Column("marker"), x = table.Column("x_px"),
                    y = table.Column("y_px");
  const bool has_sigma = table.Has("sigma_px");
  std::vector<Correction> corrections;
  std::map<std::pair<std::int64_t, std::string>, std::string> seen;  // where
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const std::string& name = table.Text(row, marker);
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw Fail("{}: no marker '{}'{}; there are {}", table.Where(row), name, DidYouMean(name, names),
                 fmt::join(names, ", "));
    const double number = table.RequiredNumber(row, frame);
    if (!(number >= 0 && number <= kMostFrames && number == std::floor(number)))
      throw Fail("{}: frame {} is not a whole number from 0", table.Where(row), number);
    const auto px = table.Number(row, x), py = table.Number(row, y);
    if (px.has_value() != py.has_value())
      throw Fail("{}: x_px and y_px must both be given, or both be empty", table.Where(row));
    if (px && !(*px >= 0 && *py >= 0 && *px <= width - 1 && *py <= height - 1))
      throw Fail("{}: ({}, {}) is outside the picture of {}x{} px", table.Where(row), *px, *py, width, height);
    const double sigma =
        (has_sigma ? table.Number(row, table.Column("sigma_px")) : std::nullopt).value_or(kClickSigmaPx);
    if (!(sigma > 0)) throw Fail("{}: a sigma_px of {} is not positive", table.Where(row), sigma);
    const MarkerSample sample = px ? MarkerSample{{*px, *py}, sigma, SampleStatus::kDetected} : MarkerSample{};
    corrections.push_back(
        {.frame = static_cast<std::int64_t>(number), .marker = name, .sample = sample, .where = table.Where(row)});
    const auto [first, is_new] = seen.try_emplace({corrections.back().frame, name}, table.Where(row));
    if (!is_new)
      throw Fail("{}: '{}' in frame {} is corrected twice, first in {}; keep one", table.Where(row), name, number,
                 first->second);
  }
  return corrections;
}

void WriteCorrections(const std::filesystem::path& path, const std::vector<Correction>& corrections) {
  CsvWriter csv({"frame", "marker", "x_px", "y_px", "sigma_px"});
  for (const Correction& correction : corrections) {
    csv.Add(correction.frame).Add(correction.marker);
    if (correction.sample.IsKnown())
      csv.Add(correction.sample.position.x()).Add(correction.sample.position.y()).Add(correction.sample.sigma);
    else
      csv.AddEmpty().AddEmpty().AddEmpty();
    csv.EndRow();
  }
  csv.Write(path);
}

void ApplyCorrections(const std::vector<Correction>& corrections, MarkerRecording& recording) {
  for (const Correction& correction : corrections) {
    const auto found = std::find(recording.frame.begin(), recording.frame.end(), correction.frame);
    if (found == recording.frame.end())
      throw Fail("{}: frame {} is not in the recording", correction.where, correction.frame);
    const auto row = static_cast<std::size_t>(found - recording.frame.begin());
    for (MarkerTrack& marker : recording.markers)
      if (marker.name == correction.marker) marker.samples[row] = correction.sample;
  }
}

}  // namespace lake::motion
