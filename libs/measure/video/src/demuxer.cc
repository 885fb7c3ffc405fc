#include "demuxer.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <new>
#include <string_view>
#include <vector>

#include "lake/core/error.h"

namespace lake::video {
namespace fs = std::filesystem;
namespace {

// Containers that are opened; not among them: scripts and playlists, which would name further files or addresses.
constexpr const char* kContainers =
    "mov,matroska,webm,avi,mpegts,mpeg,mpegvideo,m4v,h264,hevc,vp9,ivf,mjpeg,flv,asf,ogg,mxf,nut,gif,apng,yuv4mpegpipe,"
    "dv,"
    "image2,av1,obu";

bool IsPicture(const fs::path& path) {
  constexpr std::array<std::string_view, 12> kExtensions = {".png", ".jpg", ".jpeg", ".tif",  ".tiff", ".bmp",
                                                            ".pgm", ".ppm", ".pnm",  ".webp", ".tga",  ".jp2"};
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

void CheckIsFile(const fs::path& path) {
  std::error_code error;
  const auto status = fs::status(path, error);
  if (!fs::exists(status)) throw Fail("{}: no such file", path.string());
  if (fs::is_directory(status))
    throw Fail("{}: is a folder, not a video; for an image sequence give a pattern such as {}", path.string(),
               (path / "%05d.png").string());
  if (!fs::is_regular_file(status))
    throw Fail("{}: is a pipe or a device, and a video is read more than once; save it as a file", path.string());
  if (fs::file_size(path, error) == 0) throw Fail("{}: is empty", path.string());
}

// What the demuxer counts in its index: all entries, or only those that are shown.
std::int64_t CountIndex(const AVStream& stream, bool shown_only) {
  AVStream* indexed = const_cast<AVStream*>(&stream);  // the API takes no const
  const int entries = avformat_index_get_entries_count(indexed);
  std::int64_t count = 0;
  for (int i = 0; i < entries; ++i)
    count += !shown_only || !(avformat_index_get_entry(indexed, i)->flags & AVINDEX_DISCARD_FRAME);
  return count;
}

void SetWhitelists(libav::Dictionary& options) {
  options.Set("protocol_whitelist", "file");
  options.Set("format_whitelist", kContainers);
}

libav::Input OpenInput(const fs::path& path, const std::string& url, const AVInputFormat* format,
                       libav::Dictionary& options, DamageLog& log) {
  AVFormatContext* opened = avformat_alloc_context();
  if (!opened) throw std::bad_alloc();
  log.Attach(*opened);
  const int result = avformat_open_input(&opened, url.c_str(), format, options.Get());
  if (result < 0)
    throw Fail("{}: not a video that can be read, or damaged at its beginning or index ({})", path.string(),
               libav::ErrorText(result));
  libav::Input input(opened);
  std::vector<AVDictionary*> stream_options(input->nb_streams, nullptr);
  for (AVDictionary*& entry : stream_options) av_dict_set_int(&entry, "max_pixels", libav::kMaxPixels, 0);
  const int found = avformat_find_stream_info(input.get(), stream_options.data());
  for (AVDictionary*& entry : stream_options) av_dict_free(&entry);
  if (found < 0) throw Fail("{}: its streams cannot be read ({})", path.string(), libav::ErrorText(found));
  return input;
}

}  // namespace

Demuxer::Demuxer(fs::path path, double capture_rate_hz, DamageLog& log)
    : path_(std::move(path)), log_(log), sequence_(ImageSequence::Find(path_)) {
  if (!sequence_) CheckIsFile(path_);
  Open(capture_rate_hz);
  ChooseStream();
  packets_promised_ = PacketsPromised();
}

libav::Input OpenFilm(const fs::path& path, DamageLog& log) {
  CheckIsFile(path);
  libav::Dictionary options;
  SetWhitelists(options);
  return OpenInput(path, libav::FileUrl(path), nullptr, options, log);
}

void Demuxer::Open(double capture_rate_hz) {
  libav::Dictionary options;
  SetWhitelists(options);
  const AVInputFormat* format = nullptr;
  if (sequence_ || IsPicture(path_)) {
    format = av_find_input_format("image2");
    options.Set("pattern_type", sequence_ ? "sequence" : "none");
  }
  if (sequence_) {
    options.Set("start_number", sequence_->FirstNumber());
    if (capture_rate_hz > 0) options.Set("framerate", fmt::format("{:.6f}", capture_rate_hz));
  }
  input_ = OpenInput(path_, sequence_ ? sequence_->Url() : libav::FileUrl(path_), format, options, log_);
}

void Demuxer::ChooseStream() {
  const int best = av_find_best_stream(input_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (best < 0) throw Fail("{}: holds no video stream that can be decoded", path_.string());
  stream_ = input_->streams[best];
  if (stream_->disposition & AV_DISPOSITION_ATTACHED_PIC)
    throw Fail("{}: holds a cover picture but no video", path_.string());
  for (unsigned i = 0; i < input_->nb_streams; ++i)
    if (static_cast<int>(i) != best) input_->streams[i]->discard = AVDISCARD_ALL;
}

bool Demuxer::HasTimes() const {
  constexpr std::array<std::string_view, 6> kWithoutContainer = {"h264", "hevc", "mpegvideo", "mjpeg", "obu", "av1"};
  const auto format =
      std::find(kWithoutContainer.begin(), kWithoutContainer.end(), std::string_view(input_->iformat->name));
  return !sequence_ && format == kWithoutContainer.end();
}

std::optional<std::int64_t> PacketsInIndex(const AVFormatContext& input, const AVStream& stream) {
  if (std::string_view(input.iformat->name).starts_with("mov")) return CountIndex(stream, false);
  return std::nullopt;
}

std::optional<std::int64_t> Demuxer::PacketsPromised() const {
  if (sequence_) return sequence_->Files();
  return PacketsInIndex(*input_, *stream_);
}

std::optional<std::int64_t> Demuxer::FramesPromised() const {
  if (sequence_) return sequence_->Files();
  if (packets_promised_ && *packets_promised_ >= stream_->nb_frames) return CountIndex(*stream_, true);
  return stream_->nb_frames > 0 ? std::optional(stream_->nb_frames) : std::nullopt;
}

void Demuxer::SeekKeyFrame(double time_s) {
  const std::int64_t ticks = std::llround(time_s / av_q2d(stream_->time_base));
  // Where that fails: from the beginning.
  if (av_seek_frame(input_.get(), stream_->index, ticks, AVSEEK_FLAG_BACKWARD) >= 0 && sequence_)
    first_picture_ = ticks;
  packets_promised_.reset();  // the end may come sooner than is promised of the whole
}

bool Demuxer::Read(AVPacket& packet) {
  if (!damage_.empty()) return false;
  while (true) {
    const int result = av_read_frame(input_.get(), &packet);
    if (result < 0) {
      NoteEnd(result);
      return false;
    }
    if (packet.stream_index == stream_->index) break;
    av_packet_unref(&packet);
  }
  if (packet.dts != AV_NOPTS_VALUE) last_dts_ = packet.dts;
  if (packet.flags & AV_PKT_FLAG_CORRUPT) {
    damage_ = "is cut off or damaged in the file";
    return false;
  }
  ++packets_;
  return true;
}

void Demuxer::NoteEnd(int result) {
  if (result != AVERROR_EOF)
    damage_ = fmt::format("cannot be read ({})", libav::ErrorText(result));
  else if (log_.IsFileCut())
    damage_ = "is not in the file: it is cut off";
  else if (packets_promised_ && packets_ < *packets_promised_)
    damage_ = fmt::format("is not in the file: it ends after {} of {} packets", packets_, *packets_promised_);
}

std::string Demuxer::Where(std::int64_t frame) const {
  if (sequence_) return sequence_->File(first_picture_ + frame).string();
  return fmt::format("{}: frame {}", path_.string(), frame);
}

}  // namespace lake::video
