// Tracker's projects. What their parts mean is taken from Tracker's own loaders (OpenSourcePhysics/osp:
// ImageCoordSystem, VideoPlayer, VideoClip): angle in degrees, counter-clockwise; time = start time + (frame − start
// frame) × frame duration.
#include <optional>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/utf8.h"
#include "lake/exchange/formats.h"
#include "readers.h"

namespace lake::exchange {
namespace {

pugi::xml_node Property(const pugi::xml_node& object, const char* name) {
  for (const pugi::xml_node property : object.children("property"))
    if (std::string_view(property.attribute("name").value()) == name) return property;
  return {};
}

std::optional<double> PropertyNumber(const pugi::xml_node& object, const char* name) {
  return ParseNumber(Property(object, name).text().as_string());
}

void ReadCoordinates(const pugi::xml_node& panel, const std::string& path, PointRecording& recording) {
  const pugi::xml_node frames = Property(Property(panel, "coords").child("object"), "framedata");
  const pugi::xml_node first = frames.child("property").child("object");
  const auto x = PropertyNumber(first, "xorigin"), y = PropertyNumber(first, "yorigin");
  if (x && y)
    recording.axes = ImageAxes{{*x - kPixelCentre, *y - kPixelCentre}, PropertyNumber(first, "angle").value_or(0)};
  const std::optional<double> px_per_unit = PropertyNumber(first, "xscale");
  const std::string unit = Property(panel, "length_unit").text().as_string();
  const std::optional<double> mm_per_unit = FindMmPerUnit(unit);
  // Tracker writes 1 px per unit, and the unit m, where nobody calibrated.
  const bool is_default = px_per_unit == 1.0 && mm_per_unit == 1000.0;
  if (mm_per_unit && px_per_unit && *px_per_unit > 0 && !is_default) recording.mm_per_px = *mm_per_unit / *px_per_unit;
  if (is_default)
    recording.warnings.push_back(
        fmt::format("{}: was never calibrated, as 1 px is 1 m in it: positions are in px", path));
  if (first.parent().next_sibling("property"))
    recording.warnings.push_back(
        fmt::format("{}: its axes change from frame to frame; those of the first are taken", path));
}

// "[12]" as 12.
std::optional<std::size_t> FrameIndex(const pugi::xml_node& property) {
  std::string text = property.attribute("name").value();
  std::erase_if(text, [](char c) { return c == '[' || c == ']'; });
  return CountIn(text);
}

FramePoints ReadPointMass(const pugi::xml_node& mass, const std::string& path, LeftOut& left_out) {
  FramePoints points{Property(mass, "name").text().as_string(), {}};
  for (const pugi::xml_node frame : Property(mass, "framedata").children("property")) {
    const pugi::xml_node data = frame.child("object");
    const auto x = PropertyNumber(data, "x"), y = PropertyNumber(data, "y");
    if (const auto index = FrameIndex(frame); x && y && index)
      points.positions[static_cast<std::int64_t>(*index)] = {*x - kPixelCentre, *y - kPixelCentre, 0};
    else if (data)
      left_out.Add("a position without numbers for x, y and frame", fmt::format("{}: {}", path, points.name));
  }
  return points;
}

void ReadTimes(const pugi::xml_node& panel, const std::string& path, PointRecording& recording) {
  const double step_ms = PropertyNumber(Property(panel, "clipcontrol").child("object"), "delta_t").value_or(0);
  if (!(step_ms > 0)) throw Fail("{}: no frame duration (clipcontrol, delta_t)", path);
  const pugi::xml_node clip = Property(panel, "videoclip").child("object");
  const double start_ms = PropertyNumber(clip, "starttime").value_or(0),
               start_frame = PropertyNumber(clip, "startframe").value_or(0);
  for (const std::int64_t frame : recording.frame)
    recording.time_s.push_back((start_ms + (static_cast<double>(frame) - start_frame) * step_ms) / 1000);
}

constexpr const char* kTrackerPackage = "org.opensourcephysics.cabrillo.tracker.";
constexpr const char* kMediaPackage = "org.opensourcephysics.media.";

pugi::xml_node AddProperty(pugi::xml_node object, const std::string& name, const char* type) {
  pugi::xml_node property = object.append_child("property");
  property.append_attribute("name") = name.c_str();
  property.append_attribute("type") = type;
  return property;
}

void AddText(pugi::xml_node object, const char* name, const char* type, const std::string& text) {
  AddProperty(object, name, type).text() = ReadableUtf8(text).c_str();
}

void AddNumber(pugi::xml_node object, const char* name, double value) {
  AddText(object, name, "double", FormatNumber(value));
}

pugi::xml_node AddObject(pugi::xml_node property, const std::string& class_name) {
  pugi::xml_node object = property.append_child("object");
  object.append_attribute("class") = class_name.c_str();
  return object;
}

// The property that holds one object per frame.
pugi::xml_node AddFrames(pugi::xml_node object, const std::string& class_name) {
  pugi::xml_node frames = AddProperty(object, "framedata", "array");
  frames.append_attribute("class") = fmt::format("[L{};", class_name).c_str();
  return frames;
}

void AddClip(pugi::xml_node panel, const PointRecording& points) {
  const std::string clip_class = std::string(kMediaPackage) + "core.VideoClip";
  pugi::xml_node clip = AddObject(AddProperty(panel, "videoclip", "object"), clip_class);
  if (points.video) {
    pugi::xml_node video =
        AddObject(AddProperty(clip, "video", "object"), std::string(kMediaPackage) + "xuggle.XuggleVideo");
    AddText(video, "path", "string", points.video->file);
  }
  // The frames' mean duration, and the time of frame 0.
  const auto frames = static_cast<double>(points.frame.back() - points.frame.front());
  const double step_ms = 1000 * (points.time_s.back() - points.time_s.front()) / frames;
  const std::string count = std::to_string(points.frame.back() + 1);
  AddText(clip, "video_framecount", "int", count);
  AddText(clip, "startframe", "int", "0");
  AddText(clip, "stepsize", "int", "1");
  AddText(clip, "stepcount", "int", count);
  AddNumber(clip, "starttime", 1000 * points.time_s.front() - static_cast<double>(points.frame.front()) * step_ms);
  const std::string control_class = std::string(kMediaPackage) + "core.StepperClipControl";
  AddNumber(AddObject(AddProperty(panel, "clipcontrol", "object"), control_class), "delta_t", step_ms);
}

void AddCoordinates(pugi::xml_node panel, const PointRecording& points) {
  const std::string coords_class = std::string(kMediaPackage) + "core.ImageCoordSystem";
  const ImageAxes axes = points.axes.value_or(ImageAxes{});
  pugi::xml_node coords = AddObject(AddProperty(panel, "coords", "object"), coords_class);
  for (const char* fixed : {"fixedorigin", "fixedangle", "fixedscale"}) AddText(coords, fixed, "boolean", "true");
  const std::string data_class = coords_class + "$FrameData";
  pugi::xml_node data = AddObject(AddProperty(AddFrames(coords, data_class), "[0]", "object"), data_class);
  AddNumber(data, "xorigin", axes.origin_px.x() + kPixelCentre);
  AddNumber(data, "yorigin", axes.origin_px.y() + kPixelCentre);
  AddNumber(data, "angle", axes.angle_deg);
  for (const char* scale : {"xscale", "yscale"}) AddNumber(data, scale, points.mm_per_px ? 1 / *points.mm_per_px : 1);
  if (points.mm_per_px) AddText(panel, "length_unit", "string", "mm");
}

void AddPointMass(pugi::xml_node tracks, const PointRecording& recording, const PointTrack& point) {
  const std::string mass_class = std::string(kTrackerPackage) + "PointMass", data_class = mass_class + "$FrameData";
  pugi::xml_node mass = AddObject(AddProperty(tracks, "item", "object"), mass_class);
  AddNumber(mass, "mass", 1);
  AddText(mass, "name", "string", point.name);
  for (const char* shown : {"visible", "trail"}) AddText(mass, shown, "boolean", "true");
  pugi::xml_node frames = AddFrames(mass, data_class);
  for (std::size_t i = 0; i < recording.frame.size(); ++i) {
    if (!point.positions[i].allFinite()) continue;
    pugi::xml_node data = AddObject(AddProperty(frames, fmt::format("[{}]", recording.frame[i]), "object"), data_class);
    AddNumber(data, "x", point.positions[i].x() + kPixelCentre);
    AddNumber(data, "y", point.positions[i].y() + kPixelCentre);
  }
}

}  // namespace

// A .trk project, or the first one of a .trz archive: the point masses, in px of the image.
PointRecording ReadTrk(const std::filesystem::path& path, const ReadOptions& /*options*/) {
  const std::string text = Lower(path.extension().string()) == ".trz" ? ReadZipEntry(path, ".trk") : ReadTextFile(path);
  pugi::xml_document document;
  const std::vector<std::string> warnings = ParseXml(text, path, document);
  const pugi::xml_node panel = document.child("object");
  if (!std::string_view(panel.attribute("class").value()).ends_with("TrackerPanel"))
    throw Fail("{}: not a project of Tracker (no TrackerPanel)", path.string());
  std::vector<FramePoints> masses;
  LeftOut left_out;
  for (const pugi::xpath_node found :
       document.select_nodes("//object[contains(@class, 'PointMass') and property[@name='framedata']]"))
    masses.push_back(ReadPointMass(found.node(), path.string(), left_out));
  std::erase_if(masses, [](const FramePoints& mass) { return mass.positions.empty(); });
  PointRecording recording = PointsByFrame(masses, text.size(), path, 0, left_out);
  ReadCoordinates(panel, path.string(), recording);
  ReadTimes(panel, path.string(), recording);
  recording.warnings.insert(recording.warnings.begin(), warnings.begin(), warnings.end());
  return recording;
}

void WriteTrk(const std::filesystem::path& path, const PointRecording& points) {
  if (points.frame.size() < 2)
    throw Fail("{}: a project of Tracker needs two frames for its frame duration", path.string());
  pugi::xml_document document;
  pugi::xml_node panel = AddObject(document, std::string(kTrackerPackage) + "TrackerPanel");
  AddText(panel, "semantic_version", "string", "5.1.5");  // of the format
  if (points.video) {
    AddNumber(panel, "width", points.video->width_px);
    AddNumber(panel, "height", points.video->height_px);
  }
  AddClip(panel, points);
  AddCoordinates(panel, points);
  pugi::xml_node tracks = AddProperty(panel, "tracks", "collection");
  tracks.append_attribute("class") = "java.util.ArrayList";
  for (const PointTrack& point : points.points) AddPointMass(tracks, points, point);
  WriteXml(path, document);
}

}  // namespace lake::exchange
