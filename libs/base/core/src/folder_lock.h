// One run at a time in a folder.
#pragma once

#include <filesystem>
#include <memory>

#include "lake/core/file_descriptor.h"

namespace lake {

// Held as long as the object lives; the system gives it up when the process ends, however it ends.
class FolderLock {
 public:
  // The folder must exist. nullptr while another process holds it; a process that holds it already shares it. Throws
  // Error where folders cannot be locked.
  static std::shared_ptr<FolderLock> Take(const std::filesystem::path& folder);

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
  FileDescriptor descriptor_;
};

}  // namespace lake
