#include "lake/exchange/dltdv.h"

#include <set>

#include "lake/core/error.h"
#include "text_lines.h"

namespace lake::exchange {
namespace {

constexpr const char* kFirstColumn = "pt1_cam1_x";
constexpr double kFirstPixel = 1;

struct DltdvPoint {
  std::string point, camera;  // pt1, cam1
  std::size_t x = 0;          // column; y is the next one
};

// pt1_cam1_X, pt1_cam1_Y, pt1_cam2_X, …
std::vector<DltdvPoint> FindPoints(const std::vector<std::string>& header, const std::string& where) {
  constexpr std::size_t kMostColumns = 20'000;
  if (header.size() % 2 != 0 || header.size() > kMostColumns)
    throw Fail("{}: {} columns, not pairs of X and Y up to {}", where, header.size(), kMostColumns);
  std::vector<DltdvPoint> points;
  for (std::size_t i = 0; i < header.size(); i += 2) {
    const std::string x = Lower(header[i]), y = Lower(header[i + 1]);
    const std::size_t middle = x.find("_cam");
    if (!x.starts_with("pt") || middle == std::string::npos || !x.ends_with("_x") ||
        y != x.substr(0, x.size() - 1) + "y")
      throw Fail("{}: columns '{}', '{}' are not ptN_camM_X, ptN_camM_Y", where, header[i], header[i + 1]);
    points.push_back({x.substr(0, middle), x.substr(middle + 1, x.size() - middle - 3), i});
  }
  return points;
}

std::vector<std::string> NamePoints(const std::vector<DltdvPoint>& points) {
  std::set<std::string> cameras;
  for (const DltdvPoint& point : points) cameras.insert(point.camera);
  std::vector<std::string> names;
  for (const DltdvPoint& point : points)
    names.push_back(cameras.size() == 1 ? point.point : point.point + "_" + point.camera);
  return names;
}

}  // namespace

bool IsDltdv(const std::filesystem::path& path) {
  const TextLines lines(path);
  return lines.Count() > 0 && Lower(lines[0]).starts_with(kFirstColumn);
}

PointRecording ReadDltdv(const std::filesystem::path& path, double rate_hz) {
  if (!(rate_hz > 0))
    throw UsageError("{}: DLTdv's tables have no times: the frame rate must be given (lake convert --rate HZ)",
                     path.string());
  const TextLines lines(path);
  if (lines.Count() == 0) throw Fail("{}: empty", path.string());
  const std::vector<std::string> header = SplitCells(lines[0], ',');
  const std::vector<DltdvPoint> points = FindPoints(header, lines.Where(0));
  PointRecording recording;
  recording.space = PointSpace::kImage;
  AddPoints(NamePoints(points), lines.Where(0), recording);
  for (std::size_t i = 1; i < lines.Count(); ++i) {
    if (lines[i].empty()) continue;
    const std::vector<std::string> cells = SplitCells(lines[i], ',');
    if (cells.size() != header.size())
      throw Fail("{}: {} cells, but the header has {}", lines.Where(i), cells.size(), header.size());
    recording.time_s.push_back(static_cast<double>(recording.frame.size()) / rate_hz);
    recording.frame.push_back(static_cast<std::int64_t>(recording.frame.size()));
    for (std::size_t p = 0; p < points.size(); ++p) {
      const auto x = NumberOrMissing(cells[points[p].x], lines.Where(i)),
                 y = NumberOrMissing(cells[points[p].x + 1], lines.Where(i));
      recording.points[p].positions.push_back(x && y ? Eigen::Vector3d(*x - kFirstPixel, *y - kFirstPixel, 0)
                                                     : PointTrack::Missing());
    }
  }
  recording.warnings.push_back(fmt::format(
      "{}: y is taken to run down from the picture's top, as DLTdv 8 has it; older versions count from below",
      path.string()));
  return recording;
}

}  // namespace lake::exchange
