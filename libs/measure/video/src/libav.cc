#include "libav.h"

#include <new>

namespace lake::video::libav {

Frame NewFrame() {
  if (AVFrame* frame = av_frame_alloc()) return Frame(frame);
  throw std::bad_alloc();
}

Packet NewPacket() {
  if (AVPacket* packet = av_packet_alloc()) return Packet(packet);
  throw std::bad_alloc();
}

Codec NewCodec(const AVCodec* codec) {
  if (AVCodecContext* context = avcodec_alloc_context3(codec)) return Codec(context);
  throw std::bad_alloc();
}

std::string ErrorText(int error) {
  if (error == AVERROR_EXTERNAL) return "the codec's library gave up; too little memory is the usual reason";
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof(text));
  return text;
}

std::string FileUrl(const std::filesystem::path& path) {
  return "file:" + path.string();
}

double Seconds(std::int64_t ticks, AVRational time_base) {
  return static_cast<double>(ticks) * time_base.num / time_base.den;
}

}  // namespace lake::video::libav
