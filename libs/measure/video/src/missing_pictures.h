// Pictures that a stream's time stamps leave room for and that never came: dropped by a camera or lost on the way.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lake::video {

// A gap is an interval of more than one and a half of the usual one, which is the median of the last kRemembered. Where
// so many follow one another the rate has become another, and nothing is missing.
class MissingPictures {
 public:
  // A packet's stamp, in any unit; they increase.
  void Add(std::int64_t ticks);

  std::int64_t Missing() const { return missing_; }
  std::int64_t Gaps() const { return gaps_; }
  std::int64_t LongestTicks() const { return longest_; }

 private:
  static constexpr std::size_t kRemembered = 9;

  std::array<std::int64_t, kRemembered> last_ = {};  // intervals, in a ring
  std::int64_t intervals_ = 0;
  std::int64_t previous_ = 0;
  bool has_previous_ = false;
  std::int64_t in_row_ = 0, missing_in_row_ = 0;  // gaps up to now without a usual interval between them
  std::int64_t missing_ = 0, gaps_ = 0, longest_ = 0;
  std::int64_t longest_before_row_ = 0;
};

}  // namespace lake::video
