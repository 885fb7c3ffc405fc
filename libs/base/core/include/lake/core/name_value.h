// NAME=VALUE, as options have it.
#pragma once

#include <string>
#include <utility>

namespace lake {

// The name before the first '=' and all that follows it. Throws UsageError that names `option` if there is none.
std::pair<std::string, std::string> SplitNameValue(const std::string& option, const std::string& text);

}  // namespace lake
