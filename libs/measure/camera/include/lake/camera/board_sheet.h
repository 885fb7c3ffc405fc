// Boards on paper, 1:1.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "lake/camera/board.h"

namespace lake::camera {

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
