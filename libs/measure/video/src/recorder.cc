#include "recorder.h"

#include <cerrno>
#include <new>

#include "lake/core/error.h"

namespace lake::video {

Recorder::Recorder(std::filesystem::path path, const AVCodecParameters& codec, AVRational time_base, AVRational rate)
    : path_(std::move(path)), time_base_(time_base), cluster_began_(std::chrono::steady_clock::now()) {
  if (std::filesystem::exists(path_))
    throw Fail("{}: is there already, and no recording is written over", path_.string());
  AVFormatContext* opened = nullptr;
  const std::string url = libav::FileUrl(path_);
  if (avformat_alloc_output_context2(&opened, nullptr, "matroska", url.c_str()) < 0) throw std::bad_alloc();
  output_.reset(opened);
  AVStream* stream = avformat_new_stream(output_.get(), nullptr);
  if (!stream || avcodec_parameters_copy(stream->codecpar, &codec) < 0) throw std::bad_alloc();
  stream->codecpar->codec_tag = 0;  // another container's
  stream->time_base = time_base_;
  stream->avg_frame_rate = rate;
  stream->sample_aspect_ratio = codec.sample_aspect_ratio;
  output_->avoid_negative_ts = AVFMT_AVOID_NEG_TS_DISABLED;  // else all stamps would be moved
  const int made = avio_open(&output_->pb, url.c_str(), AVIO_FLAG_WRITE);
  if (made < 0) throw Fail("{}: cannot be written ({})", path_.string(), libav::ErrorText(made));
  const int begun = avformat_write_header(output_.get(), nullptr);
  if (begun < 0) {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
    throw Fail("{}: {} video cannot be recorded in Matroska ({})", path_.string(), avcodec_get_name(codec.codec_id),
               libav::ErrorText(begun));
  }
  CloseCluster();
}

Recorder::~Recorder() = default;

void Recorder::Write(const AVPacket& packet) {
  if (av_packet_ref(packet_.get(), &packet) < 0) throw std::bad_alloc();
  packet_->stream_index = 0;
  av_packet_rescale_ts(packet_.get(), time_base_, output_->streams[0]->time_base);
  const int result = av_write_frame(output_.get(), packet_.get());
  av_packet_unref(packet_.get());
  Check(result, "cannot be written further");
  constexpr std::chrono::milliseconds kLongestCluster{400};  // what a killed program loses
  if (std::chrono::steady_clock::now() - cluster_began_ >= kLongestCluster) CloseCluster();
}

// All that was written is in the file then.
void Recorder::CloseCluster() {
  Check(av_write_frame(output_.get(), nullptr), "cannot be written further");
  avio_flush(output_->pb);
  Check(output_->pb->error, "cannot be written further");
  whole_bytes_ = avio_tell(output_->pb);
  cluster_began_ = std::chrono::steady_clock::now();
}

void Recorder::Finish() {
  Check(av_write_trailer(output_.get()), "cannot be completed");
  avio_flush(output_->pb);
  Check(output_->pb->error, "cannot be completed");
  const int closed = avio_closep(&output_->pb);
  is_disk_failing_ = closed < 0;
  if (closed < 0) throw Fail("{}: cannot be completed ({})", path_.string(), libav::ErrorText(closed));
}

void Recorder::Check(int result, const char* what) {
  if (result >= 0 && output_->pb->error >= 0) return;
  is_disk_failing_ = output_->pb->error < 0 || result == AVERROR(ENOSPC) || result == AVERROR(EFBIG);
  FailWhole(fmt::format("{} ({})", what, libav::ErrorText(result < 0 ? result : output_->pb->error)));
}

// Leaves the whole clusters alone: a file without an index, as that of a stream.
void Recorder::FailWhole(const std::string& why) {
  avio_closep(&output_->pb);
  std::error_code ignored;  // the first failure is the one to tell of
  std::filesystem::resize_file(path_, static_cast<std::uintmax_t>(whole_bytes_), ignored);
  throw Fail("{}: {}", path_.string(), why);
}

}  // namespace lake::video
