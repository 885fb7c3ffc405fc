// Tables as CSV whose header names each column's point and axis: OptiTrack Motive (docs.optitrack.com, Data Export),
// DeepLabCut (Mathis et al. 2018, doi 10.1038/s41593-018-0209-y), SLEAP (Pereira et al. 2022, doi
// 10.1038/s41592-022-01426-1), DLTdv (Hedrick 2008, doi 10.1088/1748-3182/3/3/034001) and Kinovea (kinovea.org).
#include <algorithm>
#include <map>
#include <set>

#include "lake/core/error.h"
#include "lake/exchange/formats.h"
#include "readers.h"

namespace lake::exchange {
namespace {

struct ColumnName {
  std::string point, axis;  // x, y, z or likelihood, in small letters
};

// Of "NODE.x", at the last separator; empty without one.
ColumnName SplitName(const std::string& title, std::string_view separator) {
  const std::size_t at = title.rfind(separator);
  if (at == std::string::npos) return {};
  return {title.substr(0, at), Lower(title.substr(at + separator.size()))};
}

std::vector<ColumnName> SplitNames(const std::vector<std::string>& titles, std::string_view separator) {
  std::vector<ColumnName> names;
  names.reserve(titles.size());
  for (const std::string& title : titles) names.push_back(SplitName(title, separator));
  return names;
}

// Where x, y and, in space, z of a point follow each other, and perhaps its likelihood.
PointRecording ReadNamed(const TextLines& lines, PointTable table, const std::vector<ColumnName>& names,
                         const char* example, const std::filesystem::path& path) {
  const std::size_t axes = table.space == PointSpace::kSpace ? 3 : 2;
  std::set<std::string> incomplete;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto follows = [&](std::size_t behind, std::string_view axis) {
      return i + behind < names.size() && names[i + behind].point == names[i].point && names[i + behind].axis == axis;
    };
    if (names[i].point.empty() || !follows(0, "x")) continue;
    if (!follows(1, "y") || (axes == 3 && !follows(2, "z"))) {
      incomplete.insert(names[i].point);
      continue;
    }
    PointColumns& point = table.points.emplace_back(PointColumns{names[i].point, {i, i + 1}});
    if (axes == 3) point.axes.push_back(i + 2);
    if (axes == 2 && follows(2, "z"))
      throw Fail("{}: holds points in space, and does not say their unit: write them as TRC", path.string());
    if (follows(axes, "likelihood") || follows(axes, "score")) point.likelihood = i + axes;
  }
  const std::string without =
      incomplete.empty()
          ? ""
          : fmt::format("no {} the x of {}", axes == 3 ? "y and z follow" : "y follows", fmt::join(incomplete, ", "));
  if (table.points.empty())
    throw Fail("{}: its header names no columns of points, which are {}{}", path.string(), example,
               without.empty() ? "" : "; " + without);
  PointRecording recording = ReadPointTable(lines, table, path);
  if (!incomplete.empty()) recording.warnings.push_back(fmt::format("{}: {}; it is left out", path.string(), without));
  return recording;
}

std::size_t ColumnOf(const std::vector<std::string>& titles, const char* title, const TextLines& lines) {
  const auto found = std::ranges::find(titles, title);
  if (found == titles.end()) throw Fail("{}: no column '{}'", lines.Where(0), title);
  return static_cast<std::size_t>(found - titles.begin());
}

// Of pt1_cam1 the points of the camera that is wanted, as pt1; of all cameras where none is, or there is one.
void ChooseView(const std::string& view, const std::filesystem::path& path, std::vector<ColumnName>& names,
                std::vector<std::string>& warnings) {
  std::set<std::string> cameras;
  for (ColumnName& name : names) {
    name.point = Lower(name.point);
    if (const std::string camera = SplitName(name.point, "_").axis; !camera.empty()) cameras.insert(camera);
  }
  const std::string listed = fmt::format("{}", fmt::join(cameras, ", "));
  if (!view.empty() && !cameras.contains(Lower(view)))
    throw UsageError("--view {}: {} has the cameras {}", view, path.string(), listed);
  if (view.empty() && cameras.size() > 1)
    warnings.push_back(fmt::format("{}: holds the pictures of {} cameras ({}); --view takes those of one",
                                   path.string(), cameras.size(), listed));
  for (ColumnName& name : names) {
    const ColumnName parts = SplitName(name.point, "_");
    if (!view.empty() || cameras.size() == 1) name.point = view.empty() || parts.axis == Lower(view) ? parts.point : "";
  }
}

}  // namespace

