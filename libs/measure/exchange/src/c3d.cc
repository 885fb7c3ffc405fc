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
  std::vector<std::string> warnings;

  bool IsFloat() const { return scale < 0; }
  std::size_t WordBytes() const { return IsFloat() ? 4 : 2; }
  std::size_t FrameBytes() const { return WordBytes() * (4 * points + analog_per_frame); }
};

// A 16-bit word that was read with a sign, where it has none.
double Unsigned(double word) {
  return word < 0 ? word + 65536 : word;
}

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
  std::vector<std::string> labels =
      parameters.Has("POINT:LABELS") ? parameters.Texts("POINT:LABELS") : std::vector<std::string>{};
  labels.resize(points);
  for (std::size_t i = 0; i < points; ++i)
    if (labels[i].empty()) labels[i] = fmt::format("point{}", i + 1);
  return labels;
}

// A size as one place of the file states it.
template <typename Value>
struct Stated {
  const char* where;
  Value value;
};

// The first of each distinct value, in order.
template <typename Value>
std::vector<Value> DistinctValues(const std::vector<Stated<Value>>& stated) {
  std::vector<Value> distinct;
  for (const Stated<Value>& each : stated)
    if (std::find(distinct.begin(), distinct.end(), each.value) == distinct.end()) distinct.push_back(each.value);
  return distinct;
}

template <typename Value>
std::ptrdiff_t CountOf(const std::vector<Stated<Value>>& stated, const Value& value) {
  return std::count_if(stated.begin(), stated.end(), [&](const auto& each) { return each.value == value; });
}

struct FrameNumbers {
  std::size_t first = 1, count = 0;
  bool operator==(const FrameNumbers&) const = default;
};

// All that the file states about the place of its data; what cannot be (a size of 0) is left out where another place
// states it.
struct StatedSizes {
  std::vector<Stated<std::size_t>> points, analog, block;
  std::vector<Stated<double>> scale;
  std::vector<Stated<FrameNumbers>> frames;  // in the order in which they are believed
};

// Samples of all analogue channels in a frame: by the header, and by the channels and their rate.
std::vector<Stated<std::size_t>> StatedAnalog(const C3dBytes& bytes, const C3dParameters& parameters, double rate_hz) {
  std::vector<Stated<std::size_t>> stated = {{"the header", bytes.Unsigned16(4)}};
  if (!parameters.Has("ANALOG:USED")) return stated;
  const std::size_t channels = parameters.Count("ANALOG:USED"), samples = bytes.Unsigned16(18);
  if (channels == 0) {
    stated.push_back({"ANALOG:USED", 0});
    return stated;
  }
  if (samples > 0) stated.push_back({"ANALOG:USED and the header's samples of a frame", channels * samples});
  const double ratio = parameters.Has("ANALOG:RATE") ? parameters.Number("ANALOG:RATE") / rate_hz : 0;
  constexpr double kMost = 65535;
  if (ratio >= 0.5 && ratio < kMost)
    stated.push_back({"ANALOG:USED and ANALOG:RATE", channels * static_cast<std::size_t>(std::lround(ratio))});
  return stated;
}

// Two 16-bit words, low first; 0 where there are none.
double LongWord(const C3dParameters& parameters, const char* name) {
  if (!parameters.Has(name)) return 0;
  const std::vector<double> words = parameters.Numbers(name);
  return words.size() < 2 ? 0.0 : Unsigned(words[0]) + 65536 * Unsigned(words[1]);
}

std::vector<Stated<FrameNumbers>> StatedFrames(const C3dBytes& bytes, const C3dParameters& parameters) {
  std::vector<Stated<FrameNumbers>> stated;
  const std::size_t first = std::max<std::size_t>(bytes.Unsigned16(6), 1), last = bytes.Unsigned16(8);
  const double start = LongWord(parameters, "TRIAL:ACTUAL_START_FIELD"),
               end = LongWord(parameters, "TRIAL:ACTUAL_END_FIELD");
  if (end >= start && start >= 1)
    stated.push_back(
        {"TRIAL:ACTUAL_END_FIELD", {static_cast<std::size_t>(start), static_cast<std::size_t>(end - start) + 1}});
  if (parameters.Has("POINT:LONG_FRAMES"))
    stated.push_back({"POINT:LONG_FRAMES", {first, parameters.Count("POINT:LONG_FRAMES")}});
  if (last >= first) stated.push_back({"the header", {first, last - first + 1}});
  if (parameters.Has("POINT:FRAMES")) stated.push_back({"POINT:FRAMES", {first, parameters.Count("POINT:FRAMES")}});
  std::erase_if(stated, [](const auto& each) { return each.value.count == 0; });
  if (stated.empty()) stated.push_back({"the header", {first, 0}});
  return stated;
}

