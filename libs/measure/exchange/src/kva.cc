// Kinovea's annotation files. What their parts mean is taken from Kinovea's own serializer (MetadataSerializer,
// DrawingTrack, CalibrationHelper): track points are "x;y;timestamp", one frame lasts AverageTimeStampsPerFrame.
#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/utf8.h"
#include "lake/exchange/formats.h"
#include "readers.h"

namespace lake::exchange {
namespace {

struct KvaClock {
  double stamps_per_frame = 1, first_stamp = 0, rate_hz = 0;

  double Frame(double stamp) const { return (stamp - first_stamp) / stamps_per_frame; }
};

// Of "x;y;timestamp", up to what is no number.
std::vector<double> NumbersIn(const pugi::xml_node& node) {
  std::vector<double> numbers;
  for (const std::string& part : SplitText(node.text().as_string(), ';')) {
    const std::optional<double> number = ParseNumber(Trim(part));
    if (!number) break;
    numbers.push_back(*number);
  }
  return numbers;
}

double ChildNumber(const pugi::xml_node& node, const char* name, double otherwise = 0) {
  const std::vector<double> numbers = NumbersIn(node.child(name));
  return numbers.empty() ? otherwise : numbers[0];
}

KvaClock ReadClock(const pugi::xml_node& root, const std::string& path) {
  const KvaClock clock{.stamps_per_frame = ChildNumber(root, "AverageTimeStampsPerFrame"),
                       .first_stamp = ChildNumber(root, "FirstTimeStamp"),
                       .rate_hz = ChildNumber(root, "CaptureFramerate", ChildNumber(root, "UserFramerate"))};
  if (!(clock.stamps_per_frame > 0))
    throw Fail("{}: AverageTimeStampsPerFrame is {}, so that no frame has a time", path, clock.stamps_per_frame);
  if (!(clock.rate_hz > 0))
    throw Fail("{}: no frame rate (CaptureFramerate); save it with Kinovea 0.8.20 or newer", path);
  return clock;
}

// mm per px of a calibration line: its length and its ends, or the scale that older versions keep.
std::optional<double> ReadScale(const pugi::xml_node& calibration) {
  const std::optional<double> mm_per_unit =
      FindMmPerUnit(calibration.child("Unit").attribute("Abbreviation").as_string());
  const pugi::xml_node line = calibration.child("CalibrationLine"), segment = line.child("Segment");
  const std::vector<double> a = NumbersIn(segment.child("A")), b = NumbersIn(segment.child("B"));
  const double length_px = a.size() == 2 && b.size() == 2 ? std::hypot(a[0] - b[0], a[1] - b[1]) : 0,
               scale = ChildNumber(line, "Scale", ChildNumber(line, "Length") / length_px);
  return mm_per_unit && scale > 0 && std::isfinite(scale) ? std::optional(scale * *mm_per_unit) : std::nullopt;
}

std::string TrackName(const pugi::xml_node& track) {
  const char* name = track.attribute("name").as_string();
  return *name ? name : track.child("MainLabel").attribute("Text").as_string("track");
}

// The points of a track; `times_s` gets the times of their frames.
FramePoints ReadTrack(const pugi::xml_node& track, const KvaClock& clock, const std::string& path,
                      std::map<std::int64_t, double>& times_s, LeftOut& left_out) {
  FramePoints points{TrackName(track), {}};
  for (const pugi::xml_node node : track.child("TrackPointList").children("TrackPoint")) {
    const std::vector<double> numbers = NumbersIn(node);  // x, y, time stamp
    const double frame = numbers.size() > 2 ? clock.Frame(numbers[2]) : -1;
    if (!(frame > -0.5 && frame < static_cast<double>(kMostFrames))) {
      left_out.Add("a point that is not 'x;y;timestamp' of the video",
                   fmt::format("{}: track '{}': '{}'", path, points.name, node.text().as_string()));
      continue;
    }
    const std::int64_t index = std::llround(frame);
    times_s[index] = frame / clock.rate_hz;
    points.positions[index] = {numbers[0] - kPixelCentre, numbers[1] - kPixelCentre, 0};
  }
  return points;
}

// Whole stamps of so small a part of a frame that times keep a microsecond at any rate above 10 Hz.
constexpr double kStampsPerFrame = 100'000;

void AddText(pugi::xml_node node, const char* name, const std::string& text) {
  node.append_child(name).text() = ReadableUtf8(text).c_str();
}

void AddTrack(pugi::xml_node tracks, const PointRecording& recording, const PointTrack& point, double rate_hz) {
  const auto known = [](const Eigen::Vector3d& p) { return p.allFinite(); };
  const auto count = std::count_if(point.positions.begin(), point.positions.end(), known);
  if (count == 0) return;  // Kinovea refuses a track without points
  const auto stamp = [&](std::size_t i) { return std::llround(recording.time_s[i] * rate_hz * kStampsPerFrame); };
  const auto first = static_cast<std::size_t>(std::find_if(point.positions.begin(), point.positions.end(), known) -
                                              point.positions.begin());
  pugi::xml_node track = tracks.append_child("Track");
  track.append_attribute("name") = point.name.c_str();
  AddText(track, "TimePosition", std::to_string(stamp(first)));
  pugi::xml_node list = track.append_child("TrackPointList");
  list.append_attribute("Count") = std::to_string(count).c_str();
  for (std::size_t i = 0; i < recording.frame.size(); ++i)
    if (const Eigen::Vector3d& p = point.positions[i]; known(p))
      AddText(
          list, "TrackPoint",
          fmt::format("{};{};{}", FormatNumber(p.x() + kPixelCentre), FormatNumber(p.y() + kPixelCentre), stamp(i)));
  pugi::xml_node label = track.append_child("MainLabel");
  label.append_attribute("Text") = point.name.c_str();
  AddText(label, "SpacePosition", "0;0");
  AddText(label, "TimePosition", std::to_string(stamp(first)));
}

void AddCalibration(pugi::xml_node root, double mm_per_px) {
  constexpr double kLinePx = 100;
  pugi::xml_node calibration = root.append_child("Calibration"), line = calibration.append_child("CalibrationLine");
  AddText(line, "Length", FormatNumber(kLinePx * mm_per_px));
  pugi::xml_node segment = line.append_child("Segment");
  AddText(segment, "A", "0;0");
  AddText(segment, "B", FormatNumber(kLinePx) + ";0");
  AddText(line, "Origin", "0;0");
  AddText(line, "Axis", "LineHorizontal");
  pugi::xml_node unit = calibration.append_child("Unit");
  unit.append_attribute("Abbreviation") = "mm";
  unit.text() = "Millimeters";
}

}  // namespace

PointRecording ReadKva(const std::filesystem::path& path, const ReadOptions& /*options*/) {
  const std::string text = ReadTextFile(path);
  pugi::xml_document document;
  const std::vector<std::string> warnings = ParseXml(text, path, document);
  const pugi::xml_node root = document.child("KinoveaVideoAnalysis");
  if (!root) throw Fail("{}: not an annotation file of Kinovea (no KinoveaVideoAnalysis)", path.string());
  const KvaClock clock = ReadClock(root, path.string());
  std::vector<FramePoints> tracks;
  std::map<std::int64_t, double> times_s;
  LeftOut left_out;
  for (const pugi::xml_node track : root.child("Tracks").children("Track"))
    tracks.push_back(ReadTrack(track, clock, path.string(), times_s, left_out));
  std::erase_if(tracks, [](const FramePoints& track) { return track.positions.empty(); });
  PointRecording recording = PointsByFrame(tracks, text.size(), path, 0, left_out);
  recording.warnings.insert(recording.warnings.begin(), warnings.begin(), warnings.end());
  recording.mm_per_px = ReadScale(root.child("Calibration"));
  if (root.child("Calibration").child("CalibrationLine") && !recording.mm_per_px)
    recording.warnings.push_back(fmt::format(
        "{}: its calibration line has no readable length, ends or unit: positions stay in px", path.string()));
  if (root.child("Calibration").child("CalibrationPlane"))
    recording.warnings.push_back(fmt::format(
        "{}: its perspective calibration is not used: positions stay in px; Kinovea's CSV has them calibrated",
        path.string()));
  for (const std::int64_t frame : recording.frame) {
    const auto found = times_s.find(frame);
    recording.time_s.push_back(found == times_s.end() ? static_cast<double>(frame) / clock.rate_hz : found->second);
  }
  return recording;
}

void WriteKva(const std::filesystem::path& path, const PointRecording& points) {
  if (points.frame.size() < 2)
    throw Fail("{}: an annotation file of Kinovea needs two frames for its rate", path.string());
  const double rate_hz = FrameRate(points.time_s);
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("KinoveaVideoAnalysis");
  AddText(root, "FormatVersion", "2.0");
  AddText(root, "Producer", "lake");
  if (points.video) {
    AddText(root, "OriginalFilename", std::filesystem::path(points.video->file).stem().string());
    AddText(root, "FullPath", points.video->file);
    AddText(root, "ImageSize", fmt::format("{};{}", points.video->width_px, points.video->height_px));
  }
  AddText(root, "AverageTimeStampsPerFrame", FormatNumber(kStampsPerFrame));
  AddText(root, "CaptureFramerate", FormatNumber(rate_hz));
  AddText(root, "UserFramerate", FormatNumber(rate_hz));
  AddText(root, "FirstTimeStamp", "0");
  AddText(root, "SelectionStart", "0");
  if (points.mm_per_px) AddCalibration(root, *points.mm_per_px);
  pugi::xml_node tracks = root.append_child("Tracks");
  for (const PointTrack& point : points.points) AddTrack(tracks, points, point, rate_hz);
  WriteXml(path, document);
}

}  // namespace lake::exchange
