// The pages that need no work of their own but what they show: a folder to begin in, a study's report, two trials side
// by side, a camera's session. Trials and designs have headers of their own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>

#include "lake/core/json.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"
#include "lake/review/background_job.h"
#include "lake/review/page_options.h"
#include "lake/video/video_reader.h"

namespace lake::review {

// Each is served until its last window is closed.
struct OtherPages {
  // Serves the page of a film or of results and returns its address. Throws Error.
  std::function<std::string(const std::string& path)> open;
  std::function<bool()> are_open;
};

struct StartWork {
  std::string folder;           // for the page
  std::function<Json()> found;  // a list of FoundMessage in page/messages.ts
  OtherPages pages;
  // Makes the camera or the study that the page asks for (MakeQuestion there). Throws Error.
  std::function<void(const Json& asked, const BackgroundJob::Control& control)> make;
};

struct StudyWork {
  std::string name, command;     // for the page; `command` made the results
  std::filesystem::path report;  // need not be there
  Json parts;                    // what can be opened: a list of StudyPart in page/messages.ts
  OtherPages pages;
};

// Two trials, each at the same percent of its rise, with their misalignment in step.
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

// An exoskeleton aligned while it is worn: what the camera sees, what was measured, where the joint is to go.
// All may be called by several threads at once.
struct LiveWork {
  std::function<Json()> about;                         // LiveMessage in page/messages.ts
  std::function<Json()> state;                         // LiveStateMessage, less its mode
  std::function<Json(std::int64_t after)> view;        // LiveViewMessage; waits a little for a later frame
  std::function<cv::Mat(std::int64_t frame)> picture;  // CV_8UC1, at most as wide as `about` says. Throws Error: gone
  std::function<void(const Json& act)> act;            // LiveAct. Throws Error saying why not
  std::function<bool()> is_over;                       // then the page ends with its last window
};

// Serve the page until its last window, and the last page opened from it, are closed; that of a session until it is
// over too. Throw Error where the port is taken or a video cannot be read, Interrupted once a signal has arrived.
void ServeStart(const PageOptions& options, const StartWork& work);
void ServeStudy(const PageOptions& options, const StudyWork& work);
void ServeComparison(const PageOptions& options, const ComparedPair& pair);
void ServeLive(const PageOptions& options, const LiveWork& work);

}  // namespace lake::review
