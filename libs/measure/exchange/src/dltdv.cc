// DLTdv (Hedrick 2008, doi 10.1088/1748-3182/3/3/034001): its tables of digitized points, *xypts.csv with a row per
// frame, and *xypts.tsv with a row "frame, column, value" per value. Both count px from 1 at the top-left pixel, as
// DLTdv 8 has them (older versions count y from below: a warning says so), and have no times.
#include <algorithm>
#include <map>
#include <set>

#include "frame_points.h"
#include "lake/core/error.h"
#include "lake/exchange/formats.h"
#include "left_out.h"
#include "point_table.h"

namespace lake::exchange {
namespace {

constexpr double kFirstPixel = 1;
constexpr std::size_t kMostSparseColumns = 20'000;

struct DltdvPoint {
  std::string point, camera;  // pt1, cam1
  std::size_t x = 0;          // column; y is the next one
};

// pt1_cam1_X, pt1_cam1_Y, pt1_cam2_X, …
std::vector<DltdvPoint> FindPoints(const std::vector<std::string>& header, const std::string& where) {
  std::vector<DltdvPoint> points;
  for (std::size_t i = 0; i + 1 < header.size(); i += 2) {
    const std::string x = Lower(header[i]), y = Lower(header[i + 1]);
    const std::size_t middle = x.find("_cam");
    if (!x.starts_with("pt") || middle == std::string::npos || !x.ends_with("_x") ||
        y != x.substr(0, x.size() - 1) + "y")
      throw Fail("{}: columns '{}', '{}' are not ptN_camM_X, ptN_camM_Y", where, header[i], header[i + 1]);
    points.push_back({x.substr(0, middle), x.substr(middle + 1, x.size() - middle - 3), i});
  }
  if (points.empty()) throw Fail("{}: no pairs of columns ptN_camM_X, ptN_camM_Y", where);
  return points;
}

// Those of the camera that is wanted, or of all, whose points have its name behind theirs where there are several.
std::vector<DltdvPoint> OfView(std::vector<DltdvPoint> points, const std::string& view,
                               const std::filesystem::path& path, std::vector<std::string>& warnings) {
  std::set<std::string> cameras;
  for (const DltdvPoint& point : points) cameras.insert(point.camera);
  const std::string names = fmt::format("{}", fmt::join(cameras, ", "));
  if (!view.empty() && !cameras.contains(Lower(view)))
    throw UsageError("--view {}: {} has the cameras {}", view, path.string(), names);
  if (view.empty() && cameras.size() > 1)
    warnings.push_back(fmt::format("{}: holds the pictures of {} cameras ({}); --view takes those of one",
                                   path.string(), cameras.size(), names));
  if (!view.empty()) std::erase_if(points, [&](const DltdvPoint& point) { return point.camera != Lower(view); });
  if (view.empty() && cameras.size() > 1)
    for (DltdvPoint& point : points) point.point += "_" + point.camera;
  return points;
}

void WarnOfOrigin(const std::filesystem::path& path, PointRecording& recording) {
  recording.warnings.push_back(fmt::format(
      "{}: y is taken to run down from the picture's top, as DLTdv 8 has it; older versions count from below",
      path.string()));
}

}  // namespace

PointRecording ReadDltdv(const std::filesystem::path& path, const ReadOptions& options) {
  const TextLines lines(path);
  std::vector<std::string> warnings;
  const char separator = SeparatorOf(lines[0]);
  PointTable table{.space = PointSpace::kImage,
                   .separator = separator,
                   .rate_hz = options.rate_hz,
                   .first_pixel = kFirstPixel,
                   .names_all = options.view.empty()};
  for (const DltdvPoint& point :
       OfView(FindPoints(SplitCells(lines[0], separator), lines.Where(0)), options.view, path, warnings))
    table.points.push_back({point.point, {point.x, point.x + 1}});
  PointRecording recording = ReadPointTable(lines, table, path);
  recording.warnings.insert(recording.warnings.begin(), warnings.begin(), warnings.end());
  WarnOfOrigin(path, recording);
  return recording;
}

// Its columns are taken in pairs. A value of 0 is a missing one.
PointRecording ReadDltdvSparse(const std::filesystem::path& path, const ReadOptions& options) {
  const TextLines lines(path);
  if (lines.Count() == 0) throw Fail("{}: empty", path.string());
  std::map<std::size_t, std::map<std::int64_t, double>> columns;  // column from 0, frame from 0, value
  LeftOut left_out;
  for (std::size_t line = 1; line < lines.Count(); ++line) {
    const std::vector<std::string> cells = SplitCells(lines[line], '\t');
    bool is_unreadable = cells.size() != 3;
    const std::size_t frame = is_unreadable ? 0 : CountIn(cells[0]).value_or(0),
                      column = is_unreadable ? 0 : CountIn(cells[1], kMostSparseColumns).value_or(0);
    const double value = is_unreadable ? 0 : NumberIn(cells[2], is_unreadable).value_or(0);
    if (frame > 0 && column > 0 && !is_unreadable) {
      if (value != 0) columns[column - 1][static_cast<std::int64_t>(frame) - 1] = value;
    } else if (!lines[line].empty()) {
      left_out.Add("a row that is not 'frame, column, value'", lines.Where(line));
    }
  }
  std::vector<FramePoints> found;
  for (std::size_t c = 0; !columns.empty() && c <= columns.rbegin()->first; c += 2) {
    FramePoints& track = found.emplace_back(FramePoints{fmt::format("pt{}", c / 2 + 1), {}});
    for (const auto& [frame, x] : columns[c])
      if (const auto y = columns[c + 1].find(frame); y != columns[c + 1].end())
        track.positions[frame] = {x - kFirstPixel, y->second - kFirstPixel, 0};
  }
  PointRecording recording = PointsByFrame(found, std::filesystem::file_size(path), path, options.rate_hz);
  recording.warnings.push_back(fmt::format(
      "{}: its columns have no names: each two are a point, pt1, pt2, …; of several cameras they take turns",
      path.string()));
  left_out.AppendTo(recording.warnings);
  WarnOfOrigin(path, recording);
  return recording;
}

}  // namespace lake::exchange
