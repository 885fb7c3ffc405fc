// OptiTrack Motive (docs.optitrack.com, Data Export: CSV): a line of keys and values, rows of the columns' types and
// names, then a row per frame. The measured markers are read; rigid bodies, bones, their expected markers and
// rotations are left out. Y is up.
#include <algorithm>
#include <set>

#include "lake/core/error.h"
#include "lake/exchange/formats.h"
#include "point_table.h"

namespace lake::exchange {
namespace {

// Types of columns whose positions are of markers: measured ones, and, where there are none of these, those that Motive
// works out from a rigid body or a skeleton.
constexpr const char* kMeasured = "Marker";

// The value that follows a key in the first line.
std::string ValueOf(const std::vector<std::string>& first_line, const std::string& key) {
  for (std::size_t i = 0; i + 1 < first_line.size(); ++i)
    if (first_line[i] == key) return first_line[i + 1];
  return "";
}

}  // namespace

PointRecording ReadMotive(const std::filesystem::path& path, const ReadOptions&) {
  const TextLines lines(path);
  const std::vector<std::string> keys = SplitCells(lines[0], ',');
  std::size_t labels = 1, types = 0;
  while (labels < lines.Count() && !lines[labels].starts_with("Frame")) ++labels;
  for (std::size_t line = labels; line-- > 1;)
    if (!lines[line].empty()) types = line;  // the first row below the line of keys
  if (labels + 1 >= lines.Count() || types == 0)
    throw Fail("{}: a table of Motive without its rows of types, names and labels; export it with its header",
               path.string());
  const std::vector<std::string> type = SplitCells(lines[types], ','), name = SplitCells(lines[types + 1], ','),
                                 kind = SplitCells(lines[labels - 1], ','), axis = SplitCells(lines[labels], ',');
  const std::string unit = ValueOf(keys, "Length Units");
  const std::optional<double> mm_per_unit = FindMmPerUnit(unit);
  if (!mm_per_unit) throw Fail("{}: 'Length Units' is '{}', no unit of length", lines.Where(0), unit);
  PointTable table{
      .space = PointSpace::kSpace, .first_row = labels + 1, .time = 1, .frame = 0, .mm_per_unit = *mm_per_unit};
  std::set<std::string> left_out;
  const std::size_t width = std::min({type.size(), name.size(), kind.size(), axis.size()});
  const bool has_measured = std::ranges::find(type, kMeasured) != type.end();
  for (std::size_t i = 2; i + 2 < width; ++i) {
    const bool is_marker = has_measured ? type[i] == kMeasured : type[i].ends_with(kMeasured);
    const bool is_position = kind[i] == "Position" && axis[i] == "X" && axis[i + 1] == "Y" && axis[i + 2] == "Z";
    if (is_marker && is_position)
      table.points.push_back({name[i], {i, i + 1, i + 2}});
    else if (!is_marker && !type[i].empty())
      left_out.insert(type[i]);
  }
  if (table.points.empty())
    throw Fail("{}: a table of Motive without markers: export them (Markers: on)", path.string());
  PointRecording recording = ReadPointTable(lines, table, path);
  if (!has_measured)
    recording.warnings.push_back(
        fmt::format("{}: holds no measured markers; those that Motive expects on its rigid bodies and skeletons are "
                    "read, which follow its model",
                    path.string()));
  if (!left_out.empty())
    recording.warnings.push_back(
        fmt::format("{}: columns of {} are left out", path.string(), fmt::join(left_out, ", ")));
  return recording;
}

}  // namespace lake::exchange
