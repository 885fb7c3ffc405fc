// The figures of a group's curves.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lake::figure {

// A condition's mean over people at 0 .. 100 %, and the interval of the mean; without one `low` and `high` are empty.
struct ConditionCurve {
  bool with_exoskeleton = false;
  std::vector<double> mean, low, high;
  std::size_t people = 0;
};

// PNG or SVG by the extension, as wide as a journal's column: means with their bands over the rise. `axis` names the
// quantity with its unit. Throws Error if it cannot be drawn.
void DrawConditions(const std::filesystem::path& path, const std::vector<ConditionCurve>& curves,
                    const std::string& axis);

}  // namespace lake::figure
