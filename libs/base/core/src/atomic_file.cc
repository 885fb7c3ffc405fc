#include "lake/core/atomic_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>

#include "lake/core/error.h"
#include "lake/core/file_descriptor.h"
#include "lake/core/interrupt.h"

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

// A pipe that nobody writes to yet, or a terminal, can still be interrupted.
void WaitForMore(int file) {
  constexpr int kLook_ms = 100;
  pollfd waiting{file, POLLIN, 0};
  while (poll(&waiting, 1, kLook_ms) <= 0) ThrowIfInterrupted();
}

}  // namespace

AtomicFile::AtomicFile(fs::path final_path) : final_path_(std::move(final_path)) {
  std::error_code error;
  if (const auto status = fs::status(final_path_, error); fs::exists(status) && fs::is_other(status))
    throw Fail("{}: is a pipe or a device, which a file cannot replace; give another name", final_path_.string());
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
  const FileDescriptor file(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (file < 0) throw Fail("{}: cannot be read: {}", path.string(), std::strerror(errno));
  const bool may_wait = !fs::is_regular_file(status);
  std::string text;
  char buffer[1 << 16];
  while (true) {
    if (may_wait) WaitForMore(file);
    const ssize_t size = read(file, buffer, sizeof buffer);
    if (size == 0) return text;
    if (size < 0 && errno != EINTR && errno != EAGAIN)
      throw Fail("{}: cannot be read: {}", path.string(), std::strerror(errno));
    text.append(buffer, static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    if (text.size() > max_bytes)
      throw Fail("{}: larger than {} bytes, as no file of its kind is; was another file meant?", path.string(),
                 max_bytes);
  }
}

}  // namespace lake
