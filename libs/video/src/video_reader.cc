#include "lake/video/video_reader.h"

#include <algorithm>

extern "C" {
#include <libavutil/pixdesc.h>
}

#include "demuxer.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "orientation.h"
#include "picture.h"
#include "stamps.h"

namespace lake {
namespace {

class LibavReader : public VideoReader {
 public:
  LibavReader(const std::filesystem::path& path, const VideoReaderOptions& options);

  const VideoInfo& Info() const override { return info_; }
  bool Read(VideoFrame& frame) override;

 private:
  using SharedFrame = std::shared_ptr<AVFrame>;

  void OpenDecoder();
  void CheckSize(int width, int height) const;
  Orientation FindOrientation(const AVFrame& first) const;
  void FillInfo(const AVFrame& first);

  SharedFrame NextDecoded();
  bool Decode(AVFrame& frame);
  void FeedDecoder();
  void CheckIsWhole(const AVFrame& frame) const;
  void CheckIsLikeFirst(const AVFrame& frame) const;
  double Stamp(const AVFrame& frame);
  void HandOut(const SharedFrame& decoded, double time_s, VideoFrame& frame);
  [[noreturn]] void FailAtFrame(const std::string& what) const;

  VideoReaderOptions options_;
  Demuxer demuxer_;
  libav::Codec codec_;
  libav::Packet packet_ = libav::NewPacket();
  bool starts_within_group_ = false;  // the first packet is no key frame: until one comes, packets may be undecodable
  bool any_packet_ = false;
  VideoInfo info_;
  Orientation orientation_;
  std::optional<PictureConverter> converter_;
  SharedFrame first_frame_;  // decoded when opening
  int width_ = 0, height_ = 0, format_ = AV_PIX_FMT_NONE;
  StampCheck stamps_;
  std::int64_t next_index_ = 0;
};

LibavReader::LibavReader(const std::filesystem::path& path, const VideoReaderOptions& options)
    : options_(options), demuxer_(path, options.sequence_rate_hz), stamps_(demuxer_.Stream().time_base) {
  const AVCodecParameters& stored = *demuxer_.Stream().codecpar;
  CheckSize(stored.width, stored.height);
  OpenDecoder();
  first_frame_ = NextDecoded();
  if (!first_frame_) throw Fail("{}: holds no frame", path.string());
  CheckSize(first_frame_->width, first_frame_->height);
  FillInfo(*first_frame_);
}

void LibavReader::CheckSize(int width, int height) const {
  if (width > libav::kMaxSide_px || height > libav::kMaxSide_px || std::int64_t{width} * height > libav::kMaxPixels)
    throw Fail("{}: {}×{} px is too large; at most {} px a side and {} Mpx", demuxer_.Where(0), width, height,
               libav::kMaxSide_px, libav::kMaxPixels / 1'000'000);
}

void LibavReader::OpenDecoder() {
  const AVStream& stream = demuxer_.Stream();
  const AVCodec* decoder = avcodec_find_decoder(stream.codecpar->codec_id);
  if (!decoder) throw Fail("{}: no decoder for {}", demuxer_.Where(0), avcodec_get_name(stream.codecpar->codec_id));
  codec_ = libav::NewCodec(decoder);
  avcodec_parameters_to_context(codec_.get(), stream.codecpar);
  codec_->pkt_timebase = stream.time_base;
  codec_->thread_count = 0;  // as many as there are cores
  codec_->thread_type = FF_THREAD_FRAME | FF_THREAD_SLICE;
  codec_->flags |= AV_CODEC_FLAG_UNALIGNED;  // crop to the pixel
  codec_->max_pixels = libav::kMaxPixels;
  const int result = avcodec_open2(codec_.get(), decoder, nullptr);
  if (result < 0)
    throw Fail("{}: the {} decoder cannot be started ({})", demuxer_.Where(0), decoder->name, libav::ErrorText(result));
}

Orientation LibavReader::FindOrientation(const AVFrame& first) const {
  constexpr std::size_t kBytes = 9 * sizeof(std::int32_t);
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
  if (const AVFrameSideData* side = av_frame_get_side_data(&first, AV_FRAME_DATA_DISPLAYMATRIX))
    data = side->data, size = side->size;
  if (!data) data = av_stream_get_side_data(&demuxer_.Stream(), AV_PKT_DATA_DISPLAYMATRIX, &size);
  if (!data || size < kBytes) return {};
  std::int32_t matrix[9];
  std::copy_n(data, kBytes, reinterpret_cast<std::uint8_t*>(matrix));
  const auto orientation = OrientationFromDisplayMatrix(matrix);
  if (!orientation)
    throw Fail("{}: is to be shown turned by an angle that is no multiple of 90°; turn it first, e.g. with ffmpeg",
               demuxer_.Where(0));
  return *orientation;
}

void LibavReader::FillInfo(const AVFrame& first) {
  const AVStream& stream = demuxer_.Stream();
  orientation_ = FindOrientation(first);
  width_ = first.width, height_ = first.height, format_ = first.format;
  info_.width = orientation_.transpose ? height_ : width_;
  info_.height = orientation_.transpose ? width_ : height_;
  info_.rotation_deg = orientation_.RotationDeg();
  info_.mirrored = orientation_.IsMirrored();
  info_.frame_rate_hz = demuxer_.IsSequence() ? options_.sequence_rate_hz : av_q2d(stream.avg_frame_rate);
  info_.frames = demuxer_.FramesPromised();
  info_.codec = avcodec_get_name(stream.codecpar->codec_id);
  const char* format = av_get_pix_fmt_name(static_cast<AVPixelFormat>(format_));
  info_.pixel_format = format ? format : "unknown";
  const AVRational aspect =
      av_guess_sample_aspect_ratio(nullptr, const_cast<AVStream*>(&stream), const_cast<AVFrame*>(&first));
  if (aspect.num > 0 && aspect.den > 0)
    info_.pixel_aspect = orientation_.transpose ? 1 / av_q2d(aspect) : av_q2d(aspect);
  info_.interlaced = first.interlaced_frame;
  try {
    converter_.emplace(first);
  } catch (const Error& error) {
    throw Fail("{}: {}", demuxer_.Where(0), error.what());
  }
}

bool LibavReader::Read(VideoFrame& frame) {
  while (!options_.last || next_index_ <= *options_.last) {
    ThrowIfInterrupted();
    const SharedFrame decoded = first_frame_ ? std::exchange(first_frame_, nullptr) : NextDecoded();
    if (!decoded) break;
    CheckIsLikeFirst(*decoded);
    const double time_s = Stamp(*decoded);
    const bool wanted = next_index_ >= options_.first;
    if (wanted) HandOut(decoded, time_s, frame);
    ++next_index_;
    if (wanted) return true;
  }
  if (next_index_ <= options_.first && options_.first > 0 && (!options_.last || *options_.last >= options_.first))
    throw Fail("{}: was asked for as the first, but there are only {} frames", demuxer_.Where(options_.first),
               next_index_);
  return false;
}

LibavReader::SharedFrame LibavReader::NextDecoded() {
  SharedFrame frame(libav::NewFrame());
  const bool decoded = Decode(*frame);
  const std::string& damage = demuxer_.Damage();
  if (damage.empty()) return decoded ? frame : nullptr;
  // Frames are handed out up to the first that is missing; what the decoder still gives after that one is not.
  const bool before_damage = decoded && frame->best_effort_timestamp != AV_NOPTS_VALUE &&
                             frame->best_effort_timestamp < demuxer_.FirstDamagedTicks();
  if (!before_damage) FailAtFrame(damage);
  return frame;
}

bool LibavReader::Decode(AVFrame& frame) {
  while (true) {
    const int result = avcodec_receive_frame(codec_.get(), &frame);
    if (result == AVERROR_EOF) return false;
    if (result == AVERROR(EAGAIN)) {
      FeedDecoder();
    } else if (result < 0) {
      if (!(starts_within_group_ && next_index_ == 0))
        FailAtFrame(fmt::format("cannot be decoded ({})", libav::ErrorText(result)));
    } else {
      CheckIsWhole(frame);
      return true;
    }
  }
}

void LibavReader::FeedDecoder() {
  const bool more = demuxer_.Read(*packet_);
  if (more && !std::exchange(any_packet_, true)) starts_within_group_ = !(packet_->flags & AV_PKT_FLAG_KEY);
  const int result = avcodec_send_packet(codec_.get(), more ? packet_.get() : nullptr);
  av_packet_unref(packet_.get());
  if (result < 0 && result != AVERROR_EOF && !(starts_within_group_ && next_index_ == 0))
    FailAtFrame(fmt::format("cannot be decoded ({})", libav::ErrorText(result)));
}

void LibavReader::CheckIsWhole(const AVFrame& frame) const {
  if ((frame.flags & AV_FRAME_FLAG_CORRUPT) || frame.decode_error_flags != 0)
    FailAtFrame("is damaged: parts of the picture are missing or made up by the decoder");
}

void LibavReader::CheckIsLikeFirst(const AVFrame& frame) const {
  if (frame.width != width_ || frame.height != height_)
    FailAtFrame(fmt::format("is {}×{} px, the frames before are {}×{} px; cut the recording there", frame.width,
                            frame.height, width_, height_));
  if (frame.format != format_) {
    const char* format = av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame.format));
    FailAtFrame(
        fmt::format("has pixel format {}, the frames before {}", format ? format : "unknown", info_.pixel_format));
  }
}

