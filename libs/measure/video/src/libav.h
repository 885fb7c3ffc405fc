// Owners of libav's objects, and its errors as text.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/dict.h>
#include <libswscale/swscale.h>
}

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace lake::video::libav {

struct Delete {
  void operator()(AVFormatContext* input) const { avformat_close_input(&input); }
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};

using Input = std::unique_ptr<AVFormatContext, Delete>;
using Codec = std::unique_ptr<AVCodecContext, Delete>;
using Frame = std::unique_ptr<AVFrame, Delete>;
using Packet = std::unique_ptr<AVPacket, Delete>;
using Scaler = std::unique_ptr<SwsContext, Delete>;

// These throw std::bad_alloc when there is no memory.
Frame NewFrame();
Packet NewPacket();
Codec NewCodec(const AVCodec* codec);

// Options by name for libav's open functions, which take out those they know.
class Dictionary {
 public:
  Dictionary() = default;
  Dictionary(const Dictionary&) = delete;
  Dictionary& operator=(const Dictionary&) = delete;
  ~Dictionary() { av_dict_free(&entries_); }

  void Set(const char* name, const std::string& value) { av_dict_set(&entries_, name, value.c_str(), 0); }
  void Set(const char* name, std::int64_t value) { av_dict_set_int(&entries_, name, value, 0); }
  AVDictionary** Get() { return &entries_; }

 private:
  AVDictionary* entries_ = nullptr;
};

std::string ErrorText(int error);

// A path as libav's protocols understand it: never a URL, whatever its name looks like.
std::string FileUrl(const std::filesystem::path& path);

// The nearest double to ticks * time_base.
double Seconds(std::int64_t ticks, AVRational time_base);

inline constexpr int kMaxSide_px = 16384;
inline constexpr std::int64_t kMaxPixels = 200'000'000;

}  // namespace lake::video::libav
