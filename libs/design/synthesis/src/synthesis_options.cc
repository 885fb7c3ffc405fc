#include "lake/synthesis/synthesis_options.h"

#include <fmt/format.h>

#include "lake/core/csv.h"

namespace lake::synthesis {

void Describe(OptimizeOptions& o, OptionList& options) {
  options.Add("starts", o.starts, "Number of starts; all but the first are random within the bounds").AtLeast(1);
  options.Add("seed-number", o.seed, "Random seed");
}

void Describe(SynthesisOptions& o, OptionList& options) {
  Describe(o.optimize, options);
  options.Add("certify", o.certify_gap_deg, "Prove an upper bound on the range to within this gap")
      .Unit("degrees")
      .Positive()
      .Implied(FormatNumber(certificate::CertificateOptions{}.gap_deg));
  options
      .Add("certify-time", o.certify_time_s,
           fmt::format(
               "End that proof after this time with the gap so far, which then depends on the machine, and those "
               "for all margins after as long again together; with or without it each ends after {} steps",
               certificate::CertificateOptions{}.max_boxes))
      .Unit("s")
      .Positive();
  options
      .Add(
          "yield", o.yield_tolerance_mm,
          "The share of builds that keep each limit, and all of them, where every link and the shortest stroke are off "
          "by up to this, and the design whose builds keep them most often; not a requirement")
      .Unit("mm")
      .Positive();
  options.Add("round", o.round_mm, "Also find the best design whose links are multiples of this").Unit("mm").Positive();
}

}  // namespace lake::synthesis
