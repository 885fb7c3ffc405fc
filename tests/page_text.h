// Pages as they are read.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "lake/core/atomic_file.h"

namespace lake {

// With spaces where a line must not end, as elsewhere.
inline std::string WithPlainSpaces(std::string page) {
  constexpr std::string_view kNoBreakSpace = "\u00A0";
  for (std::size_t at = page.find(kNoBreakSpace); at != page.npos; at = page.find(kNoBreakSpace, at + 1))
    page.replace(at, kNoBreakSpace.size(), " ");
  return page;
}

inline std::string ReadPageText(const std::filesystem::path& file) {
  return WithPlainSpaces(ReadTextFile(file));
}

}  // namespace lake
