// Where this clone, its programs and other things of the tests are, and how a shell is told of them.
#pragma once

#include <filesystem>
#include <string>

namespace lake {

// As configured, or as the environment says (LAKE_SOURCE, LAKE_BIN): tests that were built elsewhere can be run in
// another clone.
std::filesystem::path SourceDir();
std::filesystem::path BinDir();

// Real recordings; the folder may be absent.
std::filesystem::path SharedData();

// A path as one word of a shell: the clone may stand in a folder with blanks and quotes.
inline std::string Quoted(const std::filesystem::path& path) {
  std::string word = "'";
  for (const char c : path.string()) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

}  // namespace lake
