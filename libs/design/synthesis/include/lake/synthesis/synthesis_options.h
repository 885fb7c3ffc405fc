// The options of an optimum: how it is sought, proved and judged.
#pragma once

#include "lake/core/options.h"
#include "lake/synthesis/synthesis_outcome.h"

namespace lake::synthesis {

void Describe(OptimizeOptions& o, OptionList& options);

// With those of the optimisation.
void Describe(SynthesisOptions& o, OptionList& options);

}  // namespace lake::synthesis
