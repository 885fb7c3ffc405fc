// DeepLabCut (Mathis et al. 2018, doi 10.1038/s41593-018-0209-y): its predictions as CSV, rows of names above the
// numbers: scorer, [individuals,] bodyparts, coords; then a row per frame, px from 0 at the top-left pixel.
#include <algorithm>
#include <functional>

#include "lake/core/error.h"
#include "lake/exchange/formats.h"
#include "point_table.h"

namespace lake::exchange {
namespace {

// What its own plots and analyses leave out by default (pcutoff).
constexpr double kLeastLikelihood = 0.6;

}  // namespace

PointRecording ReadDeepLabCut(const std::filesystem::path& path, const ReadOptions& options) {
  const TextLines lines(path);
  const char separator = SeparatorOf(lines[0]);
  std::vector<std::string> individuals, parts, coords;
  PointTable table{.space = PointSpace::kImage,
                   .first_row = 0,
                   .separator = separator,
                   .frame = 0,
                   .rate_hz = options.rate_hz,
                   .least_likelihood = kLeastLikelihood};
  while (coords.empty() && table.first_row < lines.Count()) {
    std::vector<std::string> cells = SplitCells(lines[table.first_row++], separator);
    (cells[0] == "individuals" ? individuals : cells[0] == "bodyparts" ? parts : coords) = cells;
    if (cells[0] == "scorer") coords.clear();
  }
  if (parts.size() != coords.size() || coords.empty() || coords[0] != "coords")
    throw Fail("{}: a table of DeepLabCut without its rows 'bodyparts' and 'coords'", path.string());
  const bool several =
      individuals.size() == parts.size() &&
      std::adjacent_find(individuals.begin() + 1, individuals.end(), std::not_equal_to<>()) != individuals.end();
  for (std::size_t i = 1; i + 1 < coords.size(); ++i)
    if (coords[i] == "x" && coords[i + 1] == "y") {
      const bool has_likelihood = i + 2 < coords.size() && coords[i + 2] == "likelihood";
      table.points.push_back({several ? individuals[i] + "_" + parts[i] : parts[i],
                              {i, i + 1},
                              has_likelihood ? std::optional(i + 2) : std::nullopt});
    }
  return ReadPointTable(lines, table, path);
}

}  // namespace lake::exchange
