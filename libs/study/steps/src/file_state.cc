#include "file_state.h"

#include <sys/stat.h>

#include <chrono>

#include "lake/core/provenance.h"

namespace lake::steps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAbsent = "absent";
constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

std::int64_t Nanoseconds(const timespec& time) {
  return time.tv_sec * kNanosecondsPerSecond + time.tv_nsec;
}

std::int64_t Now() {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
}

bool IsUntouched(const FileState& now, const FileState& known) {
  constexpr std::int64_t kSettled = 2 * kNanosecondsPerSecond;
  return now.inode == known.inode && now.size == known.size && now.modified_ns == known.modified_ns &&
         now.changed_ns == known.changed_ns && known.changed_ns + kSettled < known.seen_ns;
}

}  // namespace

bool FileState::IsAbsent() const {
  return sha256 == kAbsent;
}

FileState StateOf(const fs::path& path, const FileState* known) {
  FileState state;
  state.path = path;
  state.seen_ns = Now();
  struct stat status;
  if (stat(path.c_str(), &status) != 0) {
    state.sha256 = kAbsent;
    return state;
  }
  state.size = status.st_size, state.inode = status.st_ino;
  state.modified_ns = Nanoseconds(status.st_mtim), state.changed_ns = Nanoseconds(status.st_ctim);
  const bool is_file = S_ISREG(status.st_mode);
  if (is_file && known && IsUntouched(state, *known))
    state.sha256 = known->sha256, state.seen_ns = known->seen_ns;
  else
    state.sha256 = Sha256OfFile(path);
  return state;
}

Json FileStateJson(const FileState& state) {
  return {{"path", state.path.string()},      {"sha256", state.sha256},         {"size", state.size},
          {"modified_ns", state.modified_ns}, {"changed_ns", state.changed_ns}, {"inode", state.inode},
          {"seen_ns", state.seen_ns}};
}

FileState FileStateFrom(const Json& json) {
  FileState state;
  state.path = json.at("path").get<std::string>(), state.sha256 = json.at("sha256").get<std::string>();
  state.size = json.at("size"), state.inode = json.at("inode"), state.seen_ns = json.at("seen_ns");
  state.modified_ns = json.at("modified_ns"), state.changed_ns = json.at("changed_ns");
  return state;
}

}  // namespace lake::steps
