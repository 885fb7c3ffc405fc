#include "lake/exchange/c3d.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "c3d_bytes.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::exchange {
namespace {

// Where three values and a residual are stored; a negative residual marks a missing point, also as a word without a
// sign, and so do, for some writers, zeros alone where they are positions.
Eigen::Vector3d ReadPoint(const C3dBytes& bytes, std::size_t offset, const C3dLayout& layout, bool is_position) {
  Eigen::Vector3d position;
  double residual = 0;
  if (layout.IsFloat()) {
    for (std::size_t axis = 0; axis < 3; ++axis) position[static_cast<int>(axis)] = bytes.Float(offset + 4 * axis);
    residual = bytes.Float(offset + 12);
  } else {
    for (std::size_t axis = 0; axis < 3; ++axis)
      position[static_cast<int>(axis)] = layout.scale * bytes.Signed16(offset + 2 * axis);
    residual = bytes.Signed16(offset + 6);
  }
  constexpr double kSignBit = 32768;
  if (residual < 0 || residual >= kSignBit || !position.allFinite() || (is_position && position.isZero(0)))
    return PointTrack::Missing();
  return is_position ? Eigen::Vector3d(position * layout.mm_per_unit) : position;
}

// What a model works out from the markers is stored as points are, and named in these parameters of the group POINT.
struct OutputKind {
  const char *names, *units, *what;
};
constexpr OutputKind kOutputKinds[] = {{"ANGLES", "ANGLE_UNITS", "angle"},    {"MOMENTS", "MOMENT_UNITS", "moment"},
                                       {"FORCES", "FORCE_UNITS", "force"},    {"POWERS", "POWER_UNITS", "power"},
                                       {"SCALARS", "SCALAR_UNITS", "scalar"}, {"REACTIONS", "", "reaction"}};

// The kind of each point: none of a marker. Names may stand there with the subject's, as "SUBJECT:LKneeAngles".
std::vector<const OutputKind*> KindsOf(const C3dParameters& parameters, const std::vector<std::string>& labels) {
  std::vector<const OutputKind*> kinds(labels.size(), nullptr);
  for (const OutputKind& kind : kOutputKinds)
    for (const std::string& name : parameters.Texts(std::string("POINT:") + kind.names))
      for (std::size_t p = 0; p < labels.size(); ++p)
        if (!name.empty() && (labels[p] == name || labels[p].ends_with(":" + name))) kinds[p] = &kind;
  return kinds;
}

// The header's, with labels of four letters (those of two, without the key, are not read). Their times count from the
// first frame that is stored.
std::vector<PointEvent> ReadHeaderEvents(const C3dBytes& bytes, double first_frame_s,
                                         std::vector<std::string>& warnings) {
  constexpr std::size_t kKey = 298, kCount = 300, kTimes = 304, kLabels = 396;  // bytes
  constexpr std::uint16_t kFourLetterLabels = 12345;
  constexpr std::size_t kMostEvents = 18;
  if (bytes.Unsigned16(kKey) != kFourLetterLabels) return {};
  const std::size_t count = bytes.Unsigned16(kCount);
  if (count > kMostEvents)
    warnings.push_back(fmt::format("{}: the header says {} events, and has room for {}: they are left out",
                                   bytes.Path(), count, kMostEvents));
  std::vector<PointEvent> events;
  for (std::size_t i = 0; i < count && count <= kMostEvents; ++i)
    events.push_back({first_frame_s + bytes.Float(kTimes + 4 * i), "", bytes.TrimmedText(kLabels + 4 * i, 4)});
  return events;
}

// Those of the group EVENT. Their times count from frame 1.
std::vector<PointEvent> ReadGroupEvents(const C3dParameters& parameters, const std::string& path) {
  const std::size_t count = parameters.Count("EVENT:USED").value_or(0);
  if (count == 0) return {};
  const std::vector<double> times = parameters.Numbers("EVENT:TIMES");  // minutes, seconds
  if (count > times.size() / 2)
    throw Fail("{}: EVENT:USED is {}, but there are {} times", path, count, times.size() / 2);
  const auto texts = [&](const char* name) {
    std::vector<std::string> found = parameters.Texts(name);
    found.resize(count);
    return found;
  };
  const std::vector<std::string> contexts = texts("EVENT:CONTEXTS"), labels = texts("EVENT:LABELS");
  std::vector<PointEvent> events;
  for (std::size_t i = 0; i < count; ++i)
    events.push_back({60 * times[2 * i] + times[2 * i + 1], contexts[i], labels[i]});
  return events;
}

// Both, in order of time; the header may say again what the group says.
std::vector<PointEvent> ReadEvents(const C3dBytes& bytes, const C3dParameters& parameters, const C3dLayout& layout,
                                   std::vector<std::string>& warnings) {
  std::vector<PointEvent> events = ReadGroupEvents(parameters, bytes.Path());
  const std::size_t of_group = events.size();
  const double first_frame_s = static_cast<double>(layout.first_frame - 1) / layout.rate_hz;
  for (PointEvent& event : ReadHeaderEvents(bytes, first_frame_s, warnings)) {
    const auto end = events.begin() + static_cast<std::ptrdiff_t>(of_group);
    const bool known = std::any_of(events.begin(), end, [&](const PointEvent& other) {
      return std::abs(other.time_s - event.time_s) < 0.5 / layout.rate_hz;
    });
    if (!known) events.push_back(std::move(event));
  }
  for (const PointEvent& event : events)
    if (!std::isfinite(event.time_s)) throw Fail("{}: event '{}' has no time", bytes.Path(), event.label);
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
  return events;
}

}  // namespace

