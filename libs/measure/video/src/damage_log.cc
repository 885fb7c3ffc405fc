#include "damage_log.h"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <string_view>

namespace lake::video {
namespace {

// Said by the decoders when part of a picture could not be decoded: block-based codecs, their error concealment, MJPEG.
constexpr std::array<std::string_view, 5> kDecoderReports = {"error while decoding MB", "concealing ",
                                                             "error count: ", "error y=", "overread "};
// Matroska.
constexpr std::string_view kFileIsCut = "File ended prematurely";

// libavcodec 60 (FFmpeg 6) brought the flag that hands a packet's opaque on to its frame, 61 took away what did so
// before.
#ifdef AV_CODEC_FLAG_COPY_OPAQUE
void NumberFrames(AVCodecContext& codec) {
  codec.flags |= AV_CODEC_FLAG_COPY_OPAQUE;
}
void NumberFrameOf(AVCodecContext&, AVPacket& packet, std::int64_t number) {
  packet.opaque = reinterpret_cast<void*>(static_cast<std::intptr_t>(number));
}
std::int64_t NumberOf(const AVFrame& frame) {
  return reinterpret_cast<std::intptr_t>(frame.opaque);
}
#else
void NumberFrames(AVCodecContext&) {}
void NumberFrameOf(AVCodecContext& codec, AVPacket&, std::int64_t number) {
  codec.reordered_opaque = number;
}
std::int64_t NumberOf(const AVFrame& frame) {
  return frame.reordered_opaque;
}
#endif

}  // namespace

void DamageLog::Attach(AVCodecContext& codec) {
  sent_packets_[sent_] = {this, kMayFail};
  codec.opaque = &sent_packets_[sent_];
  NumberFrames(codec);
}

void DamageLog::SetPacket(AVCodecContext& codec, AVPacket& packet, std::int64_t number) {
  sent_ = (sent_ + 1) % sent_packets_.size();
  sent_packets_[sent_] = {this, number};
  codec.opaque = &sent_packets_[sent_];
  NumberFrameOf(codec, packet, number);
}

std::int64_t DamageLog::PacketOf(const AVFrame& frame) {
  return NumberOf(frame);
}

std::optional<std::int64_t> DamageLog::TakeDamage() {
  const std::int64_t first = first_damaged_packet_.exchange(kNone);
  return first == kNone ? std::nullopt : std::optional(first);
}

void DamageLog::Receive(void* source, int level, const char* format, va_list) {
  if (!source || level > AV_LOG_INFO) return;
  const AVClass* kind = *static_cast<const AVClass**>(source);
  const std::string_view text = format;
  const auto says = [&](std::string_view report) { return text.find(report) != std::string_view::npos; };
  if (kind == avcodec_get_class()) {
    const auto& codec = *static_cast<const AVCodecContext*>(source);
    const bool damaged = std::any_of(kDecoderReports.begin(), kDecoderReports.end(), says);
    const auto* packet = static_cast<const SentPacket*>(codec.opaque);
    if (damaged && packet) packet->log->NoteDamage(packet->number);
  } else if (kind == avformat_get_class()) {
    const auto& input = *static_cast<const AVFormatContext*>(source);
    if (input.opaque && says(kFileIsCut)) static_cast<DamageLog*>(input.opaque)->file_is_cut_ = true;
  }
}

// Called from the decoder's threads.
void DamageLog::NoteDamage(std::int64_t packet) {
  if (packet == kMayFail) return;
  std::int64_t first = first_damaged_packet_;
  while (packet < first && !first_damaged_packet_.compare_exchange_weak(first, packet)) {
  }
}

}  // namespace lake::video
