#include "lake/compare/misalignment_options.h"

namespace lake::compare {

void Describe(MisalignmentOptions& o, OptionList& options) {
  options
      .Add("replacement-sd", o.replacement_sd_mm,
           "How well a marker is put back on the same spot between trials, per axis; 0 when both are in one recording")
      .Unit("mm")
      .NotNegative();
  options.Add("resamples", o.resamples, "Of the bootstrap intervals; 0: none");
  options.Add("seed-number", o.seed, "Of the bootstrap");
}

}  // namespace lake::compare
