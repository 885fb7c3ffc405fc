#include "lake/video/video_writer.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <opencv2/core.hpp>
#include <string_view>

#include "damage_log.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "libav.h"
#include "picture.h"

namespace lake::video {
namespace {

constexpr AVRational kTimeBase = {1, 90000};  // holds the intervals of all usual frame rates exactly

// Checked here, since x264 complains about another one on stderr by itself.
constexpr std::array<std::string_view, 10> kPresets = {"ultrafast", "superfast", "veryfast", "faster",   "fast",
                                                       "medium",    "slow",      "slower",   "veryslow", "placebo"};

// Closes the file as well, which avformat_free_context does not.
struct DeleteOutput {
  void operator()(AVFormatContext* output) const {
    avio_closep(&output->pb);
    avformat_free_context(output);
  }
};

}  // namespace

struct VideoWriter::Impl {
  Impl(const std::filesystem::path& path, const VideoWriterOptions& options);

  void CheckOptions() const;
  void OpenEncoder();
  void OpenFile();
  std::int64_t Ticks(double time_s);
  void FillFrame(const cv::Mat& image);
  void Encode(const AVFrame* frame_or_end);
  void Finish();
  void Check(int result, const char* what) const;

  std::filesystem::path path;
  VideoWriterOptions options;
  AtomicFile file;
  std::unique_ptr<AVFormatContext, DeleteOutput> output;
  AVStream* stream = nullptr;  // of output
  libav::Codec codec;
  libav::Frame frame = libav::NewFrame();
  libav::Packet packet = libav::NewPacket();
  libav::Scaler from_bgr;
  std::int64_t last_ticks = -1;
  double last_time_s = -std::numeric_limits<double>::infinity();
};

VideoWriter::Impl::Impl(const std::filesystem::path& path, const VideoWriterOptions& options)
    : path(path), options(options), file(path) {
  CheckOptions();
  DamageLog::TakeLibavLog();
  OpenEncoder();
  OpenFile();
}

void VideoWriter::Impl::CheckOptions() const {
  const auto& o = options;
  if (o.width < 2 || o.height < 2 || o.width % 2 || o.height % 2)
    throw Fail("{}: a video of {}×{} px cannot be written; both sides must be even", path.string(), o.width, o.height);
  if (o.width > libav::kMaxSide_px || o.height > libav::kMaxSide_px ||
      std::int64_t{o.width} * o.height > libav::kMaxPixels)
    throw Fail("{}: a video of {}×{} px is too large to be written", path.string(), o.width, o.height);
  if (!(o.frame_rate_hz > 0 && o.frame_rate_hz <= 10000))
    throw Fail("{}: {} frames/s is no frame rate for a video", path.string(), o.frame_rate_hz);
  const bool known = std::find(kPresets.begin(), kPresets.end(), std::string_view(o.preset)) != kPresets.end();
  if (!known) throw Fail("{}: x264 has no preset '{}'; it has {}", path.string(), o.preset, fmt::join(kPresets, ", "));
  if (o.grey && o.i420) throw Fail("{}: a video is written from grey or from I420 frames, not both", path.string());
  if (o.crf < 0 || o.crf > 51) throw Fail("{}: CRF {} is not in 0..51", path.string(), o.crf);
}

void VideoWriter::Impl::OpenEncoder() {
  const AVCodec* encoder = avcodec_find_encoder_by_name("libx264");
  if (!encoder) throw Fail("{}: libavcodec has no libx264 encoder", path.string());
  codec = libav::NewCodec(encoder);
  codec->width = options.width;
  codec->height = options.height;
  const bool full_range = options.grey || (options.i420 && options.full_range);
  codec->pix_fmt = full_range ? AV_PIX_FMT_YUVJ420P : AV_PIX_FMT_YUV420P;
  codec->color_range = full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  const bool bt709 = options.bt709.value_or(IsHighDefinition(options.width, options.height));
  codec->colorspace = bt709 ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
  codec->color_primaries = bt709 ? AVCOL_PRI_BT709 : AVCOL_PRI_SMPTE170M;
  codec->color_trc = bt709 ? AVCOL_TRC_BT709 : AVCOL_TRC_SMPTE170M;
  codec->time_base = kTimeBase;
  codec->framerate = av_d2q(options.frame_rate_hz, 100000);
  codec->thread_count = options.threads;
  codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;  // MP4 keeps the parameter sets in its header
  libav::Dictionary settings;
  settings.Set("preset", options.preset);
  settings.Set(options.lossless ? "qp" : "crf", options.lossless ? 0 : options.crf);
  Check(avcodec_open2(codec.get(), encoder, settings.Get()), "the H.264 encoder cannot be started");

  frame->format = codec->pix_fmt;
  frame->width = options.width;
  frame->height = options.height;
  frame->color_range = codec->color_range;
  frame->colorspace = codec->colorspace;
  Check(av_frame_get_buffer(frame.get(), 0), "no memory for a frame");
}

void VideoWriter::Impl::OpenFile() {
  AVFormatContext* opened = nullptr;
  const std::string url = libav::FileUrl(file.TemporaryPath());
  Check(avformat_alloc_output_context2(&opened, nullptr, "mp4", url.c_str()), "no MP4 writer");
  output.reset(opened);
  stream = avformat_new_stream(output.get(), nullptr);
  if (!stream) throw std::bad_alloc();
  stream->time_base = kTimeBase;
  stream->avg_frame_rate = codec->framerate;
  Check(avcodec_parameters_from_context(stream->codecpar, codec.get()), "no stream");
  const int opened_file = avio_open(&output->pb, url.c_str(), AVIO_FLAG_WRITE);
  Check(opened_file, "cannot be written");
  libav::Dictionary settings;
  settings.Set("movflags", "+faststart");          // the index first, so that a browser can start at once
  settings.Set("movie_timescale", kTimeBase.den);  // edit lists (a start other than 0) as exact as the stamps
  settings.Set("video_track_timescale", kTimeBase.den);
  Check(avformat_write_header(output.get(), settings.Get()), "cannot be written");
}

std::int64_t VideoWriter::Impl::Ticks(double time_s) {
  constexpr double kLongest_s = 1e7;
  if (!(time_s >= 0 && time_s < kLongest_s))
    throw Fail("{}: time stamp {} s cannot be written; MP4 starts at 0", path.string(), time_s);
  const auto ticks = std::llround(time_s * kTimeBase.den);
  if (ticks <= last_ticks)
    throw Fail("{}: time stamp {} s does not come after the one before ({} s)", path.string(), time_s, last_time_s);
  last_ticks = ticks;
  last_time_s = time_s;
  return ticks;
}

void VideoWriter::Impl::FillFrame(const cv::Mat& image) {
  const int type = options.grey || options.i420 ? CV_8UC1 : CV_8UC3;
  const int rows = options.i420 ? options.height / 2 * 3 : options.height;
  if (image.type() != type || image.cols != options.width || image.rows != rows)
    throw Fail("{}: an image of {}×{} px, {}, does not fit a video of {}×{} px, {}", path.string(), image.cols,
               image.rows, cv::typeToString(image.type()), options.width, options.height, cv::typeToString(type));
  Check(av_frame_make_writable(frame.get()), "no memory for a frame");
  if (options.grey) {
    image.copyTo(
        cv::Mat(image.rows, image.cols, CV_8UC1, frame->data[0], static_cast<std::size_t>(frame->linesize[0])));
    for (const int plane : {1, 2})
      std::memset(frame->data[plane], 128, static_cast<std::size_t>(frame->linesize[plane]) * (image.rows / 2));
    return;
  }
  if (options.i420) {
    for (const int plane : {0, 1, 2}) {
      const cv::Mat source = I420Plane(image, plane);
      source.copyTo(
          cv::Mat(source.size(), CV_8UC1, frame->data[plane], static_cast<std::size_t>(frame->linesize[plane])));
    }
    return;
  }
  if (!from_bgr) {
    from_bgr.reset(sws_getContext(image.cols, image.rows, AV_PIX_FMT_BGR24, image.cols, image.rows, codec->pix_fmt,
                                  SWS_BILINEAR | SWS_ACCURATE_RND, nullptr, nullptr, nullptr));
    if (!from_bgr) throw std::bad_alloc();
    sws_setColorspaceDetails(from_bgr.get(), sws_getCoefficients(SWS_CS_DEFAULT), 1,
                             sws_getCoefficients(codec->colorspace), 0, 0, 1 << 16, 1 << 16);
  }
  const std::uint8_t* const planes[] = {image.data};
  const int strides[] = {static_cast<int>(image.step)};
  sws_scale(from_bgr.get(), planes, strides, 0, image.rows, frame->data, frame->linesize);
}

void VideoWriter::Impl::Encode(const AVFrame* frame_or_end) {
  Check(avcodec_send_frame(codec.get(), frame_or_end), "a frame cannot be encoded");
  while (true) {
    const int result = avcodec_receive_packet(codec.get(), packet.get());
    if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
    Check(result, "a frame cannot be encoded");
    packet->stream_index = stream->index;
    av_packet_rescale_ts(packet.get(), kTimeBase, stream->time_base);
    Check(av_interleaved_write_frame(output.get(), packet.get()), "cannot be written");
    Check(output->pb->error, "cannot be written");
  }
}

void VideoWriter::Impl::Finish() {
  if (last_ticks < 0) throw Fail("{}: a video without a frame cannot be written", path.string());
  Encode(nullptr);
  Check(av_write_trailer(output.get()), "cannot be written");
  avio_flush(output->pb);
  Check(output->pb->error, "cannot be written");
  Check(avio_closep(&output->pb), "cannot be written");
  file.Commit();
}

void VideoWriter::Impl::Check(int result, const char* what) const {
  if (result < 0) throw Fail("{}: {} ({})", path.string(), what, libav::ErrorText(result));
}

VideoWriter::VideoWriter(const std::filesystem::path& path, const VideoWriterOptions& options)
    : impl_(std::make_unique<Impl>(path, options)) {}
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter::~VideoWriter() = default;

void VideoWriter::Write(const cv::Mat& image, double time_s) {
  impl_->FillFrame(image);
  impl_->frame->pts = impl_->Ticks(time_s);
  impl_->Encode(impl_->frame.get());
}

void VideoWriter::Finish() {
  impl_->Finish();
}

}  // namespace lake::video
