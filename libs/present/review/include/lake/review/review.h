// The page on which a person looks at a recording and corrects what was tracked in it.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "lake/core/json.h"
#include "lake/review/background_job.h"
#include "lake/review/page_options.h"
#include "lake/review/snap.h"
#include "lake/review/trial_session.h"
#include "lake/video/video_reader.h"

namespace lake::review {

// A trial that was tracked, to be corrected.
struct ReviewedTrial {
  CorrectionBook book;
  std::vector<std::int64_t> repeated;  // frames whose picture is that of the frame before
  TrialWork work;
  // Tracks again with the corrections that are saved, and gives the trial anew; throws Error. Empty: this is another
  // program's part.
  std::function<ReviewedTrial(const BackgroundJob::Control& control)> apply;
  tracking::DetectorMaker snap_to;  // empty: each marker is a patch, looked for as it is where it was measured last
  Json about;                       // AboutMessage in page/messages.ts
};

// A recording of which markers are still to be named.
struct NamingWork {
  // What is there with these options, NamingMessage in page/messages.ts. Throws Error.
  std::function<Json(const Json& options)> find;
  std::function<std::string(const Json&)> said;  // the command line that tracks with these choices; throws Error
  // Tracks with these choices and gives the trial. Throws Error.
  std::function<ReviewedTrial(const Json& choices, const BackgroundJob::Control& control)> track;
};

struct ReviewOptions {
  std::filesystem::path video;
  video::VideoReaderOptions reader;
  PageOptions page;
};

// Serves the page until its last window is closed; one of `trial` and `naming` is there. Throws Error where the port is
// taken or the video cannot be read, Interrupted once a signal has arrived.
void ServeReview(const ReviewOptions& options, std::optional<ReviewedTrial> trial,
                 const std::optional<NamingWork>& naming);

}  // namespace lake::review
