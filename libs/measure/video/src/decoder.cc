#include "decoder.h"

#include <algorithm>

#include "lake/core/error.h"
#include "lake/core/threads.h"

namespace lake::video {

Decoder::Decoder(const std::filesystem::path& path, double capture_rate_hz, bool skip_deblocking,
                 std::optional<double> seek_s)
    : demuxer_(path, capture_rate_hz, log_) {
  const AVCodecParameters& stored = *demuxer_.Stream().codecpar;
  if (stored.width <= 0 || stored.height <= 0)
    throw Fail("{}: its picture size cannot be found; it is damaged, or larger than {} Mpx", path.string(),
               libav::kMaxPixels / 1'000'000);
  CheckSize(stored.width, stored.height);
  if (seek_s) demuxer_.SeekKeyFrame(*seek_s);
  Open(skip_deblocking);
}

void Decoder::Open(bool skip_deblocking) {
  const AVStream& stream = demuxer_.Stream();
  const AVCodec* decoder = avcodec_find_decoder(stream.codecpar->codec_id);
  if (!decoder)
    throw Fail("{}: no decoder for {}", demuxer_.Path().string(), avcodec_get_name(stream.codecpar->codec_id));
  codec_ = libav::NewCodec(decoder);
  avcodec_parameters_to_context(codec_.get(), stream.codecpar);
  log_.Attach(*codec_);
  codec_->pkt_timebase = stream.time_base;
  // More than there are cores, as each frame waits for parts of the one before; not for pictures that are only looked
  // at, where others have work meanwhile and more frames at once than the cache holds cost a tenth.
  constexpr int kMoreThreads = 2, kMostThreads = 16;
  const int more = Threads() == 1 || skip_deblocking ? 0 : kMoreThreads;
  codec_->thread_count = std::min(Threads() + more, kMostThreads);
  codec_->thread_type = FF_THREAD_FRAME | FF_THREAD_SLICE;
  if (skip_deblocking) codec_->skip_loop_filter = AVDISCARD_ALL;
  codec_->flags |= AV_CODEC_FLAG_UNALIGNED;  // crop to the pixel
  // HEVC slices that fail, and pictures that are not what their hash says, are passed over otherwise.
  if (decoder->id == AV_CODEC_ID_HEVC) codec_->err_recognition |= AV_EF_CRCCHECK | AV_EF_EXPLODE;
  codec_->max_pixels = libav::kMaxPixels;
  const int result = avcodec_open2(codec_.get(), decoder, nullptr);
  if (result < 0)
    throw Fail("{}: the {} decoder cannot be started ({})", demuxer_.Path().string(), decoder->name,
               libav::ErrorText(result));
}

void Decoder::CheckSize(int width, int height) const {
  if (width > libav::kMaxSide_px || height > libav::kMaxSide_px || std::int64_t{width} * height > libav::kMaxPixels)
    throw Fail("{}: {}×{} px is too large; at most {} px a side and {} Mpx", demuxer_.Path().string(), width, height,
               libav::kMaxSide_px, libav::kMaxPixels / 1'000'000);
}

std::shared_ptr<AVFrame> Decoder::Next() {
  std::shared_ptr<AVFrame> frame = libav::NewFrame();
  const bool received = Receive(*frame);
  if (const std::string& damage = demuxer_.Damage(); !damage.empty()) {
    const bool before_damage = received && frame->best_effort_timestamp != AV_NOPTS_VALUE &&
                               frame->best_effort_timestamp < demuxer_.LastDecodingTicks();
    if (!before_damage) FailAtNext(damage);
  }
  if (!received) return nullptr;
  CheckSize(frame->width, frame->height);
  CheckIsWhole(*frame);
  ++frames_;
  return frame;
}

bool Decoder::Receive(AVFrame& frame) {
  while (true) {
    const int result = avcodec_receive_frame(codec_.get(), &frame);
    if (result >= 0) return true;
    if (result == AVERROR_EOF) return false;
    if (result == AVERROR(EAGAIN))
      Feed();
    else if (!IsBeforeFirstKeyFrame())
      FailAtNext(fmt::format("cannot be decoded ({})", libav::ErrorText(result)));
  }
}

void Decoder::Feed() {
  const bool more = demuxer_.Read(*packet_);
  if (more) NumberPacket();
  const int result = avcodec_send_packet(codec_.get(), more ? packet_.get() : nullptr);
  av_packet_unref(packet_.get());
  if (result < 0 && result != AVERROR_EOF && !IsBeforeFirstKeyFrame())
    FailAtNext(fmt::format("cannot be decoded ({})", libav::ErrorText(result)));
}

// A recording that was cut without encoding it anew may begin with packets that need pictures from before the cut;
// players leave them out.
void Decoder::NumberPacket() {
  const bool is_key = packet_->flags & AV_PKT_FLAG_KEY;
  if (is_key && !any_key_sent_) {
    any_key_sent_ = true;
    first_key_ticks_ = packet_->pts;
  }
  const bool is_leading = !any_key_sent_ || (packet_->pts != AV_NOPTS_VALUE && packet_->pts < first_key_ticks_);
  log_.SetPacket(*codec_, *packet_, is_leading ? DamageLog::kMayFail : packets_);
  ++packets_;
  bytes_ += packet_->size;
}

void Decoder::CheckIsWhole(const AVFrame& frame) const {
  const bool flagged = (frame.flags & AV_FRAME_FLAG_CORRUPT) || frame.decode_error_flags != 0;
  if (flagged || log_.IsDamagedUpTo(DamageLog::PacketOf(frame)))
    FailAtNext("is damaged: parts of the picture, or of one that it builds on, are missing");
}

void Decoder::FailAtNext(const std::string& what) const {
  throw Fail("{} {}", demuxer_.Where(frames_), what);
}

}  // namespace lake::video
