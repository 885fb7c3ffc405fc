#include "lake/exchange/tracker.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <pugixml.hpp>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "text_lines.h"

namespace lake {
namespace {

constexpr double kPixelCentre = 0.5;  // of Tracker's top-left pixel

// A number with decimal point or comma.
std::optional<double> TrackerNumber(std::string cell, const std::string& where) {
  if (cell.find('.') == std::string::npos) std::replace(cell.begin(), cell.end(), ',', '.');
  return NumberOrMissing(cell, where);
}

// The columns of one track.
struct TrackColumns {
  std::string name;
  std::size_t x, y;
};

// Names stand above their columns; a writer that leaves out empty cells is understood if there are as many names as
// tracks.
std::vector<TrackColumns> FindColumns(const std::vector<std::string>& labels, const std::vector<std::string>& names) {
  std::vector<TrackColumns> columns;
  for (std::size_t i = 1; i + 1 < labels.size(); ++i)
    if (labels[i] == "x" && labels[i + 1] == "y") columns.push_back({"", i, i + 1});
  std::vector<std::string> given;
  for (const std::string& name : names)
    if (!name.empty() && !name.starts_with('#')) given.push_back(name);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (given.size() == columns.size())
      columns[k].name = given[k];
    else if (columns[k].x < names.size())
      columns[k].name = names[columns[k].x];
    if (columns[k].name.empty()) columns[k].name = fmt::format("track{}", k + 1);
  }
  return columns;
}

// Tracker's own notation, 1.234567890E2: the digits that a double of this size needs at 1e-9 of itself.
std::string FormatForTracker(double value) {
  std::string text = fmt::format("{:.12E}", value);
  const std::size_t exponent = text.find('E');
  return text.substr(0, exponent + 1) + std::to_string(std::stoi(text.substr(exponent + 1)));
}

pugi::xml_node Property(const pugi::xml_node& object, const char* name) {
  for (const pugi::xml_node property : object.children("property"))
    if (std::string_view(property.attribute("name").value()) == name) return property;
  return {};
}

std::optional<double> PropertyNumber(const pugi::xml_node& object, const char* name, const std::string& path) {
  const pugi::xml_node property = Property(object, name);
  if (!property) return std::nullopt;
  const std::optional<double> value = ParseNumber(property.text().as_string());
  if (!value) throw Fail("{}: property '{}' is '{}', not a number", path, name, property.text().as_string());
  return value;
}

std::optional<double> ReadScale(const pugi::xml_node& panel, const std::string& path) {
  static const std::map<std::string, double> kUnits = {{"mm", 1.0}, {"cm", 10.0}, {"m", 1000.0}};
  const auto unit = kUnits.find(Property(panel, "length_unit").text().as_string());
  const pugi::xml_node first =
      Property(Property(panel, "coords").child("object"), "framedata").child("property").child("object");
  const std::optional<double> px_per_unit = PropertyNumber(first, "xscale", path);
  if (unit == kUnits.end() || !px_per_unit || !(*px_per_unit > 0)) return std::nullopt;
  return unit->second / *px_per_unit;
}

// "[12]" as 12.
std::int64_t FrameIndex(const pugi::xml_node& property, const std::string& path) {
  std::string text = property.attribute("name").value();
  std::erase_if(text, [](char c) { return c == '[' || c == ']'; });
  constexpr std::size_t kMostFrames = 10'000'000;
  return static_cast<std::int64_t>(ParseCount(text, "a frame number", path, kMostFrames));
}

using FramePositions = std::map<std::int64_t, Eigen::Vector3d>;

FramePositions ReadPointMass(const pugi::xml_node& mass, const std::string& path) {
  FramePositions positions;
  for (const pugi::xml_node frame : Property(mass, "framedata").children("property")) {
    const pugi::xml_node data = frame.child("object");
    const auto x = PropertyNumber(data, "x", path), y = PropertyNumber(data, "y", path);
    if (x && y) positions[FrameIndex(frame, path)] = {*x - kPixelCentre, *y - kPixelCentre, 0};
  }
  return positions;
}

}  // namespace

