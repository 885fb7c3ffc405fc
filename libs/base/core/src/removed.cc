#include "lake/core/removed.h"

#include <fmt/format.h>

namespace lake {

std::span<const Removed> AllRemoved() {
  static constexpr Removed kRemoved[] = {
      {"lake-compare", "--left", "", "both legs of one person are compared by lake symmetry LEFT RIGHT"},
      {"lake-compare", "--right", "", "both legs of one person are compared by lake symmetry LEFT RIGHT"},
      {"lake-export", "sdf", "", "write urdf, which Gazebo reads ('gz sdf -p design.urdf' converts it)"},
      {"lake-stroke", "validate-bench", "", "compare the bench's logs with RISKS.md, as BENCH.md says"},
      {"lake-stroke", "--board", "board", "the firmware is for an Arduino UNO"},
      {"lake-stroke", "--bridge", "bridge", "the bridge is an L298N"},
      {"lake-stroke", "--worn", "worn", "nobody may wear what this firmware drives, so there is no mode for it"},
      {"lake-stroke", "--worn-timeout", "worn_timeout_s", "--command-timeout holds for every program"},
      {"lake-stroke", "--button", "button", "there is no wearer's button; '!' and the emergency stop end a motion"},
  };
  return kRemoved;
}

std::string WhyRemoved(std::string_view program, std::string_view word) {
  if (word.starts_with("--")) word = word.substr(0, word.find('='));
  for (const Removed& removed : AllRemoved())
    if (removed.program == program && removed.name == word)
      return fmt::format("{} is removed: {}", removed.name, removed.instead);
  return {};
}

}  // namespace lake
