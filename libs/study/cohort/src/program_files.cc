#include "program_files.h"

#include "lake/core/error.h"

namespace lake::cohort {

namespace fs = std::filesystem;

fs::path ProgramFolder() {
  return fs::read_symlink("/proc/self/exe").parent_path();
}

fs::path SharedFile(const std::string& name) {
  const fs::path path = (ProgramFolder() / "../share/lake/cohort" / name).lexically_normal();
  if (!fs::exists(path)) throw Fail("{}: missing from the installation; install lake again", path.string());
  return path;
}

}  // namespace lake::cohort
