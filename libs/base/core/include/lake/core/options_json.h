// Options as a summary has them: name → the text that it was given, texts where several may be given.
#pragma once

#include "lake/core/json.h"
#include "lake/core/options.h"

namespace lake {

// Of those that were given.
Json GivenOptionsJson(const OptionList& options);

// Of all; of those that were not given the field's value.
Json OptionsJson(const OptionList& options);

}  // namespace lake
