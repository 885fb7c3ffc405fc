// Two clocks aligned by the movement that both recordings show, or by a signal that somebody sent to both.
#pragma once

#include <string>
#include <vector>

#include "lake/sync/clock.h"
#include "lake/sync/movement.h"

namespace lake::sync {

struct AlignOptions {
  double drift_sd_ppm = 300;  // quartz clocks differ by less than 100; 0: no drift
};

// The signals that were compared, over the overlap on A's clock, for a figure: the largest component of one.
struct Comparison {
  std::string name = {};  // "speeds of knee, hip"
  std::vector<double> time_s = {}, measured = {}, predicted = {};
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
  double unexplained = 0;  // the part of one recording's variance that the other does not predict
  double overlap_s = 0;
  std::vector<PartOffset> parts = {};
  std::vector<double> offset_s = {}, log_likelihood = {};  // over that of unrelated movements, of the coarse search
  Comparison comparison = {};
};

// By FindLag of lag.h. Throws Error, saying why, where the two cannot be aligned.
Alignment AlignByMotion(const Movement& a, const Movement& b, const AlignOptions& options = {});

// A signal in one recording, which somebody sent to both.
struct Signal {
  std::vector<double> rises_s = {};  // when it comes on, on the recording's clock
  double sd_s = 0;                   // of each: it lies anywhere within a sampling interval
};

Signal SampledSignal(std::vector<double> rises_s, const Movement& recording);

// By such a signal. Where one has more rises than the other, those that fit one another best are taken. Throws Error
// where they contradict one another.
Alignment AlignBySignal(const Signal& in_a, const Signal& in_b, const Movement& a, const Movement& b,
                        const AlignOptions& options = {});

}  // namespace lake::sync
