#include "lake/video/video_reader.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <cmath>
#include <utility>

#include "decoder.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/uncertain_text.h"
#include "orientation.h"
#include "picture.h"
#include "stamps.h"

namespace lake::video {
namespace {

constexpr double kRounding_s = 1e-6;  // of time stamps and of what is typed

std::string FormatName(int format) {
  const char* name = av_get_pix_fmt_name(static_cast<AVPixelFormat>(format));
  return name ? name : "unknown";
}

std::int64_t UsualTicks(const AVStream& stream) {
  const AVRational rate = stream.avg_frame_rate.num > 0 ? stream.avg_frame_rate : stream.r_frame_rate;
  return rate.num > 0 && rate.den > 0 ? av_rescale_q(1, av_inv_q(rate), stream.time_base) : 0;
}

// The frame's own display matrix goes before the stream's, as in players.
Orientation FindOrientation(const AVStream& stream, const AVFrame& frame, const std::string& file) {
  constexpr std::size_t kBytes = 9 * sizeof(std::int32_t);
  std::size_t size = 0;
  const std::uint8_t* data = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, &size);
  if (const AVFrameSideData* own = av_frame_get_side_data(&frame, AV_FRAME_DATA_DISPLAYMATRIX)) {
    data = own->data;
    size = own->size;
  }
  if (!data || size < kBytes) return {};
  std::int32_t matrix[9];
  std::copy_n(data, kBytes, reinterpret_cast<std::uint8_t*>(matrix));
  if (const auto orientation = OrientationFromDisplayMatrix(matrix)) return *orientation;
  throw Fail("{}: is to be shown turned by an angle that is no multiple of 90°; turn it first, e.g. with ffmpeg", file);
}

class LibavReader : public VideoReader {
 public:
  LibavReader(const std::filesystem::path& path, const VideoReaderOptions& options);

  const VideoInfo& Info() const override { return info_; }
  bool Read(VideoFrame& frame) override;

 private:
  using SharedFrame = std::shared_ptr<AVFrame>;

  void FillInfo();
  void CheckIsLikeFirst(const AVFrame& frame) const;
  double Time(const AVFrame& frame);
  void HandOut(const SharedFrame& decoded, double time_s, VideoFrame& frame);
  bool IsWanted(double time_s) const;
  bool IsPastEnd(double time_s) const { return options_.end_s && time_s > *options_.end_s + kRounding_s; }
  void CheckAnyWasWanted() const;
  [[noreturn]] void FailAtFrame(const std::string& what) const;

