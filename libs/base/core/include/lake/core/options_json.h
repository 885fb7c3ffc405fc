// Options as a summary has them: name → the text that it was given, texts where several may be given.
#pragma once

#include "lake/core/json.h"
#include "lake/core/options.h"

namespace lake {

// The options that were given.
Json GivenOptionsJson(const OptionList& options);

// All options; where one was not given, the field's value.
Json OptionsJson(const OptionList& options);

}  // namespace lake
