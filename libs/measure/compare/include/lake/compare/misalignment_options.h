// The options of a misalignment.
#pragma once

#include "lake/core/options.h"
#include "lake/compare/misalignment.h"

namespace lake::compare {

void Describe(MisalignmentOptions& o, OptionList& options);

}  // namespace lake::compare
