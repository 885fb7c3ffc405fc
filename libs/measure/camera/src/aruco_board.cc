#include "aruco_board.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "lake/camera/aruco_dictionary.h"
#include "lake/camera/aruco_opencv.h"

namespace lake::camera {
namespace {

cv::aruco::Dictionary DictionaryOf(const Board& board) {
  return PredefinedArucoDictionary(FindArucoDictionary(board.dictionary)->id);
}

// Their top left corners, row by row from the top left, as their codes are; mm in the board frame.
std::vector<Eigen::Vector2d> MarkerPlaces(const Board& board) {
  const double rim = (board.square_mm - board.marker_mm) / 2;
  std::vector<Eigen::Vector2d> places;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if (!board.IsBlack(row, column))
        places.emplace_back((column - 1) * board.square_mm + rim, (board.rows - 1 - row) * board.square_mm - rim);
  return places;
}

// The corners of a board that OpenCV finds near the markers that are seen, numbered from the top. OpenCV 4.6 knows the
// layout with a black top left square only, so one with a white square there is such a board without its first row,
// whose codes no marker has.
struct CharucoCorners {
  std::vector<int> corner;
  std::vector<cv::Point2f> pixel;
  int rows_above = 0;  // rows of corners that are not the board's
};

CharucoCorners CornersNear(const ArucoMarkers& markers, const cv::Mat& grey, const Board& board) {
  CharucoCorners found;
  found.rows_above = board.IsBlack(0, 0) ? 0 : 1;
  const int codes_above = found.rows_above * (board.columns / 2), rows = board.rows + found.rows_above;
  const auto square = static_cast<float>(board.square_mm), marker = static_cast<float>(board.marker_mm);
#if LAKE_ARUCO_IN_OBJDETECT
  // Codes that the dictionary does not have stand for the row that is not there.
  std::vector<int> ids(static_cast<std::size_t>(board.columns * rows / 2));
  for (std::size_t i = 0; i < ids.size(); ++i)
    ids[i] = static_cast<int>(i) < codes_above ? DictionarySize(board) + static_cast<int>(i)
                                               : static_cast<int>(i) - codes_above;
  const cv::aruco::CharucoBoard model({board.columns, rows}, square, marker, DictionaryOf(board), ids);
  std::vector<std::vector<cv::Point2f>> corners = markers.corners;
  std::vector<int> seen = markers.ids;
  cv::aruco::CharucoDetector(model).detectBoard(grey, found.pixel, found.corner, corners, seen);
#else
  const auto model = cv::aruco::CharucoBoard::create(board.columns, rows, square, marker,
                                                     cv::makePtr<cv::aruco::Dictionary>(DictionaryOf(board)));
  for (int& id : model->ids) id = std::max(id - codes_above, -1);
  cv::aruco::interpolateCornersCharuco(markers.corners, markers.ids, grey, model, found.pixel, found.corner);
#endif
  return found;
}

struct SeenMarker {
  int id = 0;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d px_from_mm = Eigen::Matrix2d::Identity();  // near it: x right, y up on the sheet
};

// OpenCV's corners of a marker go clockwise from its top left.
SeenMarker SeenOf(int id, const std::vector<cv::Point2f>& corners, double marker_mm) {
  const auto at = [&](std::size_t i) { return Eigen::Vector2d(corners[i].x, corners[i].y); };
  SeenMarker seen{id, (at(0) + at(1) + at(2) + at(3)) / 4, {}};
  seen.px_from_mm.col(0) = (at(1) - at(0) + at(2) - at(3)) / (2 * marker_mm);
  seen.px_from_mm.col(1) = (at(0) - at(3) + at(1) - at(2)) / (2 * marker_mm);
  return seen;
}

// Of the pairs of markers that touch at a corner of their squares, how many lie to each other as they should; only
// neighbours are compared, between which no lens and no perspective moves anything by half a square.
struct Agreement {
  int pairs = 0, agreeing = 0;
};

Agreement AgreementOf(const Board& board, const std::vector<SeenMarker>& markers) {
  constexpr double kNeighbours = 1.5, kMostOff = 0.5;  // squares
  const std::vector<Eigen::Vector2d> places = MarkerPlaces(board);
  Agreement agreement;
  for (const SeenMarker& a : markers)
    for (const SeenMarker& b : markers) {
      const auto count = static_cast<int>(places.size());
      if (a.id == b.id || a.id >= count || b.id >= count) continue;
      const Eigen::Vector2d on_board = places[static_cast<std::size_t>(b.id)] - places[static_cast<std::size_t>(a.id)];
      if (on_board.norm() > kNeighbours * board.square_mm || !(std::abs(a.px_from_mm.determinant()) > 0)) continue;
      const Eigen::Vector2d seen = a.px_from_mm.inverse() * (b.centre_px - a.centre_px);
      ++agreement.pairs;
      agreement.agreeing += (seen - on_board).norm() < kMostOff * board.square_mm ? 1 : 0;
    }
  return agreement;
}

// nullopt where most pairs disagree in both layouts, or none is seen.
std::optional<Board> LayoutSeen(const Board& board, const std::vector<SeenMarker>& markers) {
  std::optional<Board> best;
  int most = 0;
  for (const bool is_white : {false, true}) {
    Board tried = board;
    tried.white_top_left = is_white;
    const Agreement agreement = AgreementOf(tried, markers);
    if (agreement.agreeing <= most || 2 * agreement.agreeing <= agreement.pairs) continue;
    most = agreement.agreeing;
    best = tried;
  }
  return best;
}

}  // namespace

int DictionarySize(const Board& board) {
  return DictionaryOf(board).bytesList.rows;
}

std::vector<BoardRectangle> MarkerInk(const Board& board) {
  const cv::aruco::Dictionary dictionary = DictionaryOf(board);
  const std::vector<Eigen::Vector2d> places = MarkerPlaces(board);
  const int cells = dictionary.markerSize + 2;  // with the black border
  const double cell = board.marker_mm / cells;
  std::vector<BoardRectangle> ink;
  for (std::size_t id = 0; id < places.size(); ++id) {
    const cv::Mat picture = DrawArucoMarker(dictionary, static_cast<int>(id), cells);  // one pixel per cell
    const Eigen::Vector2d& corner = places[id];
    for (int row = 0; row < cells; ++row)
      for (int column = 0; column < cells; ++column)
        if (picture.at<uchar>(row, column) == 0)
          ink.push_back({.left = corner.x() + column * cell,
                         .bottom = corner.y() - (row + 1) * cell,
                         .width = cell,
                         .height = cell});
  }
  return ink;
}

FoundCorners FindCharuco(const cv::Mat& grey, const Board& board) {
  const ArucoMarkers markers = DetectArucoMarkers(grey, DictionaryOf(board));
  std::vector<SeenMarker> seen;
  for (std::size_t i = 0; i < markers.ids.size(); ++i)
    seen.push_back(SeenOf(markers.ids[i], markers.corners[i], board.marker_mm));
  const std::optional<Board> layout = LayoutSeen(board, seen);
  if (!layout) return {};
  const CharucoCorners near = CornersNear(markers, grey, *layout);
  const int columns = board.CornerColumns(), rows = board.CornerRows();
  std::map<int, cv::Point2f> ordered;
  for (std::size_t i = 0; i < near.corner.size(); ++i)
    if (const int from_top = near.corner[i] / columns - near.rows_above; from_top >= 0)
      ordered[(rows - 1 - from_top) * columns + near.corner[i] % columns] = near.pixel[i];
  FoundCorners found;
  for (const auto& [index, at] : ordered) {
    found.corner.push_back(index);
    found.pixel.push_back(at);
  }
  return found;
}

}  // namespace lake::camera
