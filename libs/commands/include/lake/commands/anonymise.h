// The work of lake-anonymise: a copy of a recording that shows no face.
#pragma once

#include <filesystem>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/overlay/head_blur.h"

namespace lake::commands {

struct AnonymiseRunOptions {
  std::filesystem::path video;
  std::filesystem::path trial;  // the lake-track folder of this video
  overlay::AnonymiseOptions copy;
};

void Describe(AnonymiseRunOptions& o, OptionList& options);

// Writes anonymised.mp4 and returns the results for the summary. Throws Error for a folder that was not tracked in this
// video, and as overlay::WriteAnonymisedVideo does.
Json RunAnonymise(const AnonymiseRunOptions& options, Run& run);

}  // namespace lake::commands
