#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>

#include "c3d_bytes.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/point_recording.h"
#include "readers.h"

namespace lake::exchange {
namespace {

double MmPerUnit(const std::vector<std::string>& units, const std::string& path, std::vector<std::string>& warnings) {
  if (units.empty() || units[0].empty()) return 1;
  const std::optional<double> mm_per_unit = FindMmPerUnit(units[0]);
  if (!mm_per_unit)
    warnings.push_back(fmt::format("{}: POINT:UNITS is '{}', no unit of length; mm is assumed", path, units[0]));
  return mm_per_unit.value_or(1);
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

// What a file states more than once.
enum Size { kPoints, kAnalog, kBlock, kScale, kFrames, kSizes };
constexpr const char* kSizeNames[] = {"points", "analogue samples of a frame", "first block of data", "scale"};

struct Stated {
  const char* where;
  double value;
  std::size_t first = 1;     // of frames: the number of the first
  std::ptrdiff_t votes = 1;  // 0: what no place states, and only the file's size can prove
};
using StatedSizes = std::array<std::vector<Stated>, kSizes>;  // of each, what is believed first stands first

// Of scales the sign says whether the data are floats.
bool Agree(Size size, double a, double b) {
  return size == kScale ? (a < 0) == (b < 0) : a == b;
}

constexpr std::size_t kMostCut = 65535;

std::ptrdiff_t Votes(Size size, double value, const StatedSizes& stated) {
  std::ptrdiff_t votes = 0;
  for (const Stated& each : stated[size]) votes += Agree(size, each.value, value) ? each.votes : 0;
  return votes;
}

constexpr double kMostCount = 4294967295;

// 0 is left out where another place says more, and so is what cannot be.
bool CanBe(Size size, double value) {
  constexpr double kLeastScale = 1e-6;  // 16 bits would hold a thirtieth of a millimetre; floats are not scaled
  constexpr double kMostBlocks = 65535;
  if (size == kScale) return std::isfinite(value) && (value < 0 || value >= kLeastScale);
  const double least = size == kBlock ? 2 : size == kAnalog ? 0 : 1;
  return value >= least && value <= (size == kBlock ? kMostBlocks : kMostCount) && value == std::floor(value);
}

// Two 16-bit words, low first, or one number.
double LongWord(const C3dParameters& parameters, const char* name) {
  const std::vector<double> words = parameters.Numbers(name);
  return words.size() < 2 ? parameters.Number(name).value_or(-1) : Unsigned(words[0]) + 65536 * Unsigned(words[1]);
}

StatedSizes ReadStatedSizes(const C3dBytes& bytes, const C3dParameters& parameters, double rate_hz) {
  StatedSizes stated;
  const auto add = [&](Size size, const char* where, std::optional<double> value, double first = 1) {
    if (value && CanBe(size, *value) && first <= kMostCount)
      stated[size].push_back({where, *value, static_cast<std::size_t>(std::max(first, 1.0))});
  };
  const auto word = [&](std::size_t offset) { return static_cast<double>(bytes.Unsigned16(offset)); };
  const std::optional<double> scale = parameters.Number("POINT:SCALE"), start = parameters.Number("POINT:DATA_START");
  add(kPoints, "POINT:USED", parameters.Number("POINT:USED"));
  add(kPoints, "the header", word(2));
  if (stated[kPoints].empty()) stated[kPoints].push_back({"POINT:USED", 0});  // a recording of forces alone
  const auto labels = static_cast<double>(parameters.Texts("POINT:LABELS").size());
  if (Votes(kPoints, labels, stated) > 0) add(kPoints, "POINT:LABELS", labels);
  add(kScale, "POINT:SCALE", scale);
  add(kScale, "the header", bytes.Float(12));
  // Some writers have the sign wrong, which is that of floats.
  if (stated[kScale].empty())
    stated[kScale].push_back({"no place, so they are floats", -1, 1, 0});
  else
    stated[kScale].push_back({"the data", -stated[kScale].front().value, 1, 0});
  add(kBlock, "POINT:DATA_START", start);
  add(kBlock, "the header", word(16));
  if (stated[kBlock].empty())
    throw Fail("{}: POINT:DATA_START is {}, not a block of the file", bytes.Path(), start.value_or(word(16)));
  add(kAnalog, "the header", word(4));
  if (const auto used = parameters.Number("ANALOG:USED")) {
    if (*used == 0 || word(18) > 0) add(kAnalog, "ANALOG:USED and the header's samples of a frame", *used * word(18));
    const double ratio = parameters.Number("ANALOG:RATE").value_or(0) / rate_hz;
    if (*used > 0 && ratio >= 0.5) add(kAnalog, "ANALOG:USED and ANALOG:RATE", *used * std::round(ratio));
  }
  const double first = word(6), last = word(8), actual_first = LongWord(parameters, "TRIAL:ACTUAL_START_FIELD"),
               actual_last = LongWord(parameters, "TRIAL:ACTUAL_END_FIELD");
  if (actual_first >= 0 && actual_last > 0)
    add(kFrames, "TRIAL:ACTUAL_END_FIELD", actual_last - actual_first + 1, actual_first);
  add(kFrames, "POINT:LONG_FRAMES", LongWord(parameters, "POINT:LONG_FRAMES"), first);
  if (last > 0) add(kFrames, "the header", last - first + 1, first);
  add(kFrames, "POINT:FRAMES", parameters.Number("POINT:FRAMES"), first);
  if (stated[kFrames].empty()) stated[kFrames].push_back({"the header", 0});
  return stated;
}

// Where the data lie if one statement on each size is right, and how many statements agree with it.
struct Geometry {
  std::array<double, kFrames> sizes = {};
  std::ptrdiff_t votes = 0;

  std::size_t FrameBytes() const {
    return static_cast<std::size_t>((sizes[kScale] < 0 ? 4 : 2) * (4 * sizes[kPoints] + sizes[kAnalog]));
  }
  std::size_t DataOffset() const { return 512 * (static_cast<std::size_t>(sizes[kBlock]) - 1); }
  std::size_t Available(std::size_t size) const { return size - std::min(size, DataOffset()); }
  // A file ends with the block of its last frame.
  bool Fills(std::size_t frames, std::size_t size) const {
    const std::size_t available = Available(size);
    return frames <= available / FrameBytes() && available - frames * FrameBytes() < 512;
  }
};

std::vector<Geometry> GeometriesOf(const StatedSizes& stated) {
  std::vector<Geometry> geometries(1);
  for (const Size size : {kPoints, kAnalog, kBlock, kScale}) {
    std::vector<Geometry> longer;
    for (const Geometry& geometry : geometries)
      for (auto each = stated[size].begin(); each != stated[size].end(); ++each) {
        const auto is_same = [&](const Stated& other) { return Agree(size, other.value, each->value); };
        if (std::any_of(stated[size].begin(), each, is_same)) continue;
        longer.push_back(geometry);
        longer.back().sizes[size] = each->value;
        longer.back().votes += Votes(size, each->value, stated);
      }
    geometries = std::move(longer);
  }
  std::erase_if(geometries, [](const Geometry& geometry) { return geometry.FrameBytes() == 0; });
  return geometries;
}

// Whether the data's first words, taken for floats, are such as a laboratory has; integers make denormal numbers.
bool LookLikeFloats(const C3dBytes& bytes, std::size_t offset) {
  constexpr std::size_t kWords = 256;
  constexpr double kLeast = 1e-6, kMost = 1e7;
  bool any = false;
  for (std::size_t at = offset; at + 4 <= std::min(bytes.Size(), offset + 4 * kWords); at += 4) {
    const double value = std::abs(bytes.Float(at));
    if (value < kLeast ? value > 0 : value > kMost) return false;
    any = any || value > 0;
  }
  return any;
}

bool AreZeros(const C3dBytes& bytes, std::size_t begin, std::size_t end) {
  return bytes.Text(begin, end - begin).find_first_not_of('\0') == std::string::npos;
}

// Zeros that fill the last block of a file look like frames.
std::size_t EmptyAtTheEnd(const C3dBytes& bytes, const Geometry& geometry) {
  const std::size_t frame = geometry.FrameBytes(), held = geometry.Available(bytes.Size()) / frame;
  std::size_t empty = 0;
  const auto end = [&] { return geometry.DataOffset() + (held - empty) * frame; };
  while (empty < 511 / frame && AreZeros(bytes, end() - frame, end())) ++empty;
  return empty;
}

// Whether a count of frames is the one that is read, or that one as 16 bits cut it.
bool MeansFrames(const Stated& stated, std::size_t count) {
  const auto value = static_cast<std::size_t>(stated.value);
  return value == count || (count > kMostCut && (value == kMostCut || stated.first + value - 1 == kMostCut ||
                                                 (count - value) % (kMostCut + 1) == 0));
}

// As many frames as are stated, or, where nothing states more, the number that 16 bits cut down to that; 0 if the file
// does not end with them.
std::size_t FramesFilling(const C3dBytes& bytes, const Geometry& geometry, const Stated& stated, bool may_be_cut) {
  const std::size_t size = bytes.Size(), held = geometry.Available(size) / geometry.FrameBytes();
  const auto count = static_cast<std::size_t>(stated.value);
  if (may_be_cut && held > kMostCut)
    for (const std::size_t frames : {held - EmptyAtTheEnd(bytes, geometry), held - (held - count) % (kMostCut + 1)})
      if (MeansFrames(stated, frames) && geometry.Fills(frames, size)) return frames;
  return geometry.Fills(count, size) ? count : 0;
}

// One reading of the file. Its frames end in the file's last block, or something else lies behind them, or the file is
// cut off and fewer are there than stated.
enum class Fit { kCutOff, kHeld, kFilled };
struct Reading {
  Geometry geometry;
  Stated frames;
  std::size_t count = 0;
  Fit fit = Fit::kCutOff;

  // Whether nothing but zeros lies behind the last frame, and more than zeros in it.
  bool EndsWithData(const C3dBytes& bytes) const {
    const std::size_t end = geometry.DataOffset() + count * geometry.FrameBytes();
    return fit == Fit::kFilled && AreZeros(bytes, end, bytes.Size()) &&
           !AreZeros(bytes, end - geometry.FrameBytes(), end);
  }
};

std::vector<Reading> ReadingsOf(const StatedSizes& stated, const C3dBytes& bytes) {
  std::vector<Reading> readings;
  const bool may_be_cut = std::ranges::none_of(stated[kFrames], [](const Stated& s) { return s.value > kMostCut; });
  for (const Geometry& geometry : GeometriesOf(stated)) {
    const double scale = geometry.sizes[kScale];
    if (Votes(kScale, scale, stated) == 0 && LookLikeFloats(bytes, geometry.DataOffset()) != (scale < 0)) continue;
    const std::size_t held = geometry.Available(bytes.Size()) / geometry.FrameBytes();
    std::vector<Reading> of_this;
    for (const Stated& frames : stated[kFrames]) {
      const auto count = static_cast<std::size_t>(frames.value);
      if (const std::size_t filling = FramesFilling(bytes, geometry, frames, may_be_cut))
        of_this.push_back({geometry, frames, filling, Fit::kFilled});
      else if (held > 0 && count > 0 && Votes(kScale, scale, stated) > 0)
        of_this.push_back({geometry, frames, std::min(count, held), count > held ? Fit::kCutOff : Fit::kHeld});
    }
    // A count that 16 bits do not hold was not cut by them.
    const auto rank = [&](const Reading& reading) {
      const bool is_long = reading.frames.value > kMostCut && reading.fit != Fit::kCutOff;
      return std::tuple(reading.fit == Fit::kFilled,
                        Votes(kFrames, reading.frames.value, stated) + (is_long ? kSizes : 0),
                        reading.EndsWithData(bytes));
    };
    if (const auto best = std::ranges::max_element(of_this, {}, rank); best != of_this.end()) readings.push_back(*best);
  }
  return readings;
}

std::string Contradictions(const StatedSizes& stated, const Reading& reading) {
  std::string text;
  const auto add = [&](const char* what, const std::vector<Stated>& all, const std::string& read) {
    std::vector<std::string> parts;
    for (const Stated& each : all)
      if (each.votes > 0) parts.push_back(fmt::format("{} by {}", each.value, each.where));
    if (parts.empty()) parts.emplace_back("not stated");
    text += fmt::format("{}: {}{}; ", what, fmt::join(parts, ", "), read);
  };
  for (const Size size : {kPoints, kAnalog, kBlock, kScale}) {
    const double read = reading.geometry.sizes[size];
    const auto differs = [&](const Stated& each) {
      return each.votes > 0 && each.value != read && !(size == kScale && each.value < 0 && read < 0);
    };
    if (Votes(size, read, stated) == 0 || std::ranges::any_of(stated[size], differs))
      add(kSizeNames[size], stated[size], size == kScale ? read < 0 ? ", floats in the file" : ", integers in it" : "");
  }
  const auto means = [&](const Stated& each) { return MeansFrames(each, reading.count); };
  if (reading.fit != Fit::kCutOff &&
      (!std::ranges::all_of(stated[kFrames], means) || Votes(kFrames, static_cast<double>(reading.count), stated) == 0))
    add("frames", stated[kFrames], fmt::format(", {} in the file", reading.count));
  return text;
}

void ReadSizes(const StatedSizes& stated, const C3dBytes& bytes, C3dLayout& layout) {
  const std::vector<Reading> readings = ReadingsOf(stated, bytes);
  const auto rank = [&](const Reading& reading) {
    return std::tuple(reading.fit, reading.geometry.votes, reading.EndsWithData(bytes));
  };
  const auto best = std::ranges::max_element(readings, {}, rank);
  if (stated[kScale].front().votes == 0 && (best == readings.end() || best->fit != Fit::kFilled))
    throw Fail("{}: POINT:SCALE is absent or 0, and the data are not floats by their size", bytes.Path());
  if (best == readings.end())
    throw Fail("{}: holds no frame of points or analogue channels ({} frames of {} points are stated)", bytes.Path(),
               stated[kFrames].front().value, stated[kPoints].front().value);
  const std::string contradictions = Contradictions(stated, *best);
  if (std::ranges::count(readings, rank(*best), rank) > 1)
    throw Fail("{}: contradicts itself ({}and the file's size does not decide); save it anew from the program it is of",
               bytes.Path(), contradictions);
  const auto& sizes = best->geometry.sizes;
  if (best->fit == Fit::kCutOff)
    layout.warnings.push_back(fmt::format("{}: is cut off: {} of {} frames are there, and read", bytes.Path(),
                                          best->count, best->frames.value));
  if (!contradictions.empty())
    layout.warnings.push_back(
        fmt::format("{}: contradicts itself ({}the file's size {}); {} frames of {} points and {} analogue samples are "
                    "read",
                    bytes.Path(), contradictions, best->fit == Fit::kFilled ? "decides" : "agrees with none",
                    best->count, sizes[kPoints], sizes[kAnalog]));
  layout.points = static_cast<std::size_t>(sizes[kPoints]);
  layout.analog_per_frame = static_cast<std::size_t>(sizes[kAnalog]);
  layout.scale = sizes[kScale];
  layout.data_offset = best->geometry.DataOffset();
  layout.first_frame = best->frames.first;
  layout.frames = best->count;
}

// By the parameter, else by the header, else by what cameras and channels ran at.
double ReadRate(const C3dBytes& bytes, const C3dParameters& parameters, std::vector<std::string>& warnings) {
  constexpr double kLeast_hz = 1e-3, kAlike = 1e-3;
  const auto number = [&](const char* name) { return parameters.Number(name).value_or(0); };
  const std::pair<const char*, double> stated[] = {
      {"POINT:RATE", number("POINT:RATE")},
      {"the header", bytes.Float(20)},
      {"TRIAL:CAMERA_RATE", number("TRIAL:CAMERA_RATE")},
      {"ANALOG:RATE", number("ANALOG:RATE") / std::max<double>(bytes.Unsigned16(18), 1)}};
  const auto is_rate = [&](const auto& rate) { return rate.second > kLeast_hz && std::isfinite(rate.second); };
  const auto* rate = std::ranges::find_if(stated, is_rate);
  if (rate == std::end(stated)) throw Fail("{}: neither POINT:RATE nor the header has a frame rate", bytes.Path());
  const double hz = rate->second, of_header_hz = stated[1].second;
  if (rate > &stated[1])
    warnings.push_back(fmt::format("{}: neither POINT:RATE nor the header has a frame rate; {} Hz are taken by {}",
                                   bytes.Path(), SignificantText(hz, 6), rate->first));
  else if (is_rate(stated[1]) && std::abs(hz / of_header_hz - 1) > kAlike)
    warnings.push_back(fmt::format("{}: POINT:RATE is {} Hz, the header's rate {} Hz; the former is taken",
                                   bytes.Path(), SignificantText(hz, 6), SignificantText(of_header_hz, 6)));
  return hz;
}

}  // namespace

C3dLayout ReadLayout(const C3dBytes& bytes, const C3dParameters& parameters) try {
  C3dLayout layout;
  layout.warnings = parameters.Warnings();
  layout.rate_hz = ReadRate(bytes, parameters, layout.warnings);
  layout.mm_per_unit = MmPerUnit(parameters.Texts("POINT:UNITS"), bytes.Path(), layout.warnings);
  layout.up_axis = UpAxis(parameters.Texts("POINT:Y_SCREEN"));
  ReadSizes(ReadStatedSizes(bytes, parameters, layout.rate_hz), bytes, layout);
  layout.labels = ReadLabels(parameters, layout.points);
  return layout;
} catch (const Error& error) {
  std::vector<std::string> writer;
  for (const char* name : {"COMPANY", "SOFTWARE", "VERSION_LABEL", "SOFTWARE_VERSION"})
    for (const std::string& text : parameters.Texts(std::string("MANUFACTURER:") + name)) writer.push_back(text);
  throw Fail("{}{}", error.what(), writer.empty() ? "" : fmt::format(" (written by {})", fmt::join(writer, " ")));
}

}  // namespace lake::exchange
