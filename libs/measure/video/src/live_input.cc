#include "live_input.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <new>
#include <string_view>
#include <thread>

#include "lake/core/error.h"

namespace lake::video {

namespace fs = std::filesystem;

namespace {

// What may come from a pipe or over a network: no playlists. (A session's description, sdp, names addresses too, but
// rtsp needs it.)
constexpr const char* kStreams =
    "mov,matroska,webm,avi,mpegts,mpeg,mpegvideo,m4v,h264,hevc,ivf,mjpeg,jpeg_pipe,mpjpeg,flv,asf,ogg,nut,yuv4mpegpipe,"
    "av1,obu,"
    "rtsp,sdp,rtp,v4l2,video4linux2";
constexpr const char* kProtocols = "file,pipe,udp,tcp,rtp,rtsp,http,https,tls,crypto,unix";

bool IsAddress(const std::string& input) {
  return input.find("://") != std::string::npos;
}

bool IsDevice(const std::string& input) {
  std::error_code error;
  return fs::is_character_file(input, error);
}

}  // namespace

LiveInput::LiveInput(const std::string& input, const LiveStreamOptions& options, std::function<bool()> gives_up)
    : input_(input), gives_up_(std::move(gives_up)) {
  Open(options);
  const int best = av_find_best_stream(opened_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (best < 0) throw Fail("{}: holds no video stream that can be decoded", input_);
  stream_ = opened_->streams[best];
  if (IsDevice(input_)) CheckDevice(options);
  AVRational& pixel_aspect = stream_->codecpar->sample_aspect_ratio;
  if (pixel_aspect.num == 0) pixel_aspect = stream_->sample_aspect_ratio;  // what only the container says
  for (unsigned i = 0; i < opened_->nb_streams; ++i)
    if (static_cast<int>(i) != best) opened_->streams[i]->discard = AVDISCARD_ALL;
}

void LiveInput::OpenPipe() {
  const int number = input_ == "-" ? dup(STDIN_FILENO) : open(input_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (number < 0) throw Fail("{}: cannot be opened ({})", input_, std::strerror(errno));
  pipe_ = std::make_unique<FileDescriptor>(number);
  // A read that finds nothing returns, so that libav asks whether to go on.
  fcntl(number, F_SETFL, fcntl(number, F_GETFL) | O_NONBLOCK);
  constexpr int kWait_ms = 100;
  for (pollfd waiting{.fd = number, .events = POLLIN, .revents = 0}; poll(&waiting, 1, kWait_ms) <= 0;)
    if (gives_up_()) throw Fail("{}: nothing comes from it", input_);
}

// What libav is to open, and as what.
std::string LiveInput::Address(const LiveStreamOptions& options, const AVInputFormat*& format) {
  if (IsAddress(input_)) return input_;
  std::error_code error;
  const fs::file_status status = fs::status(input_, error);
  if (input_ == "-" || fs::is_fifo(status)) {
    OpenPipe();
    return fmt::format("pipe:{}", static_cast<int>(*pipe_));
  }
  if (IsDevice(input_)) {
    format = av_find_input_format("video4linux2");
    if (!format)
      throw Fail(
          "{}: this build reads no cameras, as libavdevice was not installed: install libavdevice-dev and build again, "
          "or "
          "give the camera as a stream",
          input_);
    return input_;
  }
  if (!fs::exists(status)) throw Fail("{}: no such device or file", input_);
  if (!fs::is_regular_file(status)) throw Fail("{}: is neither a device nor a pipe nor a file", input_);
  if (!options.replay) throw UsageError("{}: is a file; with --replay its frames come at their own pace", input_);
  return libav::FileUrl(input_);
}

void LiveInput::Open(const LiveStreamOptions& options) {
  const AVInputFormat* format = nullptr;
  const std::string address = Address(options, format);
  libav::Dictionary settings;
  settings.Set("protocol_whitelist", kProtocols);
  settings.Set("format_whitelist", kStreams);
  if (format) {
    if (!options.size.empty()) settings.Set("video_size", options.size);
    if (options.rate_hz > 0) settings.Set("framerate", fmt::format("{:.6f}", options.rate_hz));
    if (!options.format.empty()) settings.Set("input_format", options.format);
  } else if (options.rate_hz > 0) {
    settings.Set("framerate", fmt::format("{:.6f}", options.rate_hz));  // of those without times; others ignore it
  }
  if (address.starts_with("udp:")) settings.Set("fifo_size", 1 << 18);  // packets of 188 bytes: 48 MB, some seconds
  if (address.starts_with("rtsp:")) settings.Set("rtsp_transport", "tcp");
  AVFormatContext* opened = avformat_alloc_context();
  if (!opened) throw std::bad_alloc();
  opened->interrupt_callback.opaque = this;
  opened->interrupt_callback.callback = [](void* self) { return static_cast<LiveInput*>(self)->gives_up_() ? 1 : 0; };
  if (format) opened->flags |= AVFMT_FLAG_NONBLOCK;  // V4L2 waits without asking whether to go on
  const int result = avformat_open_input(&opened, address.c_str(), format, settings.Get());
  if (result < 0) throw Fail("{}: no video that can be read comes from it ({})", input_, libav::ErrorText(result));
  opened_.reset(opened);
  const int found = avformat_find_stream_info(opened_.get(), nullptr);
  if (found < 0) throw Fail("{}: its streams cannot be read ({})", input_, libav::ErrorText(found));
}

// A driver makes of a size or a rate that its camera does not have one that it has, and says nothing.
void LiveInput::CheckDevice(const LiveStreamOptions& options) const {
  const AVCodecParameters& sent = *stream_->codecpar;
  const std::string size = fmt::format("{}x{}", sent.width, sent.height);
  if (!options.size.empty() && options.size != size)
    throw Fail("{}: has no pictures of --size {}; the nearest is {}", input_, options.size, size);
  constexpr double kSameRate = 0.01;  // 29.97 Hz for 30
  const AVRational rate = stream_->avg_frame_rate;
  if (options.rate_hz > 0 && rate.num > 0 && std::abs(av_q2d(rate) / options.rate_hz - 1) > kSameRate)
    throw Fail("{}: does not send at --rate {:g} Hz; the nearest is {:g} Hz", input_, options.rate_hz, av_q2d(rate));
}

bool LiveInput::HasTimes() const {
  constexpr std::array<std::string_view, 9> kWithout = {"jpeg_pipe", "h264", "hevc", "mpegvideo", "mjpeg",
                                                        "obu",       "av1",  "m4v",  "mpjpeg"};
  return std::ranges::find(kWithout, std::string_view(opened_->iformat->name)) == kWithout.end();
}

int LiveInput::Read(AVPacket& packet) {
  while (true) {
    const int result = av_read_frame(opened_.get(), &packet);
    if (result == AVERROR(EAGAIN)) {
      if (gives_up_()) return AVERROR_EXIT;
      constexpr std::chrono::milliseconds kLook{2};  // well below the 8 ms between pictures at 120 Hz
      std::this_thread::sleep_for(kLook);
      continue;
    }
    // V4L2 hands out a picture that did not arrive whole as an empty one.
    if (result < 0 || (packet.stream_index == stream_->index && packet.size > 0)) return result;
    av_packet_unref(&packet);
  }
}

}  // namespace lake::video
