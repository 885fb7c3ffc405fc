// What the fuzz targets share: bytes as a file, and an Error as the answer that a damaged file may get.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "lake/core/error.h"

namespace lake {

// `read` takes a path; the readers work on files. Each process has its own.
template <typename Reader>
int ReadBytes(const std::uint8_t* data, std::size_t size, const std::string& ending, Reader read) {
  static const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("lake-fuzz-" + std::to_string(getpid()) + ending);
  {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  }
  try {
    read(path);
  } catch (const Error&) {
  }
  std::filesystem::remove(path);
  return 0;
}

}  // namespace lake
