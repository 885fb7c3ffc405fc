#include "lake/video/sound.h"

extern "C" {
#include <libavutil/channel_layout.h>
#include <libswresample/swresample.h>
}

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

#include "damage_log.h"
#include "demuxer.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "libav.h"

namespace lake::video {

namespace {

namespace fs = std::filesystem;

struct FreeResampler {
  void operator()(SwrContext* resampler) const { swr_free(&resampler); }
};
using Resampler = std::unique_ptr<SwrContext, FreeResampler>;

// Coded such that silence goes before the first sample, of which the container has to tell.
bool IsPrimed(const AVCodecParameters& coded) {
  const AVCodecDescriptor* descriptor = avcodec_descriptor_get(coded.codec_id);
  const bool is_exact = !descriptor || (descriptor->props & AV_CODEC_PROP_LOSSLESS) != 0;
  return !is_exact && av_get_exact_bits_per_sample(coded.codec_id) == 0 && coded.codec_id != AV_CODEC_ID_VORBIS;
}

// With a stamp for each packet, which is that of what is heard, whatever stands before it. Others count samples.
bool StampsWhatIsHeard(const AVFormatContext& input) {
  constexpr std::array<std::string_view, 3> kStamped = {"matroska,webm", "mpegts", "mpeg"};
  return std::ranges::find(kStamped, std::string_view(input.iformat->name)) != kStamped.end();
}

class SoundReader {
 public:
  SoundReader(const fs::path& path, const TakeSamples& take) : path_(path), take_(take) {
    input_ = OpenFilm(path, log_);
    const int best = av_find_best_stream(input_.get(), AVMEDIA_TYPE_AUDIO, -1, -1, nullptr, 0);
    if (best < 0) throw Fail("{}: holds no sound", path_.string());
    stream_ = input_->streams[best];
    for (unsigned i = 0; i < input_->nb_streams; ++i)
      if (static_cast<int>(i) != best) input_->streams[i]->discard = AVDISCARD_ALL;
    packets_promised_ = PacketsInIndex(*input_, *stream_);
    OpenDecoder();
  }

  Sound Read() {
    const libav::Packet packet = libav::NewPacket();
    int result = 0;
    while ((result = av_read_frame(input_.get(), packet.get())) >= 0) {
      ThrowIfInterrupted();
      if (packet->stream_index == stream_->index) {
        Send(packet.get());
        ++packets_;
      }
      av_packet_unref(packet.get());
    }
    if (packets_promised_ && packets_ < *packets_promised_)
      throw Fail(
          "{}: its sound is cut off: the file ends after {} of its {} packets; copy the file from the camera again",
          path_.string(), packets_, *packets_promised_);
    if (result != AVERROR_EOF || log_.IsFileCut()) FailDamaged(result == AVERROR_EOF ? AVERROR_INVALIDDATA : result);
    Send(nullptr);
    if (sound_.samples == 0) throw Fail("{}: its sound is empty", path_.string());
    sound_.is_priming_known = tells_priming_ || !IsPrimed(*stream_->codecpar) || StampsWhatIsHeard(*input_);
    return std::move(sound_);
  }

 private:
  void OpenDecoder() {
    const AVCodec* decoder = avcodec_find_decoder(stream_->codecpar->codec_id);
    if (!decoder)
      throw Fail("{}: no decoder for its sound ({})", path_.string(), avcodec_get_name(stream_->codecpar->codec_id));
    codec_ = libav::NewCodec(decoder);
    const int set = avcodec_parameters_to_context(codec_.get(), stream_->codecpar);
    if (set < 0) FailDamaged(set);
    codec_->pkt_timebase = stream_->time_base;  // stamps move with the samples that are left out
    const int result = avcodec_open2(codec_.get(), decoder, nullptr);
    if (result < 0) FailDamaged(result);
  }

  [[noreturn]] void FailDamaged(int result) const {
    throw Fail("{}: its sound is damaged after {} samples ({})", path_.string(), sound_.samples,
               libav::ErrorText(result));
  }

  // Upon nullptr what the decoder still holds comes out.
  void Send(const AVPacket* packet) {
    if (packet && packet->size == 0) return;  // would end the decoding
    if (packet && av_packet_get_side_data(packet, AV_PKT_DATA_SKIP_SAMPLES, nullptr) && sound_.samples == 0)
      tells_priming_ = true;
    if (packet && (packet->flags & AV_PKT_FLAG_CORRUPT)) FailDamaged(AVERROR_INVALIDDATA);
    const int sent = avcodec_send_packet(codec_.get(), packet);
    if (sent < 0) FailDamaged(sent);
    int result = 0;
    while ((result = avcodec_receive_frame(codec_.get(), frame_.get())) >= 0) Take(*frame_);
    if (result != AVERROR(EAGAIN) && result != AVERROR_EOF) FailDamaged(result);
  }

