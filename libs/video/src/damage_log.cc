#include "damage_log.h"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <string_view>

namespace lake {
namespace {

// Said by the decoders when part of a picture could not be decoded: block-based codecs, their error concealment, MJPEG.
constexpr std::array<std::string_view, 5> kDecoderReports = {"error while decoding MB", "concealing ",
                                                             "error count: ", "error y=", "overread "};
// Matroska.
constexpr std::string_view kFileIsCut = "File ended prematurely";

}  // namespace

void DamageLog::Receive(void* source, int level, const char* format, va_list) {
  if (!source || level > AV_LOG_INFO) return;
  const AVClass* kind = *static_cast<const AVClass**>(source);
  const std::string_view text = format;
  const auto says = [&](std::string_view report) { return text.find(report) != std::string_view::npos; };
  if (kind == avcodec_get_class()) {
    const auto& codec = *static_cast<const AVCodecContext*>(source);
    const bool damaged = std::any_of(kDecoderReports.begin(), kDecoderReports.end(), says);
    if (damaged && codec.opaque) static_cast<DamageLog*>(codec.opaque)->NoteDamage(codec.reordered_opaque);
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

}  // namespace lake