PointRecording ReadTrackerText(const std::filesystem::path& path, double mm_per_unit) {
  const TextLines lines(path);
  std::size_t label_line = 0;
  const auto is_label_row = [&](std::size_t i) {
    const std::vector<std::string> cells = SplitCells(lines[i], '\t');
    return cells.size() >= 3 && cells[0] == "t" && std::find(cells.begin(), cells.end(), "x") != cells.end();
  };
  while (label_line < lines.Count() && !is_label_row(label_line)) ++label_line;
  if (label_line == lines.Count()) throw Fail("{}: not a table of Tracker: no row of labels 't, x, y'", path.string());
  const std::vector<TrackColumns> columns =
      FindColumns(SplitCells(lines[label_line], '\t'),
                  label_line > 0 ? SplitCells(lines[label_line - 1], '\t') : std::vector<std::string>{});
  if (columns.empty()) throw Fail("{}: no column 'x' followed by 'y'", lines.Where(label_line));

  PointRecording recording;
  recording.space = PointSpace::kPlane;
  for (const TrackColumns& column : columns) {
    if (recording.Find(column.name)) throw Fail("{}: the name '{}' stands twice", lines.Where(label_line), column.name);
    recording.points.push_back({column.name, {}});
  }
  for (std::size_t i = label_line + 1; i < lines.Count(); ++i) {
    const std::vector<std::string> cells = SplitCells(lines[i], '\t');
    if (cells.size() == 1 && cells[0].empty()) continue;
    const auto cell = [&](std::size_t c) {
      return c < cells.size() ? TrackerNumber(cells[c], lines.Where(i)) : std::nullopt;
    };
    const auto time_s = cell(0);
    if (!time_s) throw Fail("{}: the time is missing", lines.Where(i));
    if (!recording.time_s.empty() && *time_s <= recording.time_s.back())
      throw Fail("{}: the time does not increase", lines.Where(i));
    recording.frame.push_back(static_cast<std::int64_t>(recording.frame.size()));
    recording.time_s.push_back(*time_s);
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto x = cell(columns[k].x), y = cell(columns[k].y);
      recording.points[k].positions.push_back(x && y ? Eigen::Vector3d(*x * mm_per_unit, *y * mm_per_unit, 0)
                                                     : PointTrack::Missing());
    }
  }
  return recording;
}

void WriteTrackerText(const std::filesystem::path& path, const PointRecording& points) {
  if (points.space == PointSpace::kSpace)
    throw Fail("{}: a table of Tracker holds points of a plane only", path.string());
  const double offset = points.space == PointSpace::kImage ? kPixelCentre : 0;
  std::string text = points.points.size() > 1 ? "#multi:\n" : "", labels = "t";
  for (const PointTrack& point : points.points) text.append("\t").append(point.name).append("\t"), labels += "\tx\ty";
  text.append("\n").append(labels).append("\n");
  for (std::size_t i = 0; i < points.time_s.size(); ++i) {
    text += FormatForTracker(points.time_s[i]);
    for (const PointTrack& point : points.points)
      for (int axis = 0; axis < 2; ++axis)
        text.append("\t").append(point.positions[i].allFinite() ? FormatForTracker(point.positions[i][axis] + offset)
                                                                : "");
    text += "\n";
  }
  WriteTextFile(path, text);
}

PointRecording ReadTrk(const std::filesystem::path& path) {
  pugi::xml_document document;
  const std::string text = ReadTextFile(path);
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
  if (!parsed) throw Fail("{}: not XML: {} at byte {}", path.string(), parsed.description(), parsed.offset);
  const pugi::xml_node panel = document.child("object");
  if (!std::string_view(panel.attribute("class").value()).ends_with("TrackerPanel"))
    throw Fail("{}: not a project of Tracker (no TrackerPanel)", path.string());
  const pugi::xml_node clip = Property(panel, "clipcontrol").child("object");
  const double step_ms = PropertyNumber(clip, "delta_t", path.string()).value_or(0);
  if (!(step_ms > 0)) throw Fail("{}: no frame duration (clipcontrol, delta_t)", path.string());

  std::vector<std::pair<std::string, FramePositions>> masses;
  std::int64_t last = -1;
  for (const pugi::xpath_node found :
       document.select_nodes("//object[contains(@class, 'PointMass') and property[@name='framedata']]")) {
    const FramePositions positions = ReadPointMass(found.node(), path.string());
    if (positions.empty()) continue;
    masses.emplace_back(Property(found.node(), "name").text().as_string(), positions);
    last = std::max(last, positions.rbegin()->first);
  }
  if (masses.empty()) throw Fail("{}: no point mass with positions", path.string());
  PointRecording recording;
  recording.space = PointSpace::kImage;
  recording.mm_per_px = ReadScale(panel, path.string());
  for (std::int64_t frame = 0; frame <= last; ++frame)
    recording.frame.push_back(frame), recording.time_s.push_back(static_cast<double>(frame) * step_ms / 1000);
  for (const auto& [name, positions] : masses) {
    recording.points.push_back({name, std::vector<Eigen::Vector3d>(recording.frame.size(), PointTrack::Missing())});
    for (const auto& [frame, position] : positions)
      recording.points.back().positions[static_cast<std::size_t>(frame)] = position;
  }
  return recording;
}

}  // namespace lake
