// The sound of a film, on the clock of its frames.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

namespace lake::video {

// What the container says of a piece of sound.
struct SoundStamp {
  std::size_t sample = 0;  // its first
  double time_s = 0;       // by its presentation time stamp, as VideoFrame::time_s
};

// What is known of a sound besides its samples.
struct Sound {
  double rate_hz = 0;  // samples a second
  std::size_t samples = 0;
  std::vector<SoundStamp> stamps = {};
  // A coder puts silence before the first sample (AAC: 1024 to 2112 of them). MP4's edit list tells of it, and it is
  // left out; Matroska and transport streams stamp each packet. Of AVI, and of MP4 without such a list, it is not
  // known: what is heard may have been up to kMostPriming samples earlier than TimeOf says.
  bool is_priming_known = true;
  static constexpr double kMostPriming = 2112;  // of Apple's AAC, the longest in use

  // When this sample was taken. Stamps are rounded (Matroska: 1 ms), so those of the second around it are averaged; not
  // beyond a gap.
  double TimeOf(double sample) const;
};

// Takes the next samples, the mean of the channels; full scale is 1. The rate is the same of all.
using TakeSamples = std::function<void(double rate_hz, std::span<const float> samples)>;

// Of the film's main sound stream, as libav chooses it (default, else the most channels and bits). Its samples go to
// `take` in order, in blocks as they are coded, so that none of a long film are kept here. Throws Error: no file that
// can be read, no sound, damaged sound, a sound that the file ends before.
Sound ReadSound(const std::filesystem::path& path, const TakeSamples& take);

}  // namespace lake::video
