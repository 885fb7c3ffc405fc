#include "lake/core/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

void WaitFor(int descriptor, const fs::path& path, const std::function<void()>& begins_to_wait) {
  constexpr std::chrono::milliseconds kNap(100);
  for (bool waits = false; flock(descriptor, LOCK_EX | LOCK_NB) != 0; waits = true) {
    if (errno != EWOULDBLOCK && errno != EINTR)
      throw Fail("{}: cannot be locked: {}", path.string(), std::strerror(errno));
    if (!waits && begins_to_wait) begins_to_wait();
    ThrowIfInterrupted();
    std::this_thread::sleep_for(kNap);
  }
}

}  // namespace

FileLock::FileLock(const fs::path& path, const std::function<void()>& begins_to_wait)
    : descriptor_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
  if (descriptor_ < 0) throw Fail("{}: {}", path.string(), std::strerror(errno));
  WaitFor(descriptor_, path, begins_to_wait);
}

}  // namespace lake
