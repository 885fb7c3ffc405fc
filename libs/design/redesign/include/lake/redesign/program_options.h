// The options of a stroke program that is sought.
#pragma once

#include "lake/core/options.h"
#include "lake/redesign/redesign_problem.h"

namespace lake::redesign {

void Describe(ProgramLimits& o, OptionList& options);

}  // namespace lake::redesign
