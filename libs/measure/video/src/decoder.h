// Whole frames of a video in the order of showing; a damaged one is an error.
#pragma once

#include <memory>

#include "damage_log.h"
#include "demuxer.h"
#include "libav.h"

namespace lake::video {

class Decoder {
 public:
  // Throws Error as Demuxer does, and when there is no decoder or the picture is too large.
  // Begins at the key frame before `seek_s`, if given.
  Decoder(const std::filesystem::path& path, double capture_rate_hz, bool skip_deblocking = false,
          std::optional<double> seek_s = {});

  const Demuxer& Source() const { return demuxer_; }

  // Of the packets sent so far.
  double BitsPerPicture() const { return 8 * static_cast<double>(bytes_) / static_cast<double>(packets_); }

  // Null after the last one. Throws Error naming the frame if it is not whole. The frames before are handed out; of
  // those that stand after missing ones, none.
  std::shared_ptr<AVFrame> Next();

 private:
  void Open(bool skip_deblocking);
  void CheckSize(int width, int height) const;
  bool Receive(AVFrame& frame);
  void Feed();
  void NumberPacket();
  void CheckIsWhole(const AVFrame& frame) const;
  bool IsBeforeFirstKeyFrame() const { return frames_ == 0 && !any_key_sent_; }
  [[noreturn]] void FailAtNext(const std::string& what) const;

  DamageLog log_;
  Demuxer demuxer_;
  libav::Codec codec_;
  libav::Packet packet_ = libav::NewPacket();
  std::int64_t packets_ = 0, bytes_ = 0;
  std::int64_t frames_ = 0;
  bool any_key_sent_ = false;
  std::int64_t first_key_ticks_ = AV_NOPTS_VALUE;
};

}  // namespace lake::video