// Types and names stand in rows of their own. The measured markers are read; rigid bodies, bones and rotations are left
// out. Y is up.
PointRecording ReadMotive(const std::filesystem::path& path, const ReadOptions&) {
  const TextLines lines(path);
  const char separator = SeparatorOf(lines[0]);
  const auto row = [&](std::size_t line) { return SplitCells(lines[line], separator); };
  std::size_t labels = 1, types = 0;
  while (labels < lines.Count() && row(labels)[0] != "Frame") ++labels;
  for (std::size_t line = labels; line-- > 1;)
    if (lines[line].find_first_not_of(",; ") != std::string::npos) types = line;  // the first below the line of keys
  if (labels + 1 >= lines.Count() || types == 0)
    throw Fail("{}: a table of Motive without its rows of types, names and labels; export it with its header",
               path.string());
  const std::vector<std::string> keys = row(0), type = row(types), name = row(types + 1), kind = row(labels - 1),
                                 axis = row(labels);
  const std::size_t unit = ColumnOf(keys, "Length Units", lines) + 1;
  const std::optional<double> mm_per_unit = FindMmPerUnit(unit < keys.size() ? keys[unit] : "");
  if (!mm_per_unit) throw Fail("{}: 'Length Units' are no unit of length", lines.Where(0));
  constexpr const char* kMeasured = "Marker";  // others, as "Rigid Body Marker", follow a model
  const bool has_measured = std::ranges::find(type, kMeasured) != type.end();
  std::vector<ColumnName> names(std::min({type.size(), name.size(), kind.size(), axis.size()}));
  std::set<std::string> left_out;
  for (std::size_t i = 2; i < names.size(); ++i)
    if (has_measured ? type[i] != kMeasured : !type[i].ends_with(kMeasured))
      left_out.insert(type[i]);
    else if (kind[i] == "Position")
      names[i] = {name[i], Lower(axis[i])};
  PointRecording recording = ReadNamed(lines,
                                       {.space = PointSpace::kSpace,
                                        .first_row = labels + 1,
                                        .separator = separator,
                                        .time = 1,
                                        .frame = 0,
                                        .mm_per_unit = *mm_per_unit},
                                       names, "of the type Marker and Position: export markers", path);
  if (!has_measured)
    recording.warnings.push_back(
        fmt::format("{}: holds no measured markers; those that Motive expects on its rigid bodies and skeletons are "
                    "read, which follow its model",
                    path.string()));
  left_out.erase("");
  if (!left_out.empty())
    recording.warnings.push_back(
        fmt::format("{}: columns of {} are left out", path.string(), fmt::join(left_out, ", ")));
  return recording;
}

// Rows of names above the numbers: scorer, [individuals,] bodyparts, coords; px from 0 at the top-left pixel.
PointRecording ReadDeepLabCut(const std::filesystem::path& path, const ReadOptions& options) {
  constexpr double kLeastLikelihood = 0.6;  // what its own plots and analyses leave out by default (pcutoff)
  const TextLines lines(path);
  const char separator = SeparatorOf(lines[0]);
  std::vector<std::string> individuals, parts, coords;
  std::size_t first_row = 0;
  while (coords.empty() && first_row < lines.Count()) {
    const std::vector<std::string> cells = SplitCells(lines[first_row++], separator);
    if (cells[0] != "scorer")
      (cells[0] == "individuals" ? individuals : cells[0] == "bodyparts" ? parts : coords) = cells;
  }
  if (parts.size() != coords.size() || coords.empty() || coords[0] != "coords")
    throw Fail("{}: a table of DeepLabCut without its rows 'bodyparts' and 'coords'", path.string());
  const bool several = individuals.size() == parts.size() &&
                       std::set<std::string>(individuals.begin() + 1, individuals.end()).size() > 1;
  std::vector<ColumnName> names;
  for (std::size_t i = 0; i < parts.size(); ++i)
    names.push_back({several ? individuals[i] + "_" + parts[i] : parts[i], coords[i]});
  return ReadNamed(lines,
                   {.space = PointSpace::kImage,
                    .first_row = first_row,
                    .separator = separator,
                    .frame = 0,
                    .rate_hz = options.rate_hz,
                    .least_likelihood = kLeastLikelihood},
                   names, "x, y, likelihood", path);
}

// A row per frame and animal: track, frame_idx, instance.score, NODE.x, NODE.y, NODE.score; px from 0 at the top-left
// pixel.
PointRecording ReadSleap(const std::filesystem::path& path, const ReadOptions& options) {
  const TextLines lines(path);
  const std::vector<std::string> titles = SplitCells(lines[0], SeparatorOf(lines[0]));
  const std::size_t track = ColumnOf(titles, "track", lines);
  PointTable table{.space = PointSpace::kImage,
                   .separator = SeparatorOf(lines[0]),
                   .frame = ColumnOf(titles, "frame_idx", lines),
                   .rate_hz = options.rate_hz,
                   .least_likelihood = 0.2};               // as of the peaks that it finds
  std::map<std::string, std::vector<std::size_t>> tracks;  // the lines of each
  for (std::size_t line = 1; line < lines.Count(); ++line) {
    const std::vector<std::string> cells = SplitCells(lines[line], table.separator);
    if (cells.size() > std::max(track, *table.frame) && CountIn(cells[*table.frame]))
      tracks[cells[track]].push_back(line);
  }
  std::vector<FramePoints> found;
  std::vector<std::string> warnings;
  for (const auto& [name, rows] : tracks) {
    table.rows = rows;
    const PointRecording read = ReadNamed(lines, table, SplitNames(titles, "."), "NODE.x, NODE.y", path);
    std::ranges::copy(read.warnings, std::back_inserter(warnings));
    for (const PointTrack& point : read.points) {
      FramePoints& points =
          found.emplace_back(FramePoints{tracks.size() > 1 ? fmt::format("{}_{}", name, point.name) : point.name, {}});
      for (std::size_t i = 0; i < read.frame.size(); ++i)
        if (point.positions[i].allFinite()) points.positions[read.frame[i]] = point.positions[i];
    }
  }
  if (found.empty()) throw Fail("{}: a table of SLEAP without rows", path.string());
  PointRecording recording = PointsByFrame(found, std::filesystem::file_size(path), path, options.rate_hz);
  std::ranges::copy(warnings, std::back_inserter(recording.warnings));
  return recording;
}