  VideoReaderOptions options_;
  Decoder decoder_;
  SharedFrame first_frame_;                                // decoded when opening, until it is handed out
  int width_ = 0, height_ = 0, format_ = AV_PIX_FMT_NONE;  // as stored
  Orientation orientation_;
  std::optional<PictureConverter> converter_;
  Stamps stamps_;
  VideoInfo info_;
  std::int64_t next_index_ = 0;
  double last_time_s_ = 0;
  bool any_wanted_ = false;
};

LibavReader::LibavReader(const std::filesystem::path& path, const VideoReaderOptions& options)
    : options_(options),
      decoder_(path, options.capture_rate_hz, options.skip_deblocking, options.seek_s),
      first_frame_(decoder_.Next()),
      stamps_(decoder_.Source().Stream().time_base, UsualTicks(decoder_.Source().Stream())) {
  if (!first_frame_) throw Fail("{}: holds no frame", path.string());
  if (!decoder_.Source().HasTimes() && options.capture_rate_hz <= 0)
    throw Fail(
        "{}: {} no times: say at how many Hz the pictures were taken, --capture-rate HZ (capture_rate_hz in a "
        "study file)",
        path.string(), decoder_.Source().IsSequence() ? "an image sequence has" : "this kind of file has");
  if (options.rotate_deg % 90 != 0 || options.rotate_deg < 0 || options.rotate_deg >= 360)
    throw UsageError("--rotate {}: 0, 90, 180 or 270", options.rotate_deg);
  orientation_ =
      FindOrientation(decoder_.Source().Stream(), *first_frame_, path.string()).TurnedOn(options.rotate_deg / 90);
  try {
    converter_.emplace(*first_frame_);
  } catch (const Error& error) {
    throw Fail("{}: {}", path.string(), error.what());
  }
  FillInfo();
}

void LibavReader::FillInfo() {
  const AVStream& stream = decoder_.Source().Stream();
  AVFrame& first = *first_frame_;
  width_ = first.width;
  height_ = first.height;
  format_ = first.format;
  info_.width = orientation_.transpose ? height_ : width_;
  info_.height = orientation_.transpose ? width_ : height_;
  info_.rotation_deg = orientation_.RotationDeg();
  info_.mirrored = orientation_.IsMirrored();
  if (options_.capture_rate_hz > 0)
    info_.frame_rate_hz = options_.capture_rate_hz;
  else if (stream.avg_frame_rate.den > 0)
    info_.frame_rate_hz = av_q2d(stream.avg_frame_rate);
  info_.frames = decoder_.Source().FramesPromised();
  if (info_.frames && info_.frame_rate_hz > 0 && (options_.start_s || options_.end_s)) {
    const auto last = static_cast<double>(*info_.frames);
    const auto frame_at = [&](double time_s) { return std::clamp(time_s * info_.frame_rate_hz, 0.0, last); };
    info_.frames = std::llround((options_.end_s ? frame_at(*options_.end_s) : last) -
                                (options_.start_s ? frame_at(*options_.start_s) : 0));
  }
  info_.codec = avcodec_get_name(stream.codecpar->codec_id);
  const AVCodecDescriptor* descriptor = avcodec_descriptor_get(stream.codecpar->codec_id);
  info_.coded_frame_by_frame = descriptor && (descriptor->props & AV_CODEC_PROP_INTRA_ONLY) != 0;
  info_.is_lossless = descriptor && (descriptor->props & AV_CODEC_PROP_LOSSY) == 0;
  info_.pixel_format = FormatName(format_);
  const AVRational aspect = av_guess_sample_aspect_ratio(nullptr, const_cast<AVStream*>(&stream), &first);
  if (aspect.num > 0 && aspect.den > 0) info_.pixel_aspect = av_q2d(orientation_.transpose ? av_inv_q(aspect) : aspect);
  info_.bt709 = IsBt709(first);
  info_.full_range = options_.preview_as_stored && KeepsFullRange(first);
  info_.white_level = WhiteLevel(first);
  info_.interlaced = first.interlaced_frame;
}

bool LibavReader::Read(VideoFrame& frame) {
  while (!options_.last || next_index_ <= *options_.last) {
    ThrowIfInterrupted();
    const SharedFrame decoded = first_frame_ ? std::exchange(first_frame_, nullptr) : decoder_.Next();
    if (!decoded) break;
    CheckIsLikeFirst(*decoded);
    last_time_s_ = Time(*decoded);
    if (IsPastEnd(last_time_s_)) break;
    const bool wanted = IsWanted(last_time_s_);
    if (wanted) HandOut(decoded, last_time_s_, frame);
    ++next_index_;
    any_wanted_ |= wanted;
    if (wanted) return true;
  }
  CheckAnyWasWanted();
  return false;
}

bool LibavReader::IsWanted(double time_s) const {
  return next_index_ >= options_.first && (!options_.start_s || time_s >= *options_.start_s - kRounding_s);
}

void LibavReader::CheckAnyWasWanted() const {
  if (any_wanted_) return;
  const std::string file = decoder_.Source().Path().string();
  if (IsPastEnd(last_time_s_))
    throw Fail("{}: no frame lies between {} and {} s; the next is at {} s", file, options_.start_s.value_or(0),
               *options_.end_s, SignificantText(last_time_s_, 6));
  if (options_.start_s)
    throw Fail("{}: ends at {} s; {} s was asked for", file, SignificantText(last_time_s_, 6), *options_.start_s);
  throw Fail("{}: has {} frames, from 0; frame {} was asked for", file, next_index_, options_.first);
}

void LibavReader::CheckIsLikeFirst(const AVFrame& frame) const {
  if (frame.width != width_ || frame.height != height_)
    FailAtFrame(fmt::format("is stored with {}×{} px, those before with {}×{} px; cut the recording there", frame.width,
                            frame.height, width_, height_));
  if (frame.format != format_)
    FailAtFrame(fmt::format("has pixel format {}, those before {}; cut the recording there", FormatName(frame.format),
                            info_.pixel_format));
}

double LibavReader::Time(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT < AV_VERSION_INT(57, 30, 100)
  const std::int64_t duration = frame.pkt_duration;
#else
  const std::int64_t duration = frame.duration;
#endif
  const bool good = stamps_.Add(frame.best_effort_timestamp, duration);
  stamps_.Describe(info_);
  info_.bits_per_pixel = decoder_.BitsPerPicture() / (static_cast<double>(width_) * height_);
  if (options_.capture_rate_hz > 0)
    return stamps_.First().value_or(0) + static_cast<double>(next_index_) / options_.capture_rate_hz;
  if (!good)
    FailAtFrame(stamps_.Problem() +
                "; encode the recording anew, or give its capture rate if frames are equally spaced");
  return stamps_.Last();
}

void LibavReader::HandOut(const SharedFrame& decoded, double time_s, VideoFrame& frame) {
  frame.index = next_index_;
  frame.time_s = time_s;
  if (options_.preview_max_width_px > 0) {
    frame.preview =
        converter_->Preview(*decoded, options_.preview_max_width_px, options_.preview_as_stored, orientation_);
    if (!options_.luma_too) return;
  }
  frame.luma = orientation_.Apply(converter_->Luma(*decoded));
  frame.bgr = options_.colour ? orientation_.Apply(converter_->Bgr(*decoded)) : cv::Mat();
  const bool shares =
      frame.luma.data >= decoded->buf[0]->data && frame.luma.data < decoded->buf[0]->data + decoded->buf[0]->size;
  frame.keep_alive = shares ? decoded : nullptr;
}

void LibavReader::FailAtFrame(const std::string& what) const {
  throw Fail("{} {}", decoder_.Source().Where(next_index_), what);
}

}  // namespace

std::unique_ptr<VideoReader> VideoReader::Open(const std::filesystem::path& path, const VideoReaderOptions& options) {
  return std::make_unique<LibavReader>(path, options);
}

cv::Mat ReadLuma(const std::filesystem::path& path, std::int64_t frame, VideoReaderOptions options) {
  options.first = frame;
  options.last = frame;
  VideoFrame read;
  if (!VideoReader::Open(path, options)->Read(read)) throw Fail("{}: has no frame {}", path.string(), frame);
  return read.luma.clone();
}

}  // namespace lake::video
