// The work of lake-live: a person with an exoskeleton before the camera, its joint's place told after each rise while
// it is worn, everything recorded, and a trial in the end.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/picture_scale.h"
#include "lake/review/page_options.h"
#include "lake/tracking/marker_detector.h"
#include "lake/video/live_stream.h"

namespace lake::live {

struct LiveRunOptions : gait::PictureScale {
  std::string
      input;  // a device, an address, "-", a pipe, a file to be replayed, or a folder whose trial is to be finished
  video::LiveStreamOptions stream;
  std::vector<std::string> markers = {"ankle", "knee", "hip", "waist", "exo_knee"};
  std::vector<tracking::MarkerSeed> seeds;
  tracking::Polarity polarity = tracking::Polarity::kBright;
  cv::Rect crop;
  std::string joint = "exo_knee";  // of the markers: the exoskeleton's
  // Where that marker is against the joint's axis, shank's frame: beside it where both markers would cover one another.
  std::array<double, 2> joint_at_mm = {0, 0};
  gait::LegFitOptions fit;  // of these --technical and --knee-from alone
  double tolerance_mm = 5;
  bool overlay = true;
  review::PageOptions page;
};

void Describe(LiveRunOptions& o, OptionList& options);

// Whether the input is the folder of a recording that was not finished.
bool IsFolderToFinish(const LiveRunOptions& options);

// Records, tells and serves the page until the stream ends or a person ends it; then lake-track, a program in
// `programs`, makes a trial of the recording. Writes video.mkv, live_tracks.csv, rises.csv, moves.csv and live.json
// through `run` and returns what live.json holds. Reports what a person wants to read of it. Throws Error where there
// is no trial in the end, or the disk became full; Interrupted once a signal has arrived: the recording is whole then,
// and can be finished.
Json RunLive(const LiveRunOptions& options, const std::filesystem::path& programs, Run& run);

}  // namespace lake::live
