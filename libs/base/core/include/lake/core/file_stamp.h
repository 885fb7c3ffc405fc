// The file system's record of a file, which tells without reading whether the content has changed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace lake {

struct FileStamp {
  std::int64_t size = 0, modified_ns = 0, changed_ns = 0;  // bytes; times of the last write and of the last change
  std::uint64_t inode = 0;
  bool is_file = false;      // a regular file; folders and pipes have no usable record
  std::int64_t seen_ns = 0;  // when this was looked up, since 1970

  // nullopt if there is nothing of that name.
  static std::optional<FileStamp> Of(const std::filesystem::path& path);
};

// Whether a file whose content was read right after `known` was looked up still has it: inode, size and both times are
// as they were, and the last change was two seconds old then: no later change can have the same time, even on a file
// system that counts in whole seconds.
bool IsUntouched(const FileStamp& now, const FileStamp& known);

}  // namespace lake
