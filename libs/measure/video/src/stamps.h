// Time stamps of a recording: checked, repaired where that is safe, and their regularity.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "lake/video/video_reader.h"
#include "libav.h"

namespace lake::video {

// Of frames in the order of showing, in ticks of the stream.
class Stamps {
 public:
  // `usual_ticks`: how long a frame usually lasts; 0 if unknown.
  Stamps(AVRational time_base, std::int64_t usual_ticks) : time_base_(time_base), usual_ticks_(usual_ticks) {}

  // Takes the next frame's stamp, AV_NOPTS_VALUE if it has none, and its duration, 0 if unknown. A frame without a
  // stamp comes a duration after the one before it (AVI and MPEG-PS keep none for the last frames). False if the stamp
  // is of no use: it does not increase, or there is none and nothing to repair it from; Problem() then says which.
  bool Add(std::int64_t ticks, std::int64_t duration);

  const std::string& Problem() const { return problem_; }

  // In seconds; Last() only once a stamp was taken.
  std::optional<double> First() const;
  double Last() const { return libav::Seconds(last_, time_base_); }

  void Describe(VideoInfo& info) const;

 private:
  AVRational time_base_;
  std::int64_t usual_ticks_;
  std::int64_t first_ = AV_NOPTS_VALUE;
  std::int64_t last_ = AV_NOPTS_VALUE;
  std::int64_t intervals_ = 0;
  std::int64_t shortest_ = 0;
  std::int64_t longest_ = 0;
  std::int64_t repaired_ = 0;
  std::string problem_;
};

}  // namespace lake::video
