#include "lake/video/video_files.h"

#include <algorithm>

#include "demuxer.h"
#include "lake/core/interrupt.h"

namespace lake::video {

namespace fs = std::filesystem;

namespace {

std::vector<double> TimesOfSequence(std::int64_t files, double rate_hz) {
  std::vector<double> times_s;
  for (std::int64_t i = 0; i < files; ++i) times_s.push_back(static_cast<double>(i) / rate_hz);
  return times_s;
}

// Increasing; nullopt where a packet has no stamp.
std::optional<std::vector<double>> TimesOfPackets(Demuxer& demuxer) {
  const libav::Packet packet = libav::NewPacket();
  std::vector<double> times_s;
  while (demuxer.Read(*packet)) {
    ThrowIfInterrupted();
    const bool is_shown = !(packet->flags & AV_PKT_FLAG_DISCARD), has_stamp = packet->pts != AV_NOPTS_VALUE;
    if (is_shown && has_stamp) times_s.push_back(libav::Seconds(packet->pts, demuxer.Stream().time_base));
    av_packet_unref(packet.get());
    if (is_shown && !has_stamp) return std::nullopt;
  }
  std::sort(times_s.begin(), times_s.end());
  return times_s;
}

}  // namespace

fs::path FilesOfVideo(const fs::path& path) {
  std::error_code error;
  if (path.filename().string().find('%') == std::string::npos || fs::exists(path, error)) return path;
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

bool HasTimes(const fs::path& path) {
  DamageLog log;
  return Demuxer(path, 0, log).HasTimes();
}

std::optional<std::vector<double>> StampsInContainer(const fs::path& path, const VideoReaderOptions& options) {
  constexpr double kRounding_s = 1e-6;  // of time stamps and of what is typed
  DamageLog log;
  Demuxer demuxer(path, options.capture_rate_hz, log);
  const bool is_sequence = demuxer.IsSequence();
  if (is_sequence ? options.capture_rate_hz <= 0 : options.capture_rate_hz > 0 || !demuxer.HasTimes())
    return std::nullopt;
  std::optional<std::vector<double>> times_s =
      is_sequence ? TimesOfSequence(*demuxer.FramesPromised(), options.capture_rate_hz) : TimesOfPackets(demuxer);
  if (!times_s) return std::nullopt;
  std::erase_if(*times_s, [&](double t) {
    return (options.start_s && t < *options.start_s - kRounding_s) ||
           (options.end_s && t > *options.end_s + kRounding_s);
  });
  return times_s;
}

}  // namespace lake::video
