// The content of a file, found again without reading it where that is certain.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "lake/core/json.h"

namespace lake::steps {

struct FileState {
  std::filesystem::path path;
  std::string sha256;  // "absent" if there is none
  std::int64_t size = 0, modified_ns = 0, changed_ns = 0;
  std::uint64_t inode = 0;
  std::int64_t seen_ns = 0;  // when its content was read

  bool IsAbsent() const;
};

// Of a file, a folder (its files) or nothing. The hash of `known` is taken over without reading where inode, size, and
// the times of the last write and of the last change are as they were, and the last change was two seconds old when it
// was read: no later change can then have the same time, even on a file system that counts in whole seconds.
FileState StateOf(const std::filesystem::path& path, const FileState* known = nullptr);

Json FileStateJson(const FileState& state);
FileState FileStateFrom(const Json& json);

}  // namespace lake::steps
