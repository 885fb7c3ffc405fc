// SLEAP (Pereira et al. 2022, doi 10.1038/s41592-022-01426-1): its analysis as CSV, a row per frame and animal with the
// columns track, frame_idx, instance.score and, for each node, NODE.x, NODE.y, NODE.score; px from 0 at the top-left
// pixel.
#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "frame_points.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/exchange/formats.h"
#include "left_out.h"
#include "text_lines.h"

namespace lake::exchange {
namespace {}  // namespace

PointRecording ReadSleap(const std::filesystem::path& path, const ReadOptions& options) {
  const CsvTable table = CsvTable::Read(path);
  const std::size_t track_column = table.Column("track"), frame_column = table.Column("frame_idx");
  std::set<std::string> tracks;
  for (std::size_t row = 0; row < table.Rows(); ++row) tracks.insert(table.Text(row, track_column));
  std::map<std::string, FramePoints> points;  // by track and node
  LeftOut left_out;
  for (std::size_t x = 0; x < table.Header().size(); ++x) {
    const std::string& title = table.Header()[x];
    if (!title.ends_with(".x")) continue;
    const std::string node = title.substr(0, title.size() - 2);
    const std::size_t y = table.Column(node + ".y");
    for (std::size_t row = 0; row < table.Rows(); ++row) {
      const std::string& track = table.Text(row, track_column);
      const std::string name = tracks.size() > 1 ? fmt::format("{}_{}", track, node) : node;
      bool is_unreadable = false;
      const auto frame = CountIn(table.Text(row, frame_column));
      const auto x_px = NumberIn(table.Text(row, x), is_unreadable), y_px = NumberIn(table.Text(row, y), is_unreadable);
      points[name].name = name;
      if (!frame)
        left_out.Add("a row whose frame_idx is no number", table.Where(row));
      else if (is_unreadable)
        left_out.Add("a cell that is not a finite number", table.Where(row));
      else if (x_px && y_px)
        points[name].positions[static_cast<std::int64_t>(*frame)] = {*x_px, *y_px, 0};
    }
  }
  std::vector<FramePoints> found;
  found.reserve(points.size());
  for (auto& [name, point] : points) found.push_back(std::move(point));
  PointRecording recording = PointsByFrame(found, std::filesystem::file_size(path), path, options.rate_hz);
  left_out.AppendTo(recording.warnings);
  return recording;
}

}  // namespace lake::exchange