StatedSizes ReadStatedSizes(const C3dBytes& bytes, const C3dParameters& parameters, double rate_hz) {
  StatedSizes stated;
  if (parameters.Has("POINT:USED")) stated.points.push_back({"POINT:USED", parameters.Count("POINT:USED")});
  stated.points.push_back({"the header", bytes.Unsigned16(2)});
  std::erase_if(stated.points, [](const auto& each) { return each.value == 0; });
  if (stated.points.empty()) throw Fail("{}: holds no points (POINT:USED is 0)", bytes.Path());
  if (parameters.Has("POINT:SCALE")) stated.scale.push_back({"POINT:SCALE", parameters.Number("POINT:SCALE")});
  stated.scale.push_back({"the header", bytes.Float(12)});
  const double first_scale = stated.scale.front().value;
  constexpr double kLeastScale = 1e-6;  // 16 bits would hold a thirtieth of a millimetre
  std::erase_if(stated.scale, [](const Stated<double>& each) {
    return !std::isfinite(each.value) || std::abs(each.value) < kLeastScale;
  });
  for (Stated<double>& each : stated.scale)
    if (each.value < 0) each.value = -1;  // floats, which are not scaled
  if (stated.scale.empty()) throw Fail("{}: POINT:SCALE is {}", bytes.Path(), first_scale);
  constexpr double kMostBlocks = 65535;
  double block = bytes.Unsigned16(16);
  const auto add_block = [&](const char* where) {
    if (block >= 2 && block <= kMostBlocks) stated.block.push_back({where, static_cast<std::size_t>(block)});
  };
  add_block("the header");
  if (parameters.Has("POINT:DATA_START")) {
    block = parameters.Number("POINT:DATA_START");
    add_block("POINT:DATA_START");
  }
  std::reverse(stated.block.begin(), stated.block.end());
  if (stated.block.empty()) throw Fail("{}: POINT:DATA_START is {}, not a block of the file", bytes.Path(), block);
  stated.analog = StatedAnalog(bytes, parameters, rate_hz);
  stated.frames = StatedFrames(bytes, parameters);
  return stated;
}

// Where the data lie if one statement on each size is right, and how many statements agree with it.
struct Geometry {
  std::size_t points = 0, analog = 0, block = 0;
  double scale = -1;
  std::ptrdiff_t agreeing = 0;

  std::size_t FrameBytes() const { return (scale < 0 ? 4 : 2) * (4 * points + analog); }
  std::size_t Available(std::size_t size) const { return size - std::min(size, 512 * (block - 1)); }
  // A file ends with the block of its last frame.
  bool Fills(std::size_t frames, std::size_t size) const {
    const std::size_t available = Available(size);
    return frames <= available / FrameBytes() && available - frames * FrameBytes() < 512;
  }
};

std::vector<Geometry> GeometriesOf(const StatedSizes& stated) {
  std::vector<Geometry> geometries;
  for (const std::size_t points : DistinctValues(stated.points))
    for (const std::size_t analog : DistinctValues(stated.analog))
      for (const std::size_t block : DistinctValues(stated.block))
        for (const bool is_float : {true, false}) {
          const auto scale = std::find_if(stated.scale.begin(), stated.scale.end(),
                                          [&](const auto& each) { return (each.value < 0) == is_float; });
          if (scale == stated.scale.end()) continue;
          const auto alike = std::count_if(stated.scale.begin(), stated.scale.end(),
                                           [&](const auto& each) { return (each.value < 0) == is_float; });
          geometries.push_back(
              {points, analog, block, scale->value,
               CountOf(stated.points, points) + CountOf(stated.analog, analog) + CountOf(stated.block, block) + alike});
        }
  return geometries;
}