  void Take(AVFrame& frame) {
    if (!resampler_) OpenResampler(frame);
    if (frame.sample_rate != sound_.rate_hz || frame.format != format_ || frame.ch_layout.nb_channels != channels_)
      throw Fail("{}: its sound changes rate, format or channels after {} samples", path_.string(), sound_.samples);
    const std::int64_t stamp = frame.best_effort_timestamp;
    if (stamp != AV_NOPTS_VALUE) sound_.stamps.push_back({sound_.samples, libav::Seconds(stamp, stream_->time_base)});
    if (sound_.stamps.empty()) throw Fail("{}: its sound has no time stamps", path_.string());
    const auto count = static_cast<std::size_t>(frame.nb_samples);
    interleaved_.resize(count * static_cast<std::size_t>(channels_));
    auto* out = reinterpret_cast<std::uint8_t*>(interleaved_.data());
    const int converted = swr_convert(resampler_.get(), &out, frame.nb_samples,
                                      const_cast<const std::uint8_t**>(frame.extended_data), frame.nb_samples);
    if (converted != frame.nb_samples) FailDamaged(converted < 0 ? converted : AVERROR_INVALIDDATA);
    mean_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      float sum = 0;
      for (int c = 0; c < channels_; ++c)
        sum += interleaved_[i * static_cast<std::size_t>(channels_) + static_cast<std::size_t>(c)];
      if (!std::isfinite(sum)) FailDamaged(AVERROR_INVALIDDATA);
      mean_[i] = sum / static_cast<float>(channels_);
    }
    sound_.samples += count;
    take_(sound_.rate_hz, mean_);
  }

  // Only the format of the samples changes.
  void OpenResampler(const AVFrame& first) {
    sound_.rate_hz = first.sample_rate;
    format_ = first.format;
    channels_ = first.ch_layout.nb_channels;
    AVChannelLayout layout = {};
    av_channel_layout_default(&layout, channels_);
    SwrContext* opened = nullptr;
    const int set = swr_alloc_set_opts2(&opened, &layout, AV_SAMPLE_FMT_FLT, first.sample_rate, &layout,
                                        static_cast<AVSampleFormat>(first.format), first.sample_rate, 0, nullptr);
    resampler_.reset(opened);
    if (set < 0 || swr_init(opened) < 0)
      throw Fail("{}: its sound of {} channels cannot be read", path_.string(), channels_);
  }

  fs::path path_;
  const TakeSamples& take_;
  DamageLog log_;
  libav::Input input_;
  AVStream* stream_ = nullptr;  // of input_
  libav::Codec codec_;
  libav::Frame frame_ = libav::NewFrame();
  Resampler resampler_;
  int format_ = AV_SAMPLE_FMT_NONE, channels_ = 0;
  std::vector<float> interleaved_, mean_;  // of the frame at hand: all channels, their mean
  std::optional<std::int64_t> packets_promised_;
  std::int64_t packets_ = 0;
  bool tells_priming_ = false;
  Sound sound_;
};

}  // namespace

double Sound::TimeOf(double sample) const {
  constexpr double kGap_s = 0.004;                     // more than stamps are rounded by
  constexpr double kAveraged_s = 0.5;                  // to each side
  const auto begin_s = [&](const SoundStamp& stamp) {  // of sample 0, by this stamp
    return stamp.time_s - static_cast<double>(stamp.sample) / rate_hz;
  };
  const auto after =
      std::ranges::upper_bound(stamps, sample, {}, [](const SoundStamp& s) { return static_cast<double>(s.sample); });
  const auto own = after == stamps.begin() ? after : after - 1;
  const auto belongs = [&](const SoundStamp& stamp) {
    return std::abs(begin_s(stamp) - begin_s(*own)) < kGap_s &&
           std::abs(static_cast<double>(stamp.sample) - sample) < kAveraged_s * rate_hz;
  };
  double sum_s = begin_s(*own);
  int count = 1;
  for (auto stamp = own; stamp != stamps.begin() && belongs(*(stamp - 1)); --stamp) {
    sum_s += begin_s(*(stamp - 1));
    ++count;
  }
  for (auto stamp = own + 1; stamp < stamps.end() && belongs(*stamp); ++stamp) {
    sum_s += begin_s(*stamp);
    ++count;
  }
  return sum_s / count + sample / rate_hz;
}

Sound ReadSound(const fs::path& path, const TakeSamples& take) {
  return SoundReader(path, take).Read();
}

}  // namespace lake::video
