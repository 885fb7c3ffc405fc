#include "lake/core/frames_where.h"

#include <fmt/format.h>

namespace lake {

std::string FramesWhere(const std::vector<std::int64_t>& frame, const std::function<bool(std::size_t)>& is_true,
                        int most) {
  std::string text;
  int shown = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    if (!is_true(i)) continue;
    std::size_t last = i;
    while (last + 1 < frame.size() && is_true(last + 1)) ++last;
    if (++shown > most) return text + ", …";
    text += (text.empty() ? "" : ", ") + std::to_string(frame[i]);
    if (last > i) text += fmt::format(" to {}", frame[last]);
    i = last;
  }
  return text;
}

}  // namespace lake
