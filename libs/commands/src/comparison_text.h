// What a person wants to read of a comparison, at the terminal.
#pragma once

#include <string>

#include "lake/core/json.h"

namespace lake::commands {

// Of the content of comparison.json, as the report's sections.
std::string ComparisonText(const Json& comparison);

}  // namespace lake::commands
