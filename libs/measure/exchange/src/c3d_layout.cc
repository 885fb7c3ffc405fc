#include "c3d_layout.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/point_recording.h"
#include "text_lines.h"

namespace lake::exchange {
namespace {

double MmPerUnit(const std::vector<std::string>& units, const std::string& path) {
  if (units.empty() || units[0].empty()) return 1;
  const std::optional<double> mm_per_unit = FindMmPerUnit(units[0]);
  if (!mm_per_unit) throw Fail("{}: POINT:UNITS is '{}', no unit of length", path, units[0]);
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
  const std::optional<std::size_t> used = parameters.Count("ANALOG:USED");
  if (!used) return stated;
  const std::size_t channels = *used, samples = bytes.Unsigned16(18);
  if (channels == 0) {
    stated.push_back({"ANALOG:USED", 0});
    return stated;
  }
  if (samples > 0) stated.push_back({"ANALOG:USED and the header's samples of a frame", channels * samples});
  const double ratio = parameters.Number("ANALOG:RATE").value_or(0) / rate_hz;
  constexpr double kMost = 65535;
  if (ratio >= 0.5 && ratio < kMost)
    stated.push_back({"ANALOG:USED and ANALOG:RATE", channels * static_cast<std::size_t>(std::lround(ratio))});
  return stated;
}

// Two 16-bit words, low first; 0 where there are none.
double LongWord(const C3dParameters& parameters, const char* name) {
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
  if (const auto count = parameters.Count("POINT:LONG_FRAMES"))
    stated.push_back({"POINT:LONG_FRAMES", {first, *count}});
  if (last >= first) stated.push_back({"the header", {first, last - first + 1}});
  if (const auto count = parameters.Count("POINT:FRAMES")) stated.push_back({"POINT:FRAMES", {first, *count}});
  std::erase_if(stated, [](const auto& each) { return each.value.count == 0; });
  if (stated.empty()) stated.push_back({"the header", {first, 0}});
  return stated;
}

StatedSizes ReadStatedSizes(const C3dBytes& bytes, const C3dParameters& parameters, double rate_hz) {
  StatedSizes stated;
  if (const auto used = parameters.Count("POINT:USED")) stated.points.push_back({"POINT:USED", *used});
  stated.points.push_back({"the header", bytes.Unsigned16(2)});
  std::erase_if(stated.points, [](const auto& each) { return each.value == 0; });
  if (stated.points.empty()) stated.points.push_back({"POINT:USED", 0});  // a recording of forces alone
  if (const auto scale = parameters.Number("POINT:SCALE")) stated.scale.push_back({"POINT:SCALE", *scale});
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
  if (const auto start = parameters.Number("POINT:DATA_START")) {
    block = *start;
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
          if (points == 0 && analog == 0) continue;
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
  std::size_t stated_frames = 0;  // of a file that is cut off
  if (possible.empty()) {
    stated_frames = believed.count;
    for (const Geometry& geometry : all)
      if (const std::size_t held = geometry.Available(bytes.Size()) / geometry.FrameBytes(); held > 0)
        possible.push_back({geometry, {believed.first, held}});
  }
  const auto fewer = [](const auto& a, const auto& b) { return a.first.agreeing < b.first.agreeing; };
  const auto best = std::max_element(possible.begin(), possible.end(), fewer);
  if (best == possible.end())
    throw Fail("{}: holds no frame of points or analogue channels ({} frames of {} points are stated)", bytes.Path(),
               believed.count, stated.points.front().value);
  const auto equals = std::count_if(possible.begin(), possible.end(),
                                    [&](const auto& other) { return other.first.agreeing == best->first.agreeing; });
  const std::string contradictions =
      Contradictions(stated) + (stated_frames ? "" : FrameContradiction(stated, best->second));
  if (equals > 1)
    throw Fail("{}: contradicts itself ({}and the file's size does not decide); save it anew from the program it is of",
               bytes.Path(), contradictions);
  const auto& [geometry, frames] = *best;
  if (stated_frames)
    layout.warnings.push_back(
        fmt::format("{}: is cut off: {} of {} frames are there, and read", bytes.Path(), frames.count, stated_frames));
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
  const double header_hz = bytes.Float(20), point_hz = parameters.Number("POINT:RATE").value_or(header_hz);
  if (!is_rate(point_hz) && !is_rate(header_hz))
    throw Fail("{}: POINT:RATE is {}, not a frame rate", bytes.Path(), point_hz);
  constexpr double kAlike = 1e-3;
  if (is_rate(point_hz) && is_rate(header_hz) && std::abs(point_hz / header_hz - 1) > kAlike)
    layout.warnings.push_back(fmt::format("{}: POINT:RATE is {} Hz, the header's rate {} Hz; the former is taken",
                                          bytes.Path(), SignificantText(point_hz, 6), SignificantText(header_hz, 6)));
  return is_rate(point_hz) ? point_hz : header_hz;
}

}  // namespace

C3dLayout ReadLayout(const C3dBytes& bytes, const C3dParameters& parameters) {
  C3dLayout layout;
  layout.warnings = parameters.Warnings();
  layout.rate_hz = ReadRate(bytes, parameters, layout);
  layout.mm_per_unit = MmPerUnit(parameters.Texts("POINT:UNITS"), bytes.Path());
  layout.up_axis = UpAxis(parameters.Texts("POINT:Y_SCREEN"));
  const StatedSizes stated = ReadStatedSizes(bytes, parameters, layout.rate_hz);
  ReadSizes(stated, bytes, layout);
  if (layout.frames == 0) throw Fail("{}: holds no frames", bytes.Path());
  layout.labels = ReadLabels(parameters, layout.points);
  return layout;
}

}  // namespace lake::exchange
