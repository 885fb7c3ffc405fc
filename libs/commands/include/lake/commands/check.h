// The work of lake-check: what a recording is worth, before the subject goes home.
#pragma once

#include <filesystem>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/tracking/recording_verdicts.h"

namespace lake::commands {

struct CheckRunOptions {
  std::filesystem::path video;
  tracking::RecordingCheckOptions check;
};

void Describe(CheckRunOptions& o, OptionList& options);

// The figures of markers, as both lake-check's and lake-track's summary have them.
Json FiguresJson(const tracking::MarkerFigures& figures);

// Writes check.png and returns the results for the summary; `fit` there is false, and the run rejected, if anything
// makes the recording unfit, or if its markers cannot be named and so are not judged.
Json RunCheck(const CheckRunOptions& options, Run& run);

}  // namespace lake::commands