std::vector<PointEvent> PointEvents(const std::vector<motion::StsEvent>& events, motion::Side leg) {
  using enum motion::StsEventKind;
  std::vector<PointEvent> points;
  for (const motion::StsEvent& event : events) {
    const bool is_other = event.kind == kHeelStrikeOther || event.kind == kToeOffOther;
    const bool is_strike = event.kind == kHeelStrike || event.kind == kHeelStrikeOther;
    if (event.kind < kHeelStrike)
      points.push_back({event.time_s, "General", std::string(ToString(event.kind))});
    else
      points.push_back({event.time_s, (leg == motion::Side::kLeft) == is_other ? "Right" : "Left",
                        is_strike ? "Foot Strike" : "Foot Off"});
  }
  return points;
}

void CheckC3dTimes(const std::filesystem::path& path, const std::vector<double>& time_s) {
  const double step_s = 1 / FrameRate(time_s);
  for (std::size_t i = 1; i < time_s.size(); ++i)
    if (std::abs(time_s[i] - time_s[i - 1] - step_s) > 0.05 * step_s)
      throw Fail(
          "{}: C3D has one frame rate, but the time stamps are uneven (at {:.4f} s: {} s after the one before, on "
          "average {} s); export trc instead",
          path.string(), time_s[i], SignificantText(time_s[i] - time_s[i - 1], 4), SignificantText(step_s, 4));
}

bool IsC3dWithoutPoints(const std::filesystem::path& path) {
  const C3dBytes bytes(ReadTextFile(path), path.string());
  return ReadLayout(bytes, C3dParameters(bytes)).points == 0;
}

PointRecording ReadC3d(const std::filesystem::path& path, const ReadOptions& /*options*/) {
  const C3dBytes bytes(ReadTextFile(path), path.string());
  const C3dParameters parameters(bytes);
  const C3dLayout layout = ReadLayout(bytes, parameters);
  PointRecording recording;
  recording.up_axis = layout.up_axis;
  recording.warnings = layout.warnings;
  try {
    recording.events = ReadEvents(bytes, parameters, layout, recording.warnings);
  } catch (const Error& error) {
    recording.warnings.push_back(fmt::format("{}; the file's events are left out", error.what()));
  }
  const std::vector<const OutputKind*> kinds = KindsOf(parameters, layout.labels);
  std::vector<std::string> markers;
  for (std::size_t p = 0; p < layout.points; ++p)
    if (!kinds[p]) markers.push_back(layout.labels[p]);
  if (markers.empty())
    throw Fail("{}: holds no markers, only {} analogue samples a frame and {} outputs of a model (--forces, lake sync)",
               path.string(), layout.analog_per_frame, layout.points);
  AddPoints(std::move(markers), path.string(), recording);
  for (std::size_t i = 0; i < layout.frames; ++i) {
    recording.frame.push_back(static_cast<std::int64_t>(layout.first_frame - 1 + i));
    recording.time_s.push_back(static_cast<double>(layout.first_frame - 1 + i) / layout.rate_hz);
  }
  auto marker = recording.points.begin();
  for (std::size_t p = 0; p < layout.points; ++p) {
    std::vector<Eigen::Vector3d> values;
    for (std::size_t i = 0; i < layout.frames; ++i)
      values.push_back(ReadPoint(bytes, layout.data_offset + i * layout.FrameBytes() + 4 * p * layout.WordBytes(),
                                 layout, !kinds[p]));
    if (!kinds[p]) {
      (marker++)->positions = std::move(values);
      continue;
    }
    const std::vector<std::string> units = parameters.Texts(std::string("POINT:") + kinds[p]->units);
    recording.outputs.push_back({{layout.labels[p], std::move(values)}, kinds[p]->what, units.empty() ? "" : units[0]});
  }
  return recording;
}