namespace {

constexpr double kFirstPixel = 1;  // of DLTdv, at the top-left

void WarnOfOrigin(const std::filesystem::path& path, PointRecording& recording) {
  recording.warnings.push_back(fmt::format(
      "{}: y is taken to run down from the picture's top, as DLTdv 8 has it; older versions count from below",
      path.string()));
}

}  // namespace

// Columns pt1_cam1_X, pt1_cam1_Y, pt1_cam2_X, …, a row per frame.
PointRecording ReadDltdv(const std::filesystem::path& path, const ReadOptions& options) {
  const TextLines lines(path);
  const char separator = SeparatorOf(lines[0]);
  std::vector<ColumnName> names = SplitNames(SplitCells(lines[0], separator), "_");
  std::vector<std::string> warnings;
  ChooseView(options.view, path, names, warnings);
  PointRecording recording = ReadNamed(lines,
                                       {.space = PointSpace::kImage,
                                        .separator = separator,
                                        .rate_hz = options.rate_hz,
                                        .first_pixel = kFirstPixel,
                                        .names_all = options.view.empty()},
                                       names, "ptN_camM_X, ptN_camM_Y", path);
  recording.warnings.insert(recording.warnings.begin(), warnings.begin(), warnings.end());
  WarnOfOrigin(path, recording);
  return recording;
}

// DLTdv's rows "frame, column, value", whose columns are taken in pairs. A value of 0 is a missing one.
PointRecording ReadDltdvSparse(const std::filesystem::path& path, const ReadOptions& options) {
  if (!options.view.empty())
    throw UsageError("--view {}: {} names no cameras: choose points by --map", options.view, path.string());
  constexpr std::size_t kMostColumns = 20'000;
  const TextLines lines(path);
  std::map<std::size_t, std::map<std::int64_t, double>> columns;  // column from 0, frame from 0, value
  LeftOut left_out;
  for (std::size_t line = 1; line < lines.Count(); ++line) {
    std::vector<std::string> cells = SplitCells(lines[line], '\t');
    if (cells.size() != 3) cells.assign(3, "");
    bool is_unreadable = false;
    const std::size_t frame = CountIn(cells[0]).value_or(0), column = CountIn(cells[1], kMostColumns).value_or(0);
    const double value = NumberIn(cells[2], is_unreadable).value_or(0);
    if (frame > 0 && column > 0 && !is_unreadable) {
      if (value != 0) columns[column - 1][static_cast<std::int64_t>(frame) - 1] = value;
    } else if (!lines[line].empty()) {
      left_out.Add("a row that is not 'frame, column, value'", lines.Where(line));
    }
  }
  std::vector<FramePoints> found;
  for (std::size_t c = 0; !columns.empty() && c <= columns.rbegin()->first; c += 2) {
    FramePoints& track = found.emplace_back(FramePoints{fmt::format("pt{}", c / 2 + 1), {}});
    for (const auto& [frame, x] : columns[c])
      if (const auto y = columns[c + 1].find(frame); y != columns[c + 1].end())
        track.positions[frame] = {x - kFirstPixel, y->second - kFirstPixel, 0};
  }
  PointRecording recording = PointsByFrame(found, std::filesystem::file_size(path), path, options.rate_hz, left_out);
  recording.warnings.push_back(fmt::format(
      "{}: its columns have no names: each two are a point, pt1, pt2, …; of several cameras they take turns",
      path.string()));
  WarnOfOrigin(path, recording);
  return recording;
}

// Columns NAME/0/X, NAME/0/Y behind the times, which are in ms or s: a frame lasts between 1 ms and 1 s.
PointRecording ReadKinovea(const std::filesystem::path& path, const ReadOptions& options) {
  const TextLines lines(path);
  const char separator = SeparatorOf(lines[0]);
  PointRecording recording = ReadNamed(lines, {.separator = separator, .time = 0, .mm_per_unit = options.mm_per_unit},
                                       SplitNames(SplitCells(lines[0], separator), "/0/"), "NAME/0/X, NAME/0/Y", path);
  ToSeconds(recording, path);
  return recording;
}

}  // namespace lake::exchange
