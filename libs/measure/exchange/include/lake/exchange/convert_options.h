// The options of a conversion.
#pragma once

#include "lake/core/options.h"
#include "lake/exchange/convert.h"

namespace lake::exchange {

void Describe(ConvertOptions& o, OptionList& options);

// The rate of files without times.
Option& DescribeRate(double& rate_hz, OptionList& options);

}  // namespace lake::exchange
