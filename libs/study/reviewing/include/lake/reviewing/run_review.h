// The work of lake-review: a local page on which a trial is looked at and corrected, or a video's markers are named.
#pragma once

#include <filesystem>

#include "lake/core/options.h"
#include "lake/gait/movement.h"
#include "lake/review/review.h"
#include "lake/reviewing/tracked_folder.h"

namespace lake::reviewing {

struct ReviewRunOptions {
  std::filesystem::path subject;  // a folder of results, a design.yaml, or a video
  std::filesystem::path problem;  // of a design: its limits; empty: those it was optimised with, else the paper's
  double capture_rate_hz = 0;     // of a video: as lake-track's
  std::optional<gait::MovementKind> movement;  // in the place of the trial's own
  review::PageOptions page;
};

void Describe(ReviewRunOptions& o, OptionList& options);

// The trial of a folder, for the page: its fit is lake-track's, each correction is saved in the folder, and
// `programs`/lake-track applies them.
review::ReviewedTrial ReviewedTrialOf(TrackedFolder folder, const std::filesystem::path& programs);

// Prints the page's address and serves it until its last window is closed. Corrections are written into the folder:
// corrections.csv, events_corrected.csv and review.json. Programs are run from the folder `programs`; of a video,
// lake-track writes into its default folder. Throws Error, also where the port is taken; Interrupted once a signal has
// arrived.
void RunReview(const ReviewRunOptions& options, const std::filesystem::path& programs);

}  // namespace lake::reviewing
