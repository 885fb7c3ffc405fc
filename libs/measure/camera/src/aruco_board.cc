#include "aruco_board.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/aruco/charuco.hpp>
#include <optional>

#include "lake/camera/aruco_dictionary.h"

namespace lake::camera {
namespace {

cv::Ptr<cv::aruco::Dictionary> PredefinedDictionary(const Board& board) {
  return cv::aruco::getPredefinedDictionary(FindArucoDictionary(board.dictionary)->id);
}

// Numbered row by row from the top left, as their codes are; mm in the board frame.
struct MarkerPlace {
  Eigen::Vector2d top_left = Eigen::Vector2d::Zero();
};

std::vector<MarkerPlace> MarkerPlaces(const Board& board) {
  const double rim = (board.square_mm - board.marker_mm) / 2;
  std::vector<MarkerPlace> places;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if (!board.IsBlack(row, column))
        places.push_back({{(column - 1) * board.square_mm + rim, (board.rows - 1 - row) * board.square_mm - rim}});
  return places;
}

// OpenCV's board, whose corners are numbered from the top. OpenCV 4.6 knows the layout with a black top left square
// only; one with a white square there is such a board without its first row, whose codes no marker has.
struct CharucoModel {
  cv::Ptr<cv::aruco::CharucoBoard> board;
  int corner_rows_above = 0;  // that are not the board's
};

CharucoModel ModelOf(const Board& board) {
  const int above = board.IsBlack(0, 0) ? 0 : 1;
  CharucoModel model{
      cv::aruco::CharucoBoard::create(board.columns, board.rows + above, static_cast<float>(board.square_mm),
                                      static_cast<float>(board.marker_mm), PredefinedDictionary(board)),
      above};
  const int codes_above = above * (board.columns / 2);
  for (int& id : model.board->ids) id = std::max(id - codes_above, -1);
  return model;
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
  const std::vector<MarkerPlace> places = MarkerPlaces(board);
  Agreement agreement;
  for (const SeenMarker& a : markers)
    for (const SeenMarker& b : markers) {
      const auto count = static_cast<int>(places.size());
      if (a.id == b.id || a.id >= count || b.id >= count) continue;
      const Eigen::Vector2d on_board =
          places[static_cast<std::size_t>(b.id)].top_left - places[static_cast<std::size_t>(a.id)].top_left;
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
  return PredefinedDictionary(board)->bytesList.rows;
}

std::vector<BoardRectangle> MarkerInk(const Board& board) {
  const cv::Ptr<cv::aruco::Dictionary> dictionary = PredefinedDictionary(board);
  const std::vector<MarkerPlace> places = MarkerPlaces(board);
  const int cells = dictionary->markerSize + 2;  // with the black border
  const double cell = board.marker_mm / cells;
  std::vector<BoardRectangle> ink;
  for (std::size_t id = 0; id < places.size(); ++id) {
    cv::Mat picture;  // one pixel per cell
    dictionary->drawMarker(static_cast<int>(id), cells, picture, 1);
    const Eigen::Vector2d& corner = places[id].top_left;
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
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids;
  cv::aruco::detectMarkers(grey, PredefinedDictionary(board), markers, ids);
  std::vector<SeenMarker> seen;
  for (std::size_t i = 0; i < ids.size(); ++i) seen.push_back(SeenOf(ids[i], markers[i], board.marker_mm));
  const std::optional<Board> layout = LayoutSeen(board, seen);
  if (!layout) return {};
  const CharucoModel model = ModelOf(*layout);
  std::vector<int> corner;
  std::vector<cv::Point2f> pixel;
  cv::aruco::interpolateCornersCharuco(markers, ids, grey, model.board, pixel, corner);
  const int columns = board.CornerColumns(), rows = board.CornerRows();
  std::map<int, cv::Point2f> ordered;
  for (std::size_t i = 0; i < corner.size(); ++i)
    if (const int from_top = corner[i] / columns - model.corner_rows_above; from_top >= 0)
      ordered[(rows - 1 - from_top) * columns + corner[i] % columns] = pixel[i];
  FoundCorners found;
  for (const auto& [index, at] : ordered) {
    found.corner.push_back(index);
    found.pixel.push_back(at);
  }
  return found;
}

}  // namespace lake::camera
