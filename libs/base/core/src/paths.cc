#include "lake/core/paths.h"

namespace lake {

namespace fs = std::filesystem;

bool LiesIn(const fs::path& path, const fs::path& folder) {
  const fs::path below = fs::weakly_canonical(fs::absolute(path))
                             .lexically_relative((fs::weakly_canonical(fs::absolute(folder)) / "").parent_path());
  return !below.empty() && *below.begin() != "..";
}

}  // namespace lake
