#include "folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <utility>

#include "lake/core/error.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using Identity = std::pair<dev_t, ino_t>;

std::mutex held_mutex;
std::map<Identity, std::weak_ptr<FolderLock>> held;

}  // namespace

std::shared_ptr<FolderLock> FolderLock::Take(const fs::path& folder) {
  const std::scoped_lock guard(held_mutex);
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw Fail("{}: the output folder cannot be opened: {}", folder.string(), std::strerror(errno));
  std::shared_ptr<FolderLock> lock(new FolderLock(descriptor));
  struct stat status;
  if (fstat(descriptor, &status) != 0) throw Fail("{}: {}", folder.string(), std::strerror(errno));
  std::weak_ptr<FolderLock>& known = held[{status.st_dev, status.st_ino}];
  if (auto own = known.lock()) return own;
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return nullptr;
    throw Fail("{}: the output folder cannot be locked ({}); choose one on another file system with -o",
               folder.string(), std::strerror(errno));
  }
  known = lock;
  return lock;
}

}  // namespace lake
