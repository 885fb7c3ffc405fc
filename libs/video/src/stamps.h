// Time stamps of a recording: checked, and their regularity.
#pragma once

#include <cstdint>
#include <optional>

#include "lake/video/video_reader.h"
#include "libav.h"

namespace lake {

// Of the stamps in the container; frames in the order of showing.
class StampCheck {
 public:
  // `time_base`: of the stream's ticks.
  explicit StampCheck(AVRational time_base) : time_base_(time_base) {}

  // Whether `ticks` is there and greater than all before. The statistics take in only such stamps.
  bool Add(std::int64_t ticks);

  std::optional<double> FirstTime_s() const { return Time_s(first_); }
  std::optional<double> LastTime_s() const { return Time_s(last_); }

  void Describe(VideoInfo& info) const;

 private:
  std::optional<double> Time_s(std::int64_t ticks) const;

  AVRational time_base_;
  std::int64_t first_ = AV_NOPTS_VALUE;
  std::int64_t last_ = AV_NOPTS_VALUE;
  std::int64_t intervals_ = 0;
  std::int64_t shortest_ = 0;
  std::int64_t longest_ = 0;
};

}  // namespace lake
