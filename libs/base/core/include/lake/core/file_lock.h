// One process at a time, by a lock on a file.
#pragma once

#include <filesystem>
#include <functional>

#include "lake/core/file_descriptor.h"

namespace lake {

// An exclusive lock on a file, which is made where it is missing and stays. Held while the object lives, and while a
// process that inherited its descriptor does.
class FileLock {
 public:
  // Waits for other processes and calls `begins_to_wait` once if it must. Throws Error and Interrupted.
  explicit FileLock(const std::filesystem::path& path, const std::function<void()>& begins_to_wait = {});

  // Closed in programs that this process starts, unless they are given it.
  int Descriptor() const { return descriptor_; }

 private:
  FileDescriptor descriptor_;
};

}  // namespace lake
