// The page on which two trials run side by side, each at the same percent of its rise, with their misalignment in step.
#pragma once

#include <filesystem>
#include <string>

#include "lake/core/json.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"
#include "lake/review/page_options.h"
#include "lake/video/video_reader.h"

namespace lake::review {

struct ComparedVideo {
  std::string name;    // for the page
  std::string marker;  // that is compared
  std::filesystem::path video;
  video::VideoReaderOptions reader;
  motion::MarkerRecording tracks;  // px
  motion::LegMotion motion;        // of which repetition and percent count
  Json rises;                      // RiseMessage of each rise that counts in the comparison, in page/messages.ts
};

struct ComparedPair {
  std::string name;
  ComparedVideo human, exo;
  Json curves;  // ComparisonCurves in page/messages.ts
};

// Serves the page until its last window is closed. Throws Error where the port is taken or a video cannot be read,
// Interrupted once a signal has arrived.
void ServeComparison(const PageOptions& options, const ComparedPair& pair);

}  // namespace lake::review
