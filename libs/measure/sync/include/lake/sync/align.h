// Two clocks aligned by the movement that both recordings show.
//
// One recording's signals y are told from the other's x by a linear map, y(t) = x(t + offset + drift t) C + c + e: of
// one marker seen by two cameras or laboratories, of a segment's turning and a sensor's rates, of the markers' vertical
// accelerations and the force on the feet. C, c, offset and drift maximise the likelihood; e is Gaussian and
// autoregressive, its coefficients are the residual's own. A prior of the drift, 0 ± drift_sd_ppm, keeps a short
// recording from inventing one.
#pragma once

#include <string>
#include <vector>

#include "lake/sync/clock.h"
#include "lake/sync/movement.h"

namespace lake::sync {

struct AlignOptions {
  double drift_sd_ppm = 300;  // quartz clocks differ by less than 100; 0: no drift
};

// What was compared, over the overlap on A's clock, for a figure: the first signal.
struct Comparison {
  std::string name = {};  // "speed of knee"
  std::vector<double> time_s = {}, measured = {}, told = {};
};

// What a part of the overlap says by itself.
struct PartOffset {
  double time_s = 0;       // its middle, on A's clock
  double departure_s = 0;  // its own offset less the clock's
  double sd_s = 0;
};

struct Alignment {
  Clock clock = {};
  double drift_sd_ppm = 0;
  double unexplained = 0;  // the part of y's variance that is not told
  double overlap_s = 0;
  std::vector<PartOffset> parts = {};
  std::vector<double> offset_s = {}, log_likelihood = {};  // over that of unrelated movements, of the coarse search
  Comparison comparison = {};
  std::vector<std::string> warnings = {};
};

// Throws Error, saying why, where the two cannot be aligned: no movement, too short an overlap, the movement is told
// too badly, another offset is as likely, or parts of the overlap contradict one another.
Alignment AlignByMotion(const Movement& a, const Movement& b, const AlignOptions& options = {});

// A signal in one recording, which somebody sent to both.
struct Signal {
  std::string name = {};             // "claps"
  std::vector<double> rises_s = {};  // when it comes on, on the recording's clock
  double sd_s = 0;                   // of each by itself
  double common_sd_s = 0;            // of all of them alike
  std::vector<std::string> warnings = {};
};

// Rises that a recording shows: each lies anywhere within its sampling interval.
Signal SampledSignal(std::vector<double> rises_s, const Movement& recording);

// By such a signal. Where one has more rises than the other, those that fit one another best are taken. Throws Error
// where they contradict one another.
Alignment AlignBySignal(const Signal& in_a, const Signal& in_b, const Movement& a, const Movement& b,
                        const AlignOptions& options = {});

}  // namespace lake::sync
