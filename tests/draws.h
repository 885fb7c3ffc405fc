// How many of its random draws a test tries: some each time, all of them by scripts/test.sh --nightly.
#pragma once

#include <cstdlib>

namespace lake {

inline unsigned Draws(unsigned each_time, unsigned nightly) {
  return std::getenv("LAKE_LONG_TESTS") ? nightly : each_time;
}

}  // namespace lake
