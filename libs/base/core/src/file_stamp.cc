#include "lake/core/file_stamp.h"

#include <sys/stat.h>

#include <chrono>

namespace lake {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

std::int64_t Nanoseconds(const timespec& time) {
  return time.tv_sec * kNanosecondsPerSecond + time.tv_nsec;
}

std::int64_t Now() {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
}

}  // namespace

std::optional<FileStamp> FileStamp::Of(const std::filesystem::path& path) {
  FileStamp stamp;
  stamp.seen_ns = Now();
  struct stat status;
  if (stat(path.c_str(), &status) != 0) return std::nullopt;
  stamp.size = status.st_size;
  stamp.inode = status.st_ino;
  stamp.modified_ns = Nanoseconds(status.st_mtim);
  stamp.changed_ns = Nanoseconds(status.st_ctim);
  stamp.is_file = S_ISREG(status.st_mode);
  return stamp;
}

bool IsUntouched(const FileStamp& now, const FileStamp& known) {
  constexpr std::int64_t kSettled = 2 * kNanosecondsPerSecond;
  return now.is_file && now.inode == known.inode && now.size == known.size && now.modified_ns == known.modified_ns &&
         now.changed_ns == known.changed_ns && known.changed_ns + kSettled < known.seen_ns;
}

}  // namespace lake
