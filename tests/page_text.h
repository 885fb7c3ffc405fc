// Pages as they are read.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "lake/core/atomic_file.h"

namespace lake {

// With plain spaces and dashes where a line must not end.
inline std::string WithPlainSpaces(std::string page) {
  for (const auto& [kept, plain] : {std::pair<std::string_view, std::string_view>{"\u00A0", " "}, {"\u2060", ""}})
    for (std::size_t at = page.find(kept); at != page.npos; at = page.find(kept, at))
      page.replace(at, kept.size(), plain);
  return page;
}

inline std::string ReadPageText(const std::filesystem::path& file) {
  return WithPlainSpaces(ReadTextFile(file));
}

}  // namespace lake
