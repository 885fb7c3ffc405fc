#include "lake/core/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include "lake/core/error.h"

namespace lake {
namespace fs = std::filesystem;

namespace {

// What open() would give a new file; known without changing it only by setting it twice.
mode_t NewFileMode() {
  static const mode_t kMask = [] {
    const mode_t mask = umask(022);
    umask(mask);
    return mask;
  }();
  return 0666 & ~kMask;
}

}  // namespace

AtomicFile::AtomicFile(fs::path final_path) : final_path_(std::move(final_path)) {
  const std::string extension = final_path_.extension().string();
  temporary_path_ = final_path_;
  temporary_path_.replace_filename(fmt::format(".{}.lake-XXXXXX{}", final_path_.stem().string(), extension));
  std::string name = temporary_path_.string();
  const int file = mkostemps(name.data(), static_cast<int>(extension.size()), O_CLOEXEC);
  if (file < 0) throw Fail("{}: cannot be written: {}", final_path_.string(), std::strerror(errno));
  fchmod(file, NewFileMode());
  close(file);
  temporary_path_ = name;
}

AtomicFile::~AtomicFile() {
  std::error_code ignored;
  if (!committed_) fs::remove(temporary_path_, ignored);
}

void AtomicFile::Commit() {
  std::error_code error;
  if (fs::is_empty(temporary_path_, error) && !error) throw Fail("{}: nothing was written", final_path_.string());
  Move();
}

void AtomicFile::Move() {
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
  file.Move();
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