// Zeros that fill the last block of a file look like frames.
std::size_t EmptyAtTheEnd(const C3dBytes& bytes, const Geometry& geometry) {
  const std::size_t frame = geometry.FrameBytes(), end = geometry.Available(bytes.Size()) / frame * frame;
  std::size_t empty = 0;
  const auto is_empty = [&] {
    const std::size_t at = 512 * (geometry.block - 1) + end - (empty + 1) * frame;
    return bytes.Text(at, frame).find_first_not_of('\0') == std::string::npos;
  };
  while (empty < 511 / frame && is_empty()) ++empty;
  return empty;
}

// As many frames as are stated, or as 16 bits cut that number down: to 65535, or by a multiple of 65536.
std::size_t FramesFilling(const C3dBytes& bytes, const Geometry& geometry, const FrameNumbers& stated) {
  constexpr std::size_t kMost = 65535;
  const std::size_t size = bytes.Size();
  if (geometry.Fills(stated.count, size)) return stated.count;
  const std::size_t held = geometry.Available(size) / geometry.FrameBytes();
  if (held <= kMost) return 0;
  if (stated.count == kMost || stated.first + stated.count - 1 == kMost) return held - EmptyAtTheEnd(bytes, geometry);
  const std::size_t wrapped = held - (held - stated.count) % (kMost + 1);
  return stated.count <= held && geometry.Fills(wrapped, size) ? wrapped : 0;
}

template <typename Value>
std::string StatedText(const char* what, const std::vector<Stated<Value>>& stated) {
  std::string text;
  if (DistinctValues(stated).size() < 2) return text;
  for (const Stated<Value>& each : stated)
    text += fmt::format("{}{} by {}", text.empty() ? "" : ", ", each.value, each.where);
  return fmt::format("{}: {}; ", what, text);
}

std::string Contradictions(const StatedSizes& stated) {
  return StatedText("points", stated.points) + StatedText("analogue samples of a frame", stated.analog) +
         StatedText("first block of data", stated.block) + StatedText("scale", stated.scale);
}

// Where the frames are others than those that are believed first.
std::string FrameContradiction(const StatedSizes& stated, const FrameNumbers& read) {
  const Stated<FrameNumbers>& first = stated.frames.front();
  if (read.count == first.value.count) return "";
  return fmt::format("frames: {} by {}, {} in the file; ", first.value.count, first.where, read.count);
}

// The file states its sizes in its header and in its parameters. Where these differ, those hold with which the frames
// end in the file's last block; among several of them what most places state.
void ReadSizes(const StatedSizes& stated, const C3dBytes& bytes, C3dLayout& layout) {
  const std::vector<Geometry> all = GeometriesOf(stated);
  std::vector<std::pair<Geometry, FrameNumbers>> possible;
  for (const Geometry& geometry : all)
    for (const Stated<FrameNumbers>& frames : stated.frames)
      if (const std::size_t count = FramesFilling(bytes, geometry, frames.value)) {
        possible.push_back({geometry, {frames.value.first, count}});
        break;
      }
  const bool is_filled = !possible.empty();
  const FrameNumbers& believed = stated.frames.front().value;
  if (!is_filled)  // something else lies behind the data
    for (const Geometry& geometry : all)
      if (believed.count <= geometry.Available(bytes.Size()) / geometry.FrameBytes())
        possible.push_back({geometry, believed});
  const auto fewer = [](const auto& a, const auto& b) { return a.first.agreeing < b.first.agreeing; };
  const auto best = std::max_element(possible.begin(), possible.end(), fewer);
  if (best == possible.end())
    throw Fail("{}: too short for {} frames of {} points: is the file cut off?", bytes.Path(), believed.count,
               stated.points.front().value);
  const auto equals = std::count_if(possible.begin(), possible.end(),
                                    [&](const auto& other) { return other.first.agreeing == best->first.agreeing; });
  const std::string contradictions = Contradictions(stated) + FrameContradiction(stated, best->second);
  if (equals > 1)
    throw Fail("{}: contradicts itself ({}and the file's size does not decide); save it anew from the program it is of",
               bytes.Path(), contradictions);
  const auto& [geometry, frames] = *best;
  if (!contradictions.empty())
    layout.warnings.push_back(fmt::format(
        "{}: contradicts itself ({}the file's size {}); {} frames of {} points and {} analogue samples are read",
        bytes.Path(), contradictions, is_filled ? "decides" : "agrees with none", frames.count, geometry.points,
        geometry.analog));
  layout.points = geometry.points;
  layout.analog_per_frame = geometry.analog;
  layout.scale = geometry.scale;
  layout.data_offset = 512 * (geometry.block - 1);
  layout.first_frame = frames.first;
  layout.frames = frames.count;
}

