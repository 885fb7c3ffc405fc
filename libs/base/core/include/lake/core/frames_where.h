// Frames in words.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace lake {

// "3, 8, 13 to 15, …": those frames of a recording of which something is true, by their place in it, `most` runs of
// them.
std::string FramesWhere(const std::vector<std::int64_t>& frame, const std::function<bool(std::size_t)>& is_true,
                        int most);

}  // namespace lake
