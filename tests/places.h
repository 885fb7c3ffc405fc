// Where this clone, its programs and other things of the tests are, and how a shell is told of them.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace lake {

// As configured, or as the environment says: tests that were built elsewhere can be run in another clone.
inline std::filesystem::path SourceDir() {
  const char* said = std::getenv("LAKE_SOURCE");
  return said ? said : LAKE_SOURCE_DIR;
}

inline std::filesystem::path BinDir() {
  const char* said = std::getenv("LAKE_BIN");
  return said ? said : LAKE_BIN_DIR;
}

// A path as one word of a shell: the clone may stand in a folder with blanks and quotes.
inline std::string Quoted(const std::filesystem::path& path) {
  std::string word = "'";
  for (const char c : path.string()) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

}  // namespace lake
