#include "left_out.h"

#include <fmt/format.h>

#include <algorithm>

namespace lake::exchange {

void LeftOut::Add(const std::string& kind, const std::string& where) {
  const auto found = std::ranges::find(kinds_, kind, &Kind::name);
  Kind& known = found == kinds_.end() ? kinds_.emplace_back(Kind{kind, where}) : *found;
  ++known.count;
}

std::string LeftOut::InBrackets() const {
  std::vector<std::string> warnings;
  AppendTo(warnings);
  return warnings.empty() ? "" : fmt::format(" ({})", warnings.front());
}

void LeftOut::AppendTo(std::vector<std::string>& warnings) const {
  for (const Kind& kind : kinds_)
    warnings.push_back(kind.count == 1 ? fmt::format("{}: {} is left out", kind.first, kind.name)
                                       : fmt::format("{}: {} is left out, the first of {} such places", kind.first,
                                                     kind.name, kind.count));
}

}  // namespace lake::exchange
