// Packets of one video stream out of a file, a picture or an image sequence.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "damage_log.h"
#include "image_sequence.h"
#include "libav.h"

namespace lake::video {

// A file with all its streams; the same are refused as by Demuxer. The log must outlive it.
libav::Input OpenFilm(const std::filesystem::path& path, DamageLog& log);

// How many packets of this stream the file says that it holds; nullopt where its container says it only by the packets
// themselves. Of a file that was just opened.
std::optional<std::int64_t> PacketsInIndex(const AVFormatContext& input, const AVStream& stream);

class Demuxer {
 public:
  // Throws Error naming the path: absent, a folder, empty, not a video, no video stream. The log must outlive this.
  Demuxer(std::filesystem::path path, double capture_rate_hz, DamageLog& log);

  const AVStream& Stream() const { return *stream_; }
  bool IsSequence() const { return sequence_.has_value(); }

  // False of image sequences and of streams without a container, for which libav makes up 25 Hz.
  bool HasTimes() const;

  // Frames to be shown, as the container says (an edit list leaves some out).
  std::optional<std::int64_t> FramesPromised() const;

  // Goes to the key frame at or before this time; where the file cannot be searched, nowhere.
  void SeekKeyFrame(double time_s);

  // False at the end. When the file ends too early or a packet is damaged, this is the end, and Damage() says why.
  bool Read(AVPacket& packet);

  // Empty if all packets were whole.
  const std::string& Damage() const { return damage_; }

  // Of the last packet, in ticks of the stream: no frame that is missing because of the damage can have an earlier
  // stamp.
  std::int64_t LastDecodingTicks() const { return last_dts_; }

  const std::filesystem::path& Path() const { return path_; }

  // "file: frame 12" or, of a sequence, the picture's own file.
  std::string Where(std::int64_t frame) const;

 private:
  void Open(double capture_rate_hz);
  void ChooseStream();
  std::optional<std::int64_t> PacketsPromised() const;
  void NoteEnd(int result);

  std::filesystem::path path_;
  DamageLog& log_;
  std::optional<ImageSequence> sequence_;
  libav::Input input_;
  AVStream* stream_ = nullptr;  // of input_
  std::optional<std::int64_t> packets_promised_;
  std::int64_t packets_ = 0;
  std::int64_t first_picture_ = 0;  // of a sequence: the index of the one that reading begins with
  std::int64_t last_dts_ = AV_NOPTS_VALUE;
  std::string damage_;
};

}  // namespace lake::video