double LibavReader::Stamp(const AVFrame& frame) {
  if (demuxer_.IsSequence()) return static_cast<double>(next_index_) / options_.sequence_rate_hz;
  const std::optional<double> before_s = stamps_.LastTime_s();
  const bool good = stamps_.Add(frame.best_effort_timestamp);
  stamps_.Describe(info_);
  if (options_.capture_rate_hz > 0)
    return stamps_.FirstTime_s().value_or(0) + static_cast<double>(next_index_) / options_.capture_rate_hz;
  if (good) return *stamps_.LastTime_s();
  constexpr const char* kWayOut = "re-encode it, or give its capture rate if the frames are equally spaced";
  if (frame.best_effort_timestamp == AV_NOPTS_VALUE) FailAtFrame(fmt::format("has no time stamp; {}", kWayOut));
  FailAtFrame(fmt::format("has time stamp {:.6f} s, not after the frame before ({:.6f} s); {}",
                          libav::Seconds(frame.best_effort_timestamp, demuxer_.Stream().time_base), *before_s,
                          kWayOut));
}

void LibavReader::HandOut(const SharedFrame& decoded, double time_s, VideoFrame& frame) {
  frame.index = next_index_;
  frame.time_s = time_s;
  frame.luma = orientation_.Apply(converter_->Luma(*decoded));
  frame.bgr = options_.colour ? orientation_.Apply(converter_->Bgr(*decoded)) : cv::Mat();
  frame.keep_alive = decoded;
}

void LibavReader::FailAtFrame(const std::string& what) const {
  throw Fail("{} {}", demuxer_.Where(next_index_), what);
}

}  // namespace

std::unique_ptr<VideoReader> VideoReader::Open(const std::filesystem::path& path, const VideoReaderOptions& options) {
  return std::make_unique<LibavReader>(path, options);
}

}  // namespace lake
