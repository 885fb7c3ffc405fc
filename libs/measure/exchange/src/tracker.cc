// Tracker's text table (physlets.org/tracker): `#multi:` if there are several tracks, a row of names, a row
// `t x y x y …`, then numbers between tabs, with decimal point or comma. It does not say its unit of length.
#include <algorithm>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/exchange/formats.h"
#include "readers.h"

namespace lake::exchange {
namespace {

// Names stand above their columns; a writer that leaves out empty cells is understood if there are as many names as
// tracks.
std::vector<PointColumns> FindColumns(const std::vector<std::string>& labels, const std::vector<std::string>& names) {
  std::vector<PointColumns> columns;
  for (std::size_t i = 1; i + 1 < labels.size(); ++i)
    if (labels[i] == "x" && labels[i + 1] == "y") columns.push_back({"", {i, i + 1}});
  std::vector<std::string> given;
  for (const std::string& name : names)
    if (!name.empty() && !name.starts_with('#')) given.push_back(name);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (given.size() == columns.size())
      columns[k].name = given[k];
    else if (columns[k].axes[0] < names.size())
      columns[k].name = names[columns[k].axes[0]];
    if (columns[k].name.empty()) columns[k].name = fmt::format("track{}", k + 1);
  }
  return columns;
}

}  // namespace

PointRecording ReadTrackerText(const std::filesystem::path& path, const ReadOptions& options) {
  const TextLines lines(path);
  std::size_t label_line = 0;
  const auto cells_of = [&](std::size_t line) { return SplitCells(lines[line], SeparatorOf(lines[label_line])); };
  const auto is_label_row = [&] {
    const std::vector<std::string> cells = cells_of(label_line);
    return cells.size() >= 3 && cells[0] == "t" && std::find(cells.begin(), cells.end(), "x") != cells.end();
  };
  while (label_line < lines.Count() && !is_label_row()) ++label_line;
  if (label_line == lines.Count()) throw Fail("{}: not a table of Tracker: no row of labels 't, x, y'", path.string());
  const PointTable table{.first_row = label_line + 1,
                         .separator = SeparatorOf(lines[label_line]),
                         .time = 0,
                         .points = FindColumns(cells_of(label_line),
                                               label_line > 0 ? cells_of(label_line - 1) : std::vector<std::string>{}),
                         .mm_per_unit = options.mm_per_unit};
  if (table.points.empty()) throw Fail("{}: no columns 'x' followed by 'y'", lines.Where(label_line));
  return ReadPointTable(lines, table, path);
}

void WriteTrackerText(const std::filesystem::path& path, const PointRecording& points) {
  CheckNames(points, path);
  const PointRecording drawn = AsDrawn(points);
  std::string text = points.points.size() > 1 ? "#multi:\n" : "", labels = "t";
  for (const PointTrack& point : points.points) {
    text.append("\t").append(point.name).append("\t");
    labels += "\tx\ty";
  }
  text.append("\n").append(labels).append("\n");
  for (std::size_t i = 0; i < points.time_s.size(); ++i) {
    text += FormatNumber(points.time_s[i]);
    for (const PointTrack& point : drawn.points)
      for (int axis = 0; axis < 2; ++axis)
        text.append("\t").append(point.positions[i].allFinite() ? FormatNumber(point.positions[i][axis]) : "");
    text += "\n";
  }
  WriteTextFile(path, text);
}

}  // namespace lake::exchange
