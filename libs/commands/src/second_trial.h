// Options by which a program reads its second trial.
#pragma once

#include <string>

#include "lake/core/options.h"
#include "lake/exchange/trial.h"
#include "lake/gait/picture_scale.h"

namespace lake::commands {

struct TrialReading {
  exchange::TrialOptions& file;
  gait::PictureScale& picture;
};

// --map, --unit, --camera, --scale and --plane-points of the second trial, as --exo-map with the prefix `exo`; `whose`:
// "the exoskeleton trial". All else, and what is not given, is as for the first.
void DescribeSecond(const std::string& prefix, const std::string& whose, TrialReading first, TrialReading second,
                    OptionList& options);

}  // namespace lake::commands