// By the parameter, else by the header.
double ReadRate(const C3dBytes& bytes, const C3dParameters& parameters, C3dLayout& layout) {
  constexpr double kLeast_hz = 1e-3;
  const auto is_rate = [](double rate_hz) { return rate_hz > kLeast_hz && std::isfinite(rate_hz); };
  const double header_hz = bytes.Float(20),
               point_hz = parameters.Has("POINT:RATE") ? parameters.Number("POINT:RATE") : header_hz;
  if (!is_rate(point_hz) && !is_rate(header_hz))
    throw Fail("{}: POINT:RATE is {}, not a frame rate", bytes.Path(), point_hz);
  constexpr double kAlike = 1e-3;
  if (is_rate(point_hz) && is_rate(header_hz) && std::abs(point_hz / header_hz - 1) > kAlike)
    layout.warnings.push_back(fmt::format("{}: POINT:RATE is {} Hz, the header's rate {} Hz; the former is taken",
                                          bytes.Path(), SignificantText(point_hz, 6), SignificantText(header_hz, 6)));
  return is_rate(point_hz) ? point_hz : header_hz;
}

C3dLayout ReadLayout(const C3dBytes& bytes, const C3dParameters& parameters, const std::string& path) {
  C3dLayout layout;
  layout.rate_hz = ReadRate(bytes, parameters, layout);
  const auto texts = [&](const char* name) {
    return parameters.Has(name) ? parameters.Texts(name) : std::vector<std::string>{};
  };
  layout.mm_per_unit = MmPerUnit(texts("POINT:UNITS"), path);
  layout.up_axis = UpAxis(texts("POINT:Y_SCREEN"));
  const StatedSizes stated = ReadStatedSizes(bytes, parameters, layout.rate_hz);
  ReadSizes(stated, bytes, layout);
  if (layout.frames == 0) throw Fail("{}: holds no frames", path);
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
  recording.warnings = layout.warnings;
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
  if (analog.is_unsigned)
    for (double& offset : analog.offset) offset = Unsigned(offset);
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

// A plate and what it measured: forces and moments in its own axes, one column a sample.
struct PlateSamples {
  C3dPlate plate;
  Eigen::Matrix<double, 6, Eigen::Dynamic> six;

  Eigen::RowVectorXd Along(int axis) const { return plate.lab_from_plate.row(axis) * six.topRows<3>(); }
};

PlateSamples ReadSamples(const C3dBytes& bytes, const C3dLayout& layout, const AnalogLayout& analog,
                         const C3dPlate& plate) {
  const auto value = [&](std::size_t frame, std::size_t sample, std::size_t channel) {
    const std::size_t at = layout.data_offset + frame * layout.FrameBytes() +
                           layout.WordBytes() * (4 * layout.points + sample * analog.channels + channel);
    const double stored = layout.IsFloat()     ? bytes.Float(at)
                          : analog.is_unsigned ? bytes.Unsigned16(at)
                                               : bytes.Signed16(at);
    return (stored - analog.offset[channel]) * analog.scale[channel];
  };
  PlateSamples read;
  read.plate = plate;
  read.six.resize(6, static_cast<Eigen::Index>(layout.frames * analog.samples));
  Eigen::Index column = 0;
  for (std::size_t frame = 0; frame < layout.frames; ++frame)
    for (std::size_t sample = 0; sample < analog.samples; ++sample, ++column)
      for (std::size_t i = 0; i < 6; ++i)
        read.six(static_cast<Eigen::Index>(i), column) = value(frame, sample, plate.channel[i]);
  read.six = plate.calibration * read.six;
  return read;
}

// What a plate measures while nobody stands on it, and where this comes from, for the message.
struct Baseline {
  Eigen::Matrix<double, 6, 1> six = Eigen::Matrix<double, 6, 1>::Zero();
  std::string source;
};

// Of FORCE_PLATFORM:ZERO, from 0 and the one behind the last; nullopt if it names none that the file holds. Its frames
// count as those of the points do; where they are not among them, from the first one stored.
std::optional<std::array<std::size_t, 2>> ZeroFrames(const C3dParameters& parameters, const C3dLayout& layout) {
  if (!parameters.Has("FORCE_PLATFORM:ZERO")) return std::nullopt;
  const std::vector<double> zero = parameters.Numbers("FORCE_PLATFORM:ZERO");
  if (zero.size() < 2) return std::nullopt;
  const double from = Unsigned(zero[0]), to = Unsigned(zero[1]), frames = static_cast<double>(layout.frames);
  if (!(from >= 1 && to >= from)) return std::nullopt;
  const auto first = static_cast<double>(layout.first_frame);
  const double before = from >= first && to < first + frames ? first : 1;
  if (to - before >= frames) return std::nullopt;
  return std::array{static_cast<std::size_t>(from - before), static_cast<std::size_t>(to - before) + 1};
}

// The mean of the windows in which the vertical force is steady and small against the `most` that a plate of the file
// bears: a foot at rest bears more than a tenth of it.
std::optional<Baseline> BaselineWithoutContact(const PlateSamples& plate, int up, double most_n, double rate_hz) {
  constexpr double kWindow_s = 0.1, kEmpty = 0.1, kSteady = 0.01, kAlike = 0.02;
  constexpr Eigen::Index kLeastSamples = 10, kLeastWindows = 2;
  const Eigen::RowVectorXd vertical_n = plate.Along(up);
  const Eigen::Index length = std::max(kLeastSamples, static_cast<Eigen::Index>(std::lround(kWindow_s * rate_hz)));
  std::vector<std::pair<double, Eigen::Index>> quiet;  // mean, first sample
  for (Eigen::Index i = 0; i + length <= vertical_n.size(); i += length) {
    const auto window = vertical_n.segment(i, length).array();
    const double mean = window.mean(), sd = std::sqrt((window - mean).square().mean());
    if (std::abs(mean) <= kEmpty * most_n && sd <= kSteady * most_n) quiet.emplace_back(mean, i);
  }
  if (quiet.empty()) return std::nullopt;
  std::sort(quiet.begin(), quiet.end());
  const double level_n = quiet[quiet.size() / 2].first;
  std::erase_if(quiet, [&](const auto& window) { return std::abs(window.first - level_n) > kAlike * most_n; });
  if (static_cast<Eigen::Index>(quiet.size()) < kLeastWindows) return std::nullopt;
  Baseline baseline;
  for (const auto& window : quiet) baseline.six += plate.six.middleCols(window.second, length).rowwise().mean();
  baseline.six /= static_cast<double>(quiet.size());
  baseline.source =
      fmt::format("its mean over {} s without contact; FORCE_PLATFORM:ZERO names no frames",
                  SignificantText(static_cast<double>(static_cast<Eigen::Index>(quiet.size()) * length) / rate_hz, 2));
  return baseline;
}

// Subtracts what each plate measures while it is empty: in the frames that the file names, else in those without
// contact.
void SubtractBaselines(const C3dParameters& parameters, const C3dLayout& layout, std::size_t samples,
                       const std::string& path, std::vector<std::optional<PlateSamples>>& plates,
                       std::vector<std::string>& warnings) {
  constexpr double kNamedEmpty = 0.2, kLeast_n = 50, kSaid_n = 1;
  const int up = layout.up_axis - 'x';
  double most_n = 0;
  for (const auto& plate : plates)
    if (plate && plate->six.cols() > 0) most_n = std::max(most_n, plate->Along(up).cwiseAbs().maxCoeff());
  const auto named = ZeroFrames(parameters, layout);
  for (std::size_t index = 0; index < plates.size(); ++index) {
    if (!plates[index]) continue;
    PlateSamples& plate = *plates[index];
    std::optional<Baseline> baseline;
    if (named) {
      const auto [begin, end] = std::array{static_cast<Eigen::Index>((*named)[0] * samples),
                                           static_cast<Eigen::Index>((*named)[1] * samples)};
      const std::string frames =
          fmt::format("frames {} to {}", layout.first_frame + (*named)[0], layout.first_frame + (*named)[1] - 1);
      baseline = Baseline{plate.six.middleCols(begin, end - begin).rowwise().mean(),
                          fmt::format("its mean in {}, which FORCE_PLATFORM:ZERO names", frames)};
      const double load_n = std::abs(plate.plate.lab_from_plate.row(up).dot(baseline->six.head<3>()));
      if (load_n > std::max(kNamedEmpty * most_n, kLeast_n)) {
        warnings.push_back(
            fmt::format("{}: force plate {} bears {} N in {}, which FORCE_PLATFORM:ZERO names as those without "
                        "contact; no offset is subtracted",
                        path, index + 1, SignificantText(load_n, 3), frames));
        continue;
      }
    } else {
      baseline = BaselineWithoutContact(plate, up, most_n, static_cast<double>(samples) * layout.rate_hz);
    }
    if (!baseline) continue;
    plate.six.colwise() -= baseline->six;
    if (const double offset_n = baseline->six.head<3>().norm(); offset_n >= kSaid_n)
      warnings.push_back(fmt::format("{}: force plate {}: an offset of {} N is subtracted, {}", path, index + 1,
                                     SignificantText(offset_n, 3), baseline->source));
  }
}

// In the laboratory's axes, as the ground's push on the foot.
void TurnIntoLaboratory(const PlateSamples& samples, int up, PlateForces& plate) {
  const Eigen::Matrix3Xd force_n = samples.plate.lab_from_plate * samples.six.topRows<3>(),
                         moment_nm =
                             samples.plate.m_per_moment * (samples.plate.lab_from_plate * samples.six.bottomRows<3>());
  const double sign = force_n.row(up).sum() < 0 ? -1 : 1;
  for (Eigen::Index i = 0; i < force_n.cols(); ++i) {
    plate.force_n.emplace_back(sign * force_n.col(i));
    plate.moment_nm.emplace_back(sign * moment_nm.col(i));
    plate.point_m.push_back(samples.plate.origin_m);
  }
}

}  // namespace

