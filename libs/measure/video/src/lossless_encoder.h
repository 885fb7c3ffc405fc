// Raw pictures, as many cameras send them, as FFV1: without loss, each picture by itself (RFC 9043).
#pragma once

#include <memory>
#include <string>

#include "libav.h"

namespace lake::video {

class LosslessEncoder {
 public:
  // `raw`: of the stream; `time_base`: of its packets. Throws Error for pixels that FFV1 does not hold without loss.
  LosslessEncoder(const std::string& input, const AVCodecParameters& raw, AVRational time_base);

  const AVCodecParameters& Parameters() const { return *parameters_; }

  // With the raw packet's stamps. Null where that packet is torn. Throws Error where pictures change their size.
  libav::Packet Encode(const AVPacket& raw);

 private:
  struct Delete {
    void operator()(AVCodecParameters* parameters) const { avcodec_parameters_free(&parameters); }
  };

  void OpenDecoder(const AVCodecParameters& raw);
  void OpenEncoder(AVRational time_base);
  const AVFrame& InEncodersFormat();

  std::string input_;
  libav::Codec decoder_, encoder_;
  int raw_format_ = AV_PIX_FMT_NONE;
  libav::Scaler repack_;  // of pixels in one plane into those of several
  libav::Frame picture_ = libav::NewFrame(), planes_ = libav::NewFrame();
  std::unique_ptr<AVCodecParameters, Delete> parameters_{avcodec_parameters_alloc()};
};

}  // namespace lake::video
