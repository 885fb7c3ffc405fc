#include "lake/camera/board.h"

#include <algorithm>

#include "aruco_board.h"
#include "lake/camera/aruco_dictionary.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::camera {
namespace {

constexpr int kMaxCount = 100;        // rows or columns
constexpr double kMaxSquareMm = 5e3;  // beyond any sheet
constexpr double kMinSquareMm = 1;    // below any that a camera of people sees

UsageError Wrong(std::string_view text, const std::string& why) {
  return UsageError(
      "board '{}': {}; write chessboard:COLSxROWS:SQUARE_MM or charuco:COLSxROWS:SQUARE_MM:MARKER_MM:DICT, e.g. "
      "chessboard:9x6:25",
      text, why);
}

int ParseCount(std::string_view text, std::string_view whole, const char* what) {
  const auto value = ParseNumber(text);
  if (!value || *value != static_cast<int>(std::clamp(*value, -1e6, 1e6)))
    throw Wrong(whole, fmt::format("'{}' is no number of {}", text, what));
  if (*value < 3 || *value > kMaxCount) throw Wrong(whole, fmt::format("3 to {} {} are possible", kMaxCount, what));
  return static_cast<int>(*value);
}

double ParseLength(std::string_view text, std::string_view whole, const char* what) {
  const auto value = ParseNumber(text);
  if (!value || !(*value > 0) || *value > kMaxSquareMm)
    throw Wrong(whole, fmt::format("'{}' is no size of a {} in mm", text, what));
  if (*value < kMinSquareMm)
    throw Wrong(whole, fmt::format("a {} of {} mm is smaller than any (is it in m?)", what, *value));
  return *value;
}

void ParseCharuco(const std::vector<std::string>& parts, std::string_view text, Board& board) {
  board.marker_mm = ParseLength(parts[3], text, "marker");
  if (board.marker_mm >= board.square_mm)
    throw Wrong(text,
                fmt::format("a marker of {} mm does not fit into a square of {} mm", board.marker_mm, board.square_mm));
  const std::optional<ArucoDictionary> dictionary = FindArucoDictionary(parts[4]);
  if (!dictionary) throw Wrong(text, fmt::format("no dictionary '{}'; known: {}", parts[4], ArucoDictionaryNames()));
  board.dictionary = dictionary->name;
  const int needed = board.columns * board.rows / 2, held = DictionarySize(board);
  if (needed > held) throw Wrong(text, fmt::format("it needs {} markers, {} has {}", needed, board.dictionary, held));
}

}  // namespace

Board ParseBoard(std::string_view text) {
  const std::vector<std::string> parts = SplitText(text, ':');
  Board board;
  if (!parts.empty() && parts[0] == "charuco")
    board.kind = BoardKind::kCharuco;
  else if (parts.empty() || parts[0] != "chessboard")
    throw Wrong(text, "it must begin with 'chessboard:' or 'charuco:'");
  const std::size_t wanted = board.kind == BoardKind::kChessboard ? 3 : 5;
  if (parts.size() != wanted) throw Wrong(text, fmt::format("it has {} parts, not {}", parts.size(), wanted));
  const std::vector<std::string> size = SplitText(parts[1], 'x');
  if (size.size() != 2) throw Wrong(text, fmt::format("'{}' is not COLSxROWS", parts[1]));
  board.columns = ParseCount(size[0], text, "columns");
  board.rows = ParseCount(size[1], text, "rows");
  board.square_mm = ParseLength(parts[2], text, "square");
  if (board.kind == BoardKind::kCharuco) ParseCharuco(parts, text, board);
  return board;
}

std::string ToString(const Board& board) {
  if (board.kind == BoardKind::kChessboard)
    return fmt::format("chessboard:{}x{}:{}", board.columns, board.rows, FormatNumber(board.square_mm));
  return fmt::format("charuco:{}x{}:{}:{}:{}", board.columns, board.rows, FormatNumber(board.square_mm),
                     FormatNumber(board.marker_mm), board.dictionary);
}

std::vector<Eigen::Vector2d> BoardCorners(const Board& board) {
  std::vector<Eigen::Vector2d> corners;
  for (int row = 0; row < board.CornerRows(); ++row)
    for (int column = 0; column < board.CornerColumns(); ++column)
      corners.emplace_back(column * board.square_mm, row * board.square_mm);
  return corners;
}

std::vector<BoardRectangle> BoardInk(const Board& board) {
  std::vector<BoardRectangle> ink;
  const double s = board.square_mm;
  for (int from_top = 0; from_top < board.SquareRows(); ++from_top)
    for (int column = 0; column < board.SquareColumns(); ++column)
      if (board.IsBlack(from_top, column))
        ink.push_back(
            {.left = (column - 1) * s, .bottom = (board.SquareRows() - 2 - from_top) * s, .width = s, .height = s});
  if (board.kind == BoardKind::kCharuco) {
    const std::vector<BoardRectangle> markers = MarkerInk(board);
    ink.insert(ink.end(), markers.begin(), markers.end());
  }
  return ink;
}

}  // namespace lake::camera
