// The options of a misalignment.
#pragma once

#include "lake/compare/misalignment.h"
#include "lake/core/options.h"

namespace lake::compare {

void Describe(MisalignmentOptions& o, OptionList& options);

}  // namespace lake::compare
