#include "lake/video/video_files.h"

#include <algorithm>
#include <memory>

#include "demuxer.h"
#include "lake/core/interrupt.h"

namespace lake::video {

namespace fs = std::filesystem;

fs::path FilesOfVideo(const fs::path& path) {
  std::error_code error;
  if (path.filename().string().find('%') == std::string::npos || fs::exists(path, error)) return path;
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

std::optional<std::vector<double>> StampsInContainer(const fs::path& path, const VideoReaderOptions& options) {
  constexpr double kRounding_s = 1e-6;  // of time stamps and of what is typed
  DamageLog log;
  Demuxer demuxer(path, options.sequence_rate_hz, log);
  if (demuxer.IsSequence() || options.capture_rate_hz > 0) return std::nullopt;
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
  std::erase_if(times_s, [&](double t) {
    return (options.start_s && t < *options.start_s - kRounding_s) ||
           (options.end_s && t > *options.end_s + kRounding_s);
  });
  return times_s;
}

}  // namespace lake::video
