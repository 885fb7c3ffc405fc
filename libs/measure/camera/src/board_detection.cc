#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "aruco_board.h"
#include "lake/camera/board.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"

namespace lake::camera {
namespace {

// OpenCV's rows may run downwards; the board's own run upwards, seen from the front.
void OrderRowsUpwards(const Board& board, std::vector<cv::Point2f>& grid) {
  const int columns = board.CornerColumns(), rows = board.CornerRows();
  const cv::Point2f origin = grid.front(), along = grid[static_cast<std::size_t>(columns - 1)] - origin;
  const cv::Point2f up = grid[static_cast<std::size_t>(columns * (rows - 1))] - origin;
  if (along.cross(up) < 0) return;  // image y is down
  for (int low = 0, high = rows - 1; low < high; ++low, --high)
    std::swap_ranges(grid.begin() + low * columns, grid.begin() + (low + 1) * columns, grid.begin() + high * columns);
}

// A chessboard is looked for by the sectors round each corner (A. Duda & U. Frese, Accurate detection and localization
// of checkerboard corners, 2018), in a second at most and already to a fraction of a pixel; where that fails by the
// quadrangles of the squares, which takes many seconds where there is none, but milliseconds if only likely ones count.
enum class Search { kSectors, kQuadrangles, kLikelyQuadrangles };

FoundCorners FindChessboard(const cv::Mat& grey, const Board& board, Search search) {
  const cv::Size size(board.CornerColumns(), board.CornerRows());
  const int flags = cv::CALIB_CB_NORMALIZE_IMAGE,
            likely = search == Search::kLikelyQuadrangles ? cv::CALIB_CB_FAST_CHECK : 0;
  FoundCorners found;
  const bool is_seen =
      search == Search::kSectors
          ? cv::findChessboardCornersSB(grey, size, found.pixel, flags | cv::CALIB_CB_ACCURACY)
          : cv::findChessboardCorners(grey, size, found.pixel, flags | cv::CALIB_CB_ADAPTIVE_THRESH | likely);
  if (!is_seen) return {};
  OrderRowsUpwards(board, found.pixel);
  for (std::size_t i = 0; i < found.pixel.size(); ++i) found.corner.push_back(static_cast<int>(i));
  return found;
}

// How far corners lie off smooth lines: the root mean square of their third differences along rows and columns, which a
// lens's picture of a straight line hardly has and an error of position has (1, 3, 3, 1) times.
double Roughness(const Board& board, const std::vector<cv::Point2f>& grid) {
  const int columns = board.CornerColumns(), rows = board.CornerRows();
  double sum = 0;
  int count = 0;
  const auto add = [&](int start, int step) {
    const auto at = [&](int k) { return grid[static_cast<std::size_t>(start + k * step)]; };
    const cv::Point2f third = at(3) - at(0) + 3 * (at(1) - at(2));
    sum += third.dot(third);
    ++count;
  };
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      if (c + 3 < columns) add(r * columns + c, 1);
      if (r + 3 < rows) add(r * columns + c, columns);
    }
  return count > 0 ? std::sqrt(sum / count) : std::numeric_limits<double>::infinity();
}

bool SpanThePlane(const Board& board, const std::vector<int>& corners) {
  const auto differ = [&](auto line) {
    return std::any_of(corners.begin(), corners.end(), [&](int c) { return line(c) != line(corners.front()); });
  };
  const int columns = board.CornerColumns();
  return differ([&](int c) { return c % columns; }) && differ([&](int c) { return c / columns; }) &&
         differ([&](int c) { return c % columns - c / columns; }) &&
         differ([&](int c) { return c % columns + c / columns; });
}

// How far the nearest other line of the grid runs past each corner: of a strongly tilted board that is less than the
// distance to the next corner.
std::vector<double> LineDistances(const Board& board, const FoundCorners& found) {
  std::map<int, cv::Point2f> at;
  for (std::size_t i = 0; i < found.corner.size(); ++i) at[found.corner[i]] = found.pixel[i];
  const int columns = board.CornerColumns();
  std::vector<double> distances;
  for (const int c : found.corner) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const int along : {-1, 1}) {
      for (const int across : {-columns, columns}) {
        const bool same_row = (c + along >= 0) && (c + along) / columns == c / columns;
        if (!same_row || !at.count(c + along) || !at.count(c + across)) continue;
        const cv::Point2f a = at[c + along] - at[c], b = at[c + across] - at[c];
        nearest = std::min(nearest, std::abs(a.cross(b)) / std::max(cv::norm(a), cv::norm(b)));
      }
    }
    distances.push_back(nearest);
  }
  // A ChArUco corner without neighbours takes the least of the others.
  const double least = *std::min_element(distances.begin(), distances.end());
  for (double& d : distances) d = std::isfinite(d) ? d : least;
  return distances;
}

