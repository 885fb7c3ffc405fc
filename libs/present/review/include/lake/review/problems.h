// What in a trial's tracks deserves to be looked at, in the order of frames.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lake/gait/leg_fit.h"
#include "lake/motion/marker_recording.h"

namespace lake::review {

enum class ProblemKind {
  kGap,        // the marker was not seen
  kOutlier,    // the leg fit gives the measurement no weight; `value`: residual, px
  kUncertain,  // its sigma is unusually large; `value`: the largest, px
  kLength,     // the distance to the next marker of the leg is not the usual one; `value`: the largest ratio, or the
               // smallest: what exchanged names look like
};

std::string_view ToString(ProblemKind kind);

struct Problem {
  ProblemKind kind = ProblemKind::kGap;
  std::string marker;
  std::int64_t first = 0, last = 0;  // frames
  double value = 0;
};

// `measured`: px, with corrections; `leg`: nullptr where there is no fit; `repeated`: frames in which nothing is
// missed.
std::vector<Problem> FindProblems(const motion::MarkerRecording& measured, const gait::LegFitResult* leg,
                                  const std::vector<std::int64_t>& repeated);

}  // namespace lake::review
