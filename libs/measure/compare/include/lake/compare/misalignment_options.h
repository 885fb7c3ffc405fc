// The options of a misalignment.
#pragma once

#include <array>

#include "lake/compare/misalignment.h"
#include "lake/core/options.h"

namespace lake::compare {

void Describe(MisalignmentOptions& o, OptionList& options);
void DescribeReplacement(double& sd_mm, OptionList& options);  // --replacement-sd

// --joint-at, RegistrationOptions::marker_at_mm as it is given.
void DescribeJointAt(std::array<double, 2>& joint_at_mm, OptionList& options);

}  // namespace lake::compare
