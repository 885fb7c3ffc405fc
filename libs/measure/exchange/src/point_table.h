// Tables in text with one row per frame and some columns per point, as most programs export them: each dialect says
// where its columns are, and one reader does the rest. Not part of the interface.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lake/exchange/point_recording.h"
#include "text_lines.h"

namespace lake::exchange {

struct PointColumns {
  std::string name;
  std::vector<std::size_t> axes;  // columns of x, y and, in space, z
  std::optional<std::size_t> likelihood = {};
};

struct PointTable {
  PointSpace space = PointSpace::kPlane;
  std::size_t first_row = 1;  // index of the line
  std::size_t end_row = std::numeric_limits<std::size_t>::max();
  char separator = ',';
  std::optional<std::size_t> time = {}, frame = {};  // columns; a time may be hours:minutes:seconds:hundredths
  double rate_hz = 0;                                // gives the time of a row that has none of its own
  double first_frame = 0;                            // the number by which the file calls it
  std::vector<PointColumns> points = {};
  double mm_per_unit = 1;
  double first_pixel = 0;        // coordinate of the centre of the top-left pixel
  double least_likelihood = 0;   // below it a point counts as not seen
  bool zero_is_missing = false;  // 0, 0, 0 stands for a missing point
  bool names_all = false;        // a value in any other column is of a point without a name
  std::optional<std::size_t> stated_rows = {};
  std::optional<std::pair<std::size_t, std::string>> only = {};  // the rows with this text in this column
};

// Cells that are no number are missing; rows without a time, or with one that does not follow the one before, and a
// last row that is cut off are left out, each with a warning. Throws Error if no row is left.
PointRecording ReadPointTable(const TextLines& lines, const PointTable& table, const std::filesystem::path& path);

}  // namespace lake::exchange