GroundForceRecording ReadC3dForces(const std::filesystem::path& path) {
  const C3dBytes bytes(ReadTextFile(path), path.string());
  const C3dParameters parameters(bytes);
  const C3dLayout layout = ReadLayout(bytes, parameters, path.string());
  const std::size_t count = parameters.Has("FORCE_PLATFORM:USED") ? parameters.Count("FORCE_PLATFORM:USED") : 0;
  if (count == 0) throw Fail("{}: no force plates (FORCE_PLATFORM:USED)", path.string());
  const AnalogLayout analog = ReadAnalogLayout(parameters, layout, path.string());
  GroundForceRecording forces;
  forces.up_axis = layout.up_axis;
  forces.warnings = layout.warnings;
  for (std::size_t frame = 0; frame < layout.frames; ++frame)
    for (std::size_t sample = 0; sample < analog.samples; ++sample)
      forces.time_s.push_back((static_cast<double>(layout.first_frame - 1 + frame) +
                               static_cast<double>(sample) / static_cast<double>(analog.samples)) /
                              layout.rate_hz);
  std::vector<std::optional<PlateSamples>> plates;
  for (std::size_t index = 0; index < count; ++index) {
    PlateForces& plate = forces.plates.emplace_back();
    plate.name = fmt::format("plate {}", index + 1);
    try {
      plates.emplace_back(
          ReadSamples(bytes, layout, analog, ReadPlate(parameters, layout, analog, index, path.string())));
    } catch (const Error& error) {
      plates.emplace_back();
      plate.unusable = error.what();
      forces.warnings.push_back(fmt::format("{}; it is left out", error.what()));
    }
  }
  if (std::none_of(plates.begin(), plates.end(), [](const auto& plate) { return plate.has_value(); }))
    throw Fail("{}", forces.plates.front().unusable);
  SubtractBaselines(parameters, layout, analog.samples, path.string(), plates, forces.warnings);
  const std::vector<Eigen::Vector3d> nothing(forces.time_s.size(), Eigen::Vector3d::Zero());
  for (std::size_t index = 0; index < count; ++index) {
    PlateForces& plate = forces.plates[index];
    if (plates[index])
      TurnIntoLaboratory(*plates[index], layout.up_axis - 'x', plate);
    else
      plate.force_n = plate.point_m = plate.moment_nm = nothing;
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
