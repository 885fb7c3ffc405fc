#include "lake/exchange/c3d.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <set>

#include "c3d_bytes.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "text_lines.h"

namespace lake::exchange {
namespace {

// What the header and the parameters say about the points.
struct C3dLayout {
  std::size_t points = 0, frames = 0, first_frame = 0;
  std::size_t analog_per_frame = 0;  // samples of all channels
  std::size_t data_offset = 0;       // bytes
  double scale = -1;                 // < 0: floats
  double rate_hz = 0;
  double mm_per_unit = 1;
  char up_axis = 'z';
  std::vector<std::string> labels;

  bool IsFloat() const { return scale < 0; }
  std::size_t WordBytes() const { return IsFloat() ? 4 : 2; }
  std::size_t FrameBytes() const { return WordBytes() * (4 * points + analog_per_frame); }
};

double MmPerUnit(const std::vector<std::string>& units, const std::string& path) {
  if (units.empty() || units[0].empty()) return 1;
  const std::optional<double> mm_per_unit = FindMmPerUnit(Lower(units[0]));
  if (!mm_per_unit) throw Fail("{}: POINT:UNITS '{}' is not mm, cm or m", path, units[0]);
  return *mm_per_unit;
}

char UpAxis(const std::vector<std::string>& y_screen) {
  const char axis = y_screen.empty() || y_screen[0].empty() ? 'z' : Lower(y_screen[0]).back();
  return axis == 'x' || axis == 'y' ? axis : 'z';
}

std::vector<std::string> ReadLabels(const C3dParameters& parameters, std::size_t points) {
  std::vector<std::string> labels = parameters.Texts("POINT:LABELS");
  labels.resize(points);
  for (std::size_t i = 0; i < points; ++i)
    if (labels[i].empty()) labels[i] = fmt::format("point{}", i + 1);
  return labels;
}

// The header's 16-bit frame numbers, or what longer files say instead.
void ReadFrameCount(const C3dBytes& bytes, const C3dParameters& parameters, C3dLayout& layout) {
  const std::size_t first = bytes.Unsigned16(6), last = bytes.Unsigned16(8);
  layout.first_frame = std::max<std::size_t>(first, 1);
  layout.frames = last >= first ? last - first + 1 : 0;
  const auto field = [&](const char* name) {
    const std::vector<double> words = parameters.Numbers(name);  // two 16-bit words, low first
    return words.size() < 2 ? 0.0 : std::fmod(words[0] + 65536, 65536) + 65536 * std::fmod(words[1] + 65536, 65536);
  };
  if (parameters.Has("TRIAL:ACTUAL_START_FIELD") && parameters.Has("TRIAL:ACTUAL_END_FIELD")) {
    const double start = field("TRIAL:ACTUAL_START_FIELD"), end = field("TRIAL:ACTUAL_END_FIELD");
    if (end >= start && start >= 1) {
      layout.first_frame = static_cast<std::size_t>(start);
      layout.frames = static_cast<std::size_t>(end - start) + 1;
    }
  } else if (parameters.Has("POINT:LONG_FRAMES")) {
    layout.frames = parameters.Count("POINT:LONG_FRAMES");
  } else if (parameters.Has("POINT:FRAMES") && last == 65535) {
    layout.frames = std::max(layout.frames, parameters.Count("POINT:FRAMES"));
  }
}

C3dLayout ReadLayout(const C3dBytes& bytes, const C3dParameters& parameters, const std::string& path) {
  C3dLayout layout;
  layout.points = parameters.Count("POINT:USED");
  if (layout.points == 0) throw Fail("{}: holds no points (POINT:USED is 0)", path);
  layout.analog_per_frame = bytes.Unsigned16(4);
  layout.scale = parameters.Number("POINT:SCALE");
  layout.rate_hz = parameters.Has("POINT:RATE") ? parameters.Number("POINT:RATE") : bytes.Float(20);
  if (!(layout.rate_hz > 0) || !std::isfinite(layout.rate_hz))
    throw Fail("{}: POINT:RATE is {}, not a frame rate", path, layout.rate_hz);
  if (!std::isfinite(layout.scale) || layout.scale == 0) throw Fail("{}: POINT:SCALE is {}", path, layout.scale);
  const double block =
      parameters.Has("POINT:DATA_START") ? parameters.Number("POINT:DATA_START") : bytes.Unsigned16(16);
  if (!(block >= 2 && block <= 65535)) throw Fail("{}: POINT:DATA_START is {}, not a block of the file", path, block);
  layout.data_offset = 512 * (static_cast<std::size_t>(block) - 1);
  const auto texts = [&](const char* name) {
    return parameters.Has(name) ? parameters.Texts(name) : std::vector<std::string>{};
  };
  layout.mm_per_unit = MmPerUnit(texts("POINT:UNITS"), path);
  layout.up_axis = UpAxis(texts("POINT:Y_SCREEN"));
  ReadFrameCount(bytes, parameters, layout);
  if (layout.frames == 0) throw Fail("{}: holds no frames", path);
  if (layout.frames > (bytes.Size() - std::min(bytes.Size(), layout.data_offset)) / layout.FrameBytes())
    throw Fail("{}: too short for {} frames of {} points: is the file cut off?", path, layout.frames, layout.points);
  layout.labels = ReadLabels(parameters, layout.points);
  return layout;
}

Eigen::Vector3d ReadPoint(const C3dBytes& bytes, std::size_t offset, const C3dLayout& layout) {
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
  // Some writers mark a missing point by zeros alone.
  if (residual < 0 || !position.allFinite() || position.isZero(0)) return PointTrack::Missing();
  return position * layout.mm_per_unit;
}

// The header's, with labels of four letters (those of two, without the key, are not read). Their times count from the
// first frame that is stored.
std::vector<PointEvent> ReadHeaderEvents(const C3dBytes& bytes, double first_frame_s) {
  constexpr std::size_t kKey = 298, kCount = 300, kTimes = 304, kLabels = 396;  // bytes
  constexpr std::uint16_t kFourLetterLabels = 12345;
  constexpr std::size_t kMostEvents = 18;
  if (bytes.Unsigned16(kKey) != kFourLetterLabels) return {};
  const std::size_t count = bytes.Unsigned16(kCount);
  if (count > kMostEvents)
    throw Fail("{}: the header says {} events, and holds {} at most", bytes.Path(), count, kMostEvents);
  std::vector<PointEvent> events;
  for (std::size_t i = 0; i < count; ++i)
    events.push_back({first_frame_s + bytes.Float(kTimes + 4 * i), "", bytes.TrimmedText(kLabels + 4 * i, 4)});
  return events;
}

// Those of the group EVENT. Their times count from frame 1.
std::vector<PointEvent> ReadGroupEvents(const C3dParameters& parameters, const std::string& path) {
  const std::size_t count = parameters.Has("EVENT:USED") ? parameters.Count("EVENT:USED") : 0;
  if (count == 0) return {};
  const std::vector<double> times = parameters.Numbers("EVENT:TIMES");  // minutes, seconds
  if (count > times.size() / 2)
    throw Fail("{}: EVENT:USED is {}, but there are {} times", path, count, times.size() / 2);
  const auto texts = [&](const char* name) {
    std::vector<std::string> found = parameters.Has(name) ? parameters.Texts(name) : std::vector<std::string>{};
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
std::vector<PointEvent> ReadEvents(const C3dBytes& bytes, const C3dParameters& parameters, const C3dLayout& layout) {
  std::vector<PointEvent> events = ReadGroupEvents(parameters, bytes.Path());
  const std::size_t of_group = events.size();
  for (PointEvent& event : ReadHeaderEvents(bytes, static_cast<double>(layout.first_frame - 1) / layout.rate_hz)) {
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

void CheckC3dTimes(const std::filesystem::path& path, const std::vector<double>& time_s) {
  const double step_s = 1 / FrameRate(time_s);
  for (std::size_t i = 1; i < time_s.size(); ++i)
    if (std::abs(time_s[i] - time_s[i - 1] - step_s) > 0.05 * step_s)
      throw Fail(
          "{}: C3D has one frame rate, but the time stamps are uneven (at {:.4f} s: {} s after the one before, on "
          "average {} s); export trc instead",
          path.string(), time_s[i], SignificantText(time_s[i] - time_s[i - 1], 4), SignificantText(step_s, 4));
}

PointRecording ReadC3d(const std::filesystem::path& path) {
  const C3dBytes bytes(ReadTextFile(path), path.string());
  const C3dParameters parameters(bytes);
  const C3dLayout layout = ReadLayout(bytes, parameters, path.string());
  PointRecording recording;
  recording.up_axis = layout.up_axis;
  try {
    recording.events = ReadEvents(bytes, parameters, layout);
  } catch (const Error& error) {
    recording.warnings.push_back(fmt::format("{}; the file's events are left out", error.what()));
  }
  AddPoints(layout.labels, path.string(), recording);
  for (std::size_t i = 0; i < layout.frames; ++i) {
    recording.frame.push_back(static_cast<std::int64_t>(layout.first_frame - 1 + i));
    recording.time_s.push_back(static_cast<double>(layout.first_frame - 1 + i) / layout.rate_hz);
    for (std::size_t p = 0; p < layout.points; ++p)
      recording.points[p].positions.push_back(
          ReadPoint(bytes, layout.data_offset + i * layout.FrameBytes() + 4 * p * layout.WordBytes(), layout));
  }
  return recording;
}

namespace {

// The analogue channels: every sample of a frame has one value of each.
struct AnalogLayout {
  std::size_t channels = 0, samples = 0;  // of each frame
  std::vector<double> scale, offset;      // of each channel: (stored − offset) × scale
  bool is_unsigned = false;               // 16-bit words without a sign
};

AnalogLayout ReadAnalogLayout(const C3dParameters& parameters, const C3dLayout& layout, const std::string& path) {
  AnalogLayout analog;
  analog.channels = parameters.Has("ANALOG:USED") ? parameters.Count("ANALOG:USED") : 0;
  if (analog.channels == 0 || layout.analog_per_frame == 0 || layout.analog_per_frame % analog.channels != 0)
    throw Fail("{}: no analogue channels, and so no forces", path);
  analog.samples = layout.analog_per_frame / analog.channels;
  analog.scale = parameters.Numbers("ANALOG:SCALE");
  analog.offset = parameters.Numbers("ANALOG:OFFSET");
  if (analog.scale.size() < analog.channels || analog.offset.size() < analog.channels)
    throw Fail("{}: ANALOG:SCALE or OFFSET has fewer values than the {} channels", path, analog.channels);
  const double general = parameters.Has("ANALOG:GEN_SCALE") ? parameters.Number("ANALOG:GEN_SCALE") : 1;
  for (double& scale : analog.scale) scale *= general;
  if (parameters.Has("ANALOG:FORMAT")) {
    const std::vector<std::string> format = parameters.Texts("ANALOG:FORMAT");
    analog.is_unsigned = !format.empty() && Lower(format[0]) == "unsigned";
  }
  return analog;
}

// A plate: its channels (from 0), where it lies, and what its channels are multiplied with.
struct C3dPlate {
  std::array<std::size_t, 6> channel = {};
  Eigen::Matrix3d lab_from_plate;
  Eigen::Vector3d origin_m;  // of its moments, in the laboratory
  double m_per_moment = 1;   // newton metres per unit of its moments
  Eigen::Matrix<double, 6, 6> calibration = Eigen::Matrix<double, 6, 6>::Identity();
};

C3dPlate ReadPlate(const C3dParameters& parameters, const C3dLayout& layout, const AnalogLayout& analog,
                   std::size_t index, const std::string& path) {
  const auto numbers = [&](const char* name, std::size_t of_each) {
    const std::vector<double> all = parameters.Numbers(fmt::format("FORCE_PLATFORM:{}", name));
    if (all.size() < (index + 1) * of_each)
      throw Fail("{}: FORCE_PLATFORM:{} has {} values, too few for plate {}", path, name, all.size(), index + 1);
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(index * of_each);
    return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(of_each));
  };
  const double type = numbers("TYPE", 1)[0];
  if (type != 2 && type != 4)
    throw Fail("{}: force plate {} is of type {}; types 2 and 4 are read", path, index + 1, type);
  C3dPlate plate;
  const std::vector<double> channels = numbers("CHANNEL", 6);
  for (std::size_t i = 0; i < 6; ++i) {
    if (!(channels[i] >= 1 && channels[i] <= static_cast<double>(analog.channels)))
      throw Fail("{}: force plate {} has channel {}, of {}", path, index + 1, channels[i], analog.channels);
    plate.channel[i] = static_cast<std::size_t>(channels[i]) - 1;
  }
  const double m_per_unit = layout.mm_per_unit / 1000;
  const std::vector<double> corners = numbers("CORNERS", 12);
  const auto corner = [&](std::size_t i) { return Eigen::Vector3d(&corners[3 * i]); };
  // Seen in the plate's axes the corners are (+,+), (−,+), (−,−), (+,−).
  const Eigen::Vector3d x = (corner(0) + corner(3) - corner(1) - corner(2)).normalized(),
                        z = x.cross(corner(0) + corner(1) - corner(2) - corner(3)).normalized();
  plate.lab_from_plate << x, z.cross(x), z;
  if (!(plate.lab_from_plate.determinant() > 0.5))  // 1 of a plate; a vector of no length stays one
    throw Fail("{}: force plate {} has no corners, or they lie in one line", path, index + 1);
  const std::vector<double> origin = numbers("ORIGIN", 3);
  // From the middle of the surface to the origin, which lies below it; some writers have the opposite sign.
  Eigen::Vector3d below(origin.data());
  const Eigen::Vector3d up = Eigen::Vector3d::Unit(layout.up_axis - 'x');
  if (up.dot(plate.lab_from_plate * below) > 0) below = -below;
  plate.origin_m = m_per_unit * ((corner(0) + corner(1) + corner(2) + corner(3)) / 4 + plate.lab_from_plate * below);
  if (parameters.Has("ANALOG:UNITS")) {
    const std::vector<std::string> units = parameters.Texts("ANALOG:UNITS");
    if (plate.channel[3] < units.size() && Lower(units[plate.channel[3]]).ends_with("mm")) plate.m_per_moment = 1e-3;
  }
  if (type == 4) {
    const std::vector<double> matrix = numbers("CAL_MATRIX", 36);
    plate.calibration = Eigen::Map<const Eigen::Matrix<double, 6, 6>>(matrix.data());  // by columns, as stored
  }
  return plate;
}

}  // namespace

GroundForceRecording ReadC3dForces(const std::filesystem::path& path) {
  const C3dBytes bytes(ReadTextFile(path), path.string());
  const C3dParameters parameters(bytes);
  const C3dLayout layout = ReadLayout(bytes, parameters, path.string());
  const std::size_t count = parameters.Has("FORCE_PLATFORM:USED") ? parameters.Count("FORCE_PLATFORM:USED") : 0;
  if (count == 0) throw Fail("{}: no force plates (FORCE_PLATFORM:USED)", path.string());
  const AnalogLayout analog = ReadAnalogLayout(parameters, layout, path.string());
  const auto value = [&](std::size_t frame, std::size_t sample, std::size_t channel) {
    const std::size_t at = layout.data_offset + frame * layout.FrameBytes() +
                           layout.WordBytes() * (4 * layout.points + sample * analog.channels + channel);
    const double stored = layout.IsFloat()     ? bytes.Float(at)
                          : analog.is_unsigned ? bytes.Unsigned16(at)
                                               : bytes.Signed16(at);
    return (stored - analog.offset[channel]) * analog.scale[channel];
  };
  GroundForceRecording forces;
  forces.up_axis = layout.up_axis;
  const int up = layout.up_axis - 'x';
  for (std::size_t frame = 0; frame < layout.frames; ++frame)
    for (std::size_t sample = 0; sample < analog.samples; ++sample)
      forces.time_s.push_back((static_cast<double>(layout.first_frame - 1 + frame) +
                               static_cast<double>(sample) / static_cast<double>(analog.samples)) /
                              layout.rate_hz);
  for (std::size_t index = 0; index < count; ++index) {
    const C3dPlate plate = ReadPlate(parameters, layout, analog, index, path.string());
    PlateForces& read = forces.plates.emplace_back();
    read.name = fmt::format("plate {}", index + 1);
    double upward_n = 0;
    for (std::size_t frame = 0; frame < layout.frames; ++frame)
      for (std::size_t sample = 0; sample < analog.samples; ++sample) {
        Eigen::Matrix<double, 6, 1> six;
        for (std::size_t i = 0; i < 6; ++i) six[static_cast<Eigen::Index>(i)] = value(frame, sample, plate.channel[i]);
        six = plate.calibration * six;
        read.force_n.push_back(plate.lab_from_plate * six.head<3>());
        read.moment_nm.push_back(plate.m_per_moment * (plate.lab_from_plate * six.tail<3>()));
        read.point_m.push_back(plate.origin_m);
        upward_n += read.force_n.back()[up];
      }
    if (upward_n < 0)
      for (std::size_t i = 0; i < read.force_n.size(); ++i) {
        read.force_n[i] *= -1;
        read.moment_nm[i] *= -1;
      }
  }
  return forces;
}

namespace {

void CheckWritable(const std::filesystem::path& path, const PointRecording& points) {
  if (points.space == PointSpace::kImage)
    throw Fail("{}: C3D is in mm, and these positions in px: give --scale, or a --camera with the sagittal plane",
               path.string());
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
  std::vector<std::array<float, 2>> times;  // minutes, seconds
  for (const PointEvent& event : points.events) {
    const double time_s = event.time_s + shift_s, minutes = std::floor(time_s / 60);
    contexts.push_back(ShortText(event.context));
    labels.push_back(ShortText(event.label));
    times.push_back({static_cast<float>(minutes), static_cast<float>(time_s - 60 * minutes)});
  }
  writer.Group(4, "EVENT");
  writer.Word(4, "USED", points.events.size());
  if (points.events.empty()) return;
  writer.Texts(4, "CONTEXTS", contexts);
  writer.Texts(4, "LABELS", labels);
  writer.Pairs(4, "TIMES", times);
  const std::set<std::string> distinct(contexts.begin(), contexts.end());
  writer.Group(5, "EVENT_CONTEXT");
  writer.Word(5, "USED", distinct.size());
  writer.Texts(5, "LABELS", {distinct.begin(), distinct.end()});
}

C3dParameterWriter MakeParameters(const PointRecording& points) {
  const std::size_t count = points.points.size(), frames = points.time_s.size();
  C3dParameterWriter writer;
  writer.Group(1, "POINT");
  writer.Word(1, "USED", count);
  writer.Word(1, "FRAMES", std::min<std::size_t>(frames, 65535));
  writer.Float(1, "SCALE", -1);
  writer.Float(1, "RATE", static_cast<float>(FrameRate(points.time_s)));
  writer.Texts(1, "UNITS", {"mm"});
  writer.Texts(1, "X_SCREEN", {"+X"});
  writer.Texts(1, "Y_SCREEN",
               {std::string("+") + static_cast<char>(std::toupper(static_cast<unsigned char>(points.up_axis)))});
  std::vector<std::string> labels;
  for (const PointTrack& point : points.points) labels.push_back(point.name);
  writer.Texts(1, "LABELS", labels);
  writer.Group(2, "ANALOG");
  writer.Word(2, "USED", 0);
  writer.Group(3, "TRIAL");
  const std::size_t first = FirstFrame(points), last = first + frames - 1;
  writer.Words(3, "ACTUAL_START_FIELD", {first & 0xFFFF, first >> 16});
  writer.Words(3, "ACTUAL_END_FIELD", {last & 0xFFFF, last >> 16});
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