// A window for each corner by its own distance to its neighbours, as perspective makes them differ. In a ChArUco board
// the markers are nearer than the corners.
int HalfWindow(const Board& board, double line_distance_px, int fixed_px) {
  if (fixed_px > 0) return fixed_px;
  constexpr double kOfDistance = 0.35, kOfGap = 0.8;
  constexpr int kLeast = 2, kMost = 15;
  double reach = kOfDistance * line_distance_px;
  if (board.kind == BoardKind::kCharuco)
    reach = std::min(reach, kOfGap * line_distance_px * (1 - board.marker_mm / board.square_mm) / 2);
  return std::clamp(static_cast<int>(reach), kLeast, kMost);
}

cv::Point2f RefineCorner(const cv::Mat& grey, const cv::Point2f& start, int half) {
  const cv::TermCriteria criteria(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 50, 1e-3);
  std::vector<cv::Point2f> corner = {start};
  const auto search = [&](int half_window) {
    cv::cornerSubPix(grey, corner, {half_window, half_window}, {-1, -1}, criteria);
  };
  search(half);
  if (corner.front() != start) return corner.front();
  // OpenCV gives a corner that left its window back unmoved: come nearer with a wider one first.
  search(2 * half);
  search(half);
  return corner.front();
}

// Contrast over steepest slope around a corner.
double EdgeWidth(const cv::Mat& grey, const cv::Point2f& pixel, int half) {
  const cv::Rect all(0, 0, grey.cols, grey.rows);
  const cv::Rect window =
      cv::Rect(cvRound(pixel.x) - half - 1, cvRound(pixel.y) - half - 1, 2 * half + 3, 2 * half + 3) & all;
  if (window.width < 5 || window.height < 5) return std::numeric_limits<double>::quiet_NaN();
  cv::Mat dx, dy, slope;
  cv::Sobel(grey(window), dx, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(grey(window), dy, CV_32F, 0, 1, 3, 1.0 / 8);
  cv::magnitude(dx, dy, slope);
  double darkest = 0, lightest = 0, steepest = 0;
  cv::minMaxLoc(grey(window), &darkest, &lightest);
  cv::minMaxLoc(slope, nullptr, &steepest);
  return steepest > 0 ? (lightest - darkest) / steepest : std::numeric_limits<double>::quiet_NaN();
}

double MedianEdgeWidth(const cv::Mat& grey, const std::vector<cv::Point2f>& pixels,
                       const std::vector<int>& half_windows) {
  std::vector<double> widths;
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (const double width = EdgeWidth(grey, pixels[i], half_windows[i]); std::isfinite(width)) widths.push_back(width);
  return widths.empty() ? std::numeric_limits<double>::infinity() : Median(widths);
}

FoundCorners Find(const cv::Mat& grey, const Board& board, Search search) {
  try {
    return board.kind == BoardKind::kCharuco ? FindCharuco(grey, board) : FindChessboard(grey, board, search);
  } catch (const cv::Exception&) {
    return {};  // OpenCV's searches assert on some pictures without a board, e.g. noise
  }
}

// A board printed dark on light, as the searches expect it.
std::optional<BoardView> DetectDarkOnLight(const cv::Mat& grey, const Board& board,
                                           const BoardDetectionOptions& options, Search search) {
  constexpr std::size_t kLeastCorners = 8;  // of a ChArUco board
  FoundCorners found = Find(grey, board, search);
  if (found.corner.size() < kLeastCorners || !SpanThePlane(board, found.corner)) return std::nullopt;
  std::vector<int> half_windows;
  for (const double distance : LineDistances(board, found))
    half_windows.push_back(HalfWindow(board, distance, options.half_window_px));
  const std::vector<cv::Point2f> as_found = found.pixel;
  for (std::size_t i = 0; i < found.pixel.size(); ++i)
    found.pixel[i] = RefineCorner(grey, found.pixel[i], half_windows[i]);
  // Sectors give fractions of a pixel, too: the corners that lie on smoother lines are taken.
  if (board.kind == BoardKind::kChessboard && options.thorough && options.half_window_px == 0 &&
      Roughness(board, as_found) < Roughness(board, found.pixel))
    found.pixel = as_found;
  BoardView view;
  view.corner = found.corner;
  for (const cv::Point2f& p : found.pixel) view.pixel.emplace_back(p.x, p.y);
  view.edge_width_px = MedianEdgeWidth(grey, found.pixel, half_windows);
  return view;
}

}  // namespace

std::optional<BoardView> DetectBoard(const cv::Mat& grey, const Board& board, const BoardDetectionOptions& options) {
  if (grey.type() != CV_8UC1 || grey.empty()) throw Fail("a board is looked for in a grey picture of 8 bits");
  const cv::Mat negative = 255 - grey;
  std::vector<Search> searches = {Search::kLikelyQuadrangles};
  if (options.thorough && board.kind == BoardKind::kChessboard) searches = {Search::kSectors, Search::kQuadrangles};
  for (const Search search : searches)
    for (const cv::Mat& picture : {grey, negative})
      if (auto view = DetectDarkOnLight(picture, board, options, search)) return view;
  return std::nullopt;
}

}  // namespace lake::camera
