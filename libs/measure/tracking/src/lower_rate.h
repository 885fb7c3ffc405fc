// The rate of the film that a recording shows at a higher one by repeating frames. Not part of the interface.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace lake::tracking {

// Frames per second at which films are made: of cinema, television, and cameras in little light.
inline constexpr std::array kFilmRates_hz = {10.0,        12.5,        15.0, 20.0,        24e3 / 1001, 24.0,
                                             25.0,        30e3 / 1001, 30.0, 48e3 / 1001, 48.0,        50.0,
                                             60e3 / 1001, 60.0,        90.0, 100.0,       120.0,       240.0};

// Frame floor(ratio · i + phase) of the source is shown in frame i.
struct LowerRate {
  double ratio = 1, phase = 0;

  double Source(std::size_t i) const;
  bool Repeats(std::size_t i) const { return i > 0 && Source(i) == Source(i - 1); }
};

// A frame that is known to repeat the one before, or to be new.
struct JudgedFrame {
  std::size_t frame = 0;
  bool is_repeated = false;
};

// The rate whose repetitions are those that were found: the likeliest of the films' rates and of m in every n frames
// (odds 1/n²), where one frame in 33 is judged wrongly. `shown_hz`: the recording's. nullopt if too few frames are
// repeated, or it is likelier that they recur in no such way.
std::optional<LowerRate> FindLowerRate(const std::vector<JudgedFrame>& judged, double shown_hz);

}  // namespace lake::tracking
