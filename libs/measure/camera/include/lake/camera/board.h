// Calibration boards: chessboards and ChArUco boards, as printed and as seen.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lake::camera {

enum class BoardKind { kChessboard, kCharuco };

// A board lies in z = 0 of its own frame: x right, y up on the sheet, z towards who looks at it; the origin is the
// lower left inner corner.
struct Board {
  BoardKind kind = BoardKind::kChessboard;
  int columns = 0;  // inner corners of a chessboard, squares of a ChArUco board
  int rows = 0;
  double square_mm = 0;
  double marker_mm = 0;    // side of a marker, ChArUco only
  std::string dictionary;  // OpenCV's name without DICT_, e.g. 4X4_50; ChArUco only
  // A ChArUco board with an even number of rows, as OpenCV drew it before 4.6 (later setLegacyPattern(true)); the text
  // of a board does not say it, DetectBoard recognises both.
  bool white_top_left = false;

  int SquareColumns() const { return kind == BoardKind::kChessboard ? columns + 1 : columns; }
  int SquareRows() const { return kind == BoardKind::kChessboard ? rows + 1 : rows; }
  int CornerColumns() const { return SquareColumns() - 1; }
  int CornerRows() const { return SquareRows() - 1; }
  bool IsBlack(int row_from_top, int column) const {
    return (row_from_top + column + (white_top_left && SquareRows() % 2 == 0 ? 1 : 0)) % 2 == 0;
  }
};

// chessboard:COLSxROWS:SQUARE_MM or charuco:COLSxROWS:SQUARE_MM:MARKER_MM:DICT. Throws UsageError that quotes the text
// and says what is wrong with it.
Board ParseBoard(std::string_view text);

// The text that ParseBoard understands.
std::string ToString(const Board& board);

// The inner corners, mm, row by row from below: corner `column + row * CornerColumns()` is at (column, row) · square.
std::vector<Eigen::Vector2d> BoardCorners(const Board& board);

// A rectangle with sides along x and y, mm in the board frame.
struct BoardRectangle {
  double left, bottom, width, height;
};

// What is black on the sheet: squares, and the black cells of markers. Unless white_top_left says otherwise, in
// OpenCV's layout since 4.6, with a black top left square.
std::vector<BoardRectangle> BoardInk(const Board& board);

// The corners of a board that were found in one picture.
struct BoardView {
  std::string name;                    // of the picture or frame, for messages
  std::vector<int> corner;             // indices into BoardCorners, increasing
  std::vector<Eigen::Vector2d> pixel;  // image frame, one per corner
  double edge_width_px = 0;            // of the black-white steps: contrast / steepest slope; grows with blur
};

struct BoardDetectionOptions {
  // Half the window of the sub-pixel corner search, px; 0 takes 0.35 of the distance to the next line of the
  // grid, 2..15 px: a window that reaches other edges spoils the result.
  int half_window_px = 0;
  // Of a chessboard: by OpenCV's sector-based search first, which takes longer and finds more. Without it a picture
  // that shows no board is known not to within milliseconds.
  bool thorough = true;
};

// nullopt if the board is not seen. `grey` is CV_8UC1. A chessboard must be seen whole, a ChArUco board may be cut off
// or covered; either may be printed dark on light or light on dark. A chessboard looks the same after half a turn:
// which of the two was meant cannot be known. A ChArUco board whose markers do not lie as on `board`, in either of
// OpenCV's layouts, is not seen.
std::optional<BoardView> DetectBoard(const cv::Mat& grey, const Board& board,
                                     const BoardDetectionOptions& options = {});

// The sheet on which a board is printed.
struct Paper {
  std::string name;
  double width_mm = 0, height_mm = 0;  // landscape
};

// a4, a3 or letter. Throws UsageError.
Paper ParsePaper(std::string_view name);

// A PDF of one landscape page: the board in the middle, below it a ruler to check the print with, and how to print.
// Throws Error if the board with its white rim (a third of a square) does not fit, naming the largest square that does.
void WriteBoardSheet(const std::filesystem::path& path, const Board& board, const Paper& paper);

}  // namespace lake::camera