namespace {

void CheckWritable(const std::filesystem::path& path, const PointRecording& points) {
  constexpr std::size_t kMostPoints = 65535;
  if (points.points.empty() || points.points.size() > kMostPoints)
    throw Fail("{}: C3D holds 1 to {} points, not {}", path.string(), kMostPoints, points.points.size());
  if (points.time_s.size() < 2) throw Fail("{}: C3D needs at least two frames for its rate", path.string());
  CheckC3dTimes(path, points.time_s);
}

// The number that the format counts the first frame by: from 1, at time 0.
std::size_t FirstFrame(const PointRecording& points) {
  const double frames = points.time_s.front() * FrameRate(points.time_s);
  return frames > 0 && frames < 65534 ? static_cast<std::size_t>(std::llround(frames)) + 1 : 1;
}

// At most 127 bytes of an event's text, which is what a parameter holds; no letter is cut in two.
std::string ShortText(std::string text) {
  constexpr std::size_t kMost = 127;
  if (text.size() <= kMost) return text;
  std::size_t end = kMost;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  text.resize(end);
  return text;
}

// The groups EVENT and EVENT_CONTEXT. Points have whole frames for times; the events move with them.
void AddEvents(const PointRecording& points, C3dParameterWriter& writer) {
  const double shift_s = static_cast<double>(FirstFrame(points) - 1) / FrameRate(points.time_s) - points.time_s.front();
  std::vector<std::string> contexts, labels;
  std::vector<double> times;  // minutes, seconds
  for (const PointEvent& event : points.events) {
    const double time_s = event.time_s + shift_s, minutes = std::floor(time_s / 60);
    contexts.push_back(ShortText(event.context));
    labels.push_back(ShortText(event.label));
    times.insert(times.end(), {minutes, time_s - 60 * minutes});
  }
  writer.Group(4, "EVENT");
  writer.Number(4, "USED", C3dParameterWriter::kWord, static_cast<double>(points.events.size()));
  if (points.events.empty()) return;
  writer.Texts(4, "CONTEXTS", contexts);
  writer.Texts(4, "LABELS", labels);
  writer.Numbers(4, "TIMES", C3dParameterWriter::kFloat, times, 2);
  const std::set<std::string> distinct(contexts.begin(), contexts.end());
  writer.Group(5, "EVENT_CONTEXT");
  writer.Number(5, "USED", C3dParameterWriter::kWord, static_cast<double>(distinct.size()));
  writer.Texts(5, "LABELS", {distinct.begin(), distinct.end()});
}

C3dParameterWriter MakeParameters(const PointRecording& points) {
  const std::size_t count = points.points.size(), frames = points.time_s.size();
  C3dParameterWriter writer;
  writer.Group(1, "POINT");
  writer.Number(1, "USED", C3dParameterWriter::kWord, static_cast<double>(count));
  writer.Number(1, "FRAMES", C3dParameterWriter::kWord, static_cast<double>(std::min<std::size_t>(frames, 65535)));
  writer.Number(1, "SCALE", C3dParameterWriter::kFloat, -1);
  writer.Number(1, "RATE", C3dParameterWriter::kFloat, FrameRate(points.time_s));
  writer.Texts(1, "UNITS", {"mm"});
  writer.Texts(1, "X_SCREEN", {"+X"});
  writer.Texts(1, "Y_SCREEN",
               {std::string("+") + static_cast<char>(std::toupper(static_cast<unsigned char>(points.up_axis)))});
  std::vector<std::string> labels;
  for (const PointTrack& point : points.points) labels.push_back(point.name);
  writer.Texts(1, "LABELS", labels);
  writer.Group(2, "ANALOG");
  writer.Number(2, "USED", C3dParameterWriter::kWord, 0);
  writer.Group(3, "TRIAL");
  const std::size_t first = FirstFrame(points), last = first + frames - 1;
  for (const auto& [name, frame] : {std::pair{"ACTUAL_START_FIELD", first}, {"ACTUAL_END_FIELD", last}})
    writer.Numbers(3, name, C3dParameterWriter::kWord,
                   {static_cast<double>(frame & 0xFFFF), static_cast<double>(frame >> 16)});
  AddEvents(points, writer);
  return writer;
}

}  // namespace

void WriteC3d(const std::filesystem::path& path, const PointRecording& points) {
  CheckWritable(path, points);
  C3dParameterWriter parameters = MakeParameters(points);
  const std::string section = parameters.Finish(1, "DATA_START");
  const std::size_t data_block = 2 + section.size() / 512, frames = points.time_s.size(), first = FirstFrame(points);
  C3dBuffer file;
  file.Byte(2)
      .Byte(0x50)
      .Word(points.points.size())
      .Word(0)
      .Word(first)
      .Word(std::min<std::size_t>(first + frames - 1, 65535))
      .Word(10);
  file.Float(-1).Word(data_block).Word(0).Float(static_cast<float>(FrameRate(points.time_s))).PadTo(512);
  file.Append(section);
  for (std::size_t i = 0; i < frames; ++i)
    for (const PointTrack& point : points.points) {
      const bool known = point.positions[i].allFinite();
      for (int axis = 0; axis < 3; ++axis) file.Float(known ? static_cast<float>(point.positions[i][axis]) : 0);
      file.Float(known ? 0 : -1);
    }
  file.PadTo((file.Size() + 511) / 512 * 512);
  WriteTextFile(path, file.Bytes());
}

}  // namespace lake::exchange
