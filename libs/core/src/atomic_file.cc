#include "lake/core/atomic_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>

#include "lake/core/error.h"

namespace lake {
namespace fs = std::filesystem;

AtomicFile::AtomicFile(fs::path final_path) : final_path_(std::move(final_path)) {
  temporary_path_ = final_path_;
  temporary_path_.replace_filename(
      fmt::format(".{}.{}{}", final_path_.stem().string(), getpid(), final_path_.extension().string()));
}

AtomicFile::~AtomicFile() {
  std::error_code ignored;
  if (!committed_) fs::remove(temporary_path_, ignored);
}

void AtomicFile::Commit() {
  std::error_code error;
  fs::rename(temporary_path_, final_path_, error);
  if (error) throw Fail("{}: cannot be written: {}", final_path_.string(), error.message());
  committed_ = true;
}

void WriteTextFile(const fs::path& path, std::string_view text) {
  AtomicFile file(path);
  std::ofstream stream(file.TemporaryPath(), std::ios::binary);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream) throw Fail("{}: cannot be written: {}", path.string(), std::strerror(errno));
  file.Commit();
}

std::string ReadTextFile(const fs::path& path, std::size_t max_bytes) {
  std::error_code error;
  const auto status = fs::status(path, error);
  if (!fs::exists(status)) throw Fail("{}: no such file", path.string());
  if (fs::is_directory(status)) throw Fail("{}: is a folder, not a file", path.string());
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Fail("{}: cannot be read: {}", path.string(), std::strerror(errno));
  std::string text;
  char buffer[1 << 16];
  while (stream.read(buffer, sizeof(buffer)) || stream.gcount() > 0) {
    text.append(buffer, static_cast<std::size_t>(stream.gcount()));
    if (text.size() > max_bytes) throw Fail("{}: larger than {} bytes, not read", path.string(), max_bytes);
  }
  if (stream.bad()) throw Fail("{}: cannot be read: {}", path.string(), std::strerror(errno));
  return text;
}

}  // namespace lake
