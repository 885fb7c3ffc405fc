#include "corrections.h"

#include <algorithm>

#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake {

int ApplyCorrections(const std::filesystem::path& path, int width, int height, MarkerRecording& recording) {
  constexpr double kClickSigmaPx = 0.5;
  const CsvTable table = CsvTable::Read(path);
  const std::size_t frame = table.Column("frame"), name = table.Column("marker"), x = table.Column("x_px"),
                    y = table.Column("y_px");
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const auto marker = std::find_if(recording.markers.begin(), recording.markers.end(),
                                     [&](const MarkerTrack& m) { return m.name == table.Text(row, name); });
    if (marker == recording.markers.end()) throw Fail("{}: no marker '{}'", table.Where(row), table.Text(row, name));
    const double number = table.RequiredNumber(row, frame);
    const auto found = std::find(recording.frame.begin(), recording.frame.end(), static_cast<std::int64_t>(number));
    if (found == recording.frame.end()) throw Fail("{}: frame {} is not in the recording", table.Where(row), number);
    MarkerSample& sample = marker->samples[static_cast<std::size_t>(found - recording.frame.begin())];
    const auto px = table.Number(row, x), py = table.Number(row, y);
    if (px.has_value() != py.has_value())
      throw Fail("{}: x_px and y_px must both be given, or both be empty", table.Where(row));
    if (px && !(*px >= 0 && *py >= 0 && *px <= width - 1 && *py <= height - 1))
      throw Fail("{}: ({}, {}) is outside the picture of {}x{} px", table.Where(row), *px, *py, width, height);
    sample = px ? MarkerSample{{*px, *py}, kClickSigmaPx, SampleStatus::kDetected} : MarkerSample{};
  }
  return static_cast<int>(table.Rows());
}

}  // namespace lake
