#include "lake/core/name_value.h"

#include "lake/core/error.h"

namespace lake {

std::pair<std::string, std::string> SplitNameValue(const std::string& option, const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) throw UsageError("{} '{}': write it as NAME=VALUE", option, text);
  return {text.substr(0, equals), text.substr(equals + 1)};
}

}  // namespace lake
