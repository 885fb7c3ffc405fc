// The content of a file, found again without reading it where that is certain.
#pragma once

#include <filesystem>
#include <string>

#include "lake/core/file_stamp.h"
#include "lake/core/json.h"

namespace lake::steps {

struct FileState {
  std::filesystem::path path;
  std::string sha256;  // "absent" if there is none
  FileStamp stamp;     // looked up before its content was read

  bool IsAbsent() const;
};

// Of a file, a folder (its files) or nothing. The hash of `known` is taken over without reading where the file is
// untouched since (IsUntouched).
FileState StateOf(const std::filesystem::path& path, const FileState* known = nullptr);

Json FileStateJson(const FileState& state);
FileState FileStateFrom(const Json& json);

}  // namespace lake::steps
