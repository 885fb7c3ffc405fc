// What libav finds damaged but does not report in its return values: it says so in its log only.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <optional>

#include "libav.h"

namespace lake::video {

// Takes libav's log for the whole process: nothing of it reaches stderr, and reports of damage reach the log that is
// attached to the reporting object. (H.264's own flag for concealed pictures is set too late for some frames when
// several threads decode.)
class DamageLog {
 public:
  // Packets of this number may be undecodable: those shown before the first key frame.
  static constexpr std::int64_t kMayFail = -1;

  DamageLog() { TakeLibavLog(); }
  DamageLog(const DamageLog&) = delete;
  DamageLog& operator=(const DamageLog&) = delete;

  // From now on libav prints nothing. For those who need no more than that.
  static void TakeLibavLog() { av_log_set_callback(&DamageLog::Receive); }

  // The log must outlive the object's use.
  void Attach(AVFormatContext& input) { input.opaque = this; }
  void Attach(AVCodecContext& codec);  // before it is opened

  // Gives the packet that is sent next to this codec its number.
  void SetPacket(AVCodecContext& codec, AVPacket& packet, std::int64_t number);

  // That of the packet which the frame was decoded from.
  static std::int64_t PacketOf(const AVFrame& frame);

  // Whether a packet up to this one was damaged. Final once the packet's frame has come out of the decoder.
  bool IsDamagedUpTo(std::int64_t packet) const { return packet >= first_damaged_packet_; }

  // The first damaged packet, which is forgotten: for those who go on behind the damage.
  std::optional<std::int64_t> TakeDamage();

  // Whether the file ended within its own structure.
  bool IsFileCut() const { return file_is_cut_; }

 private:
  struct SentPacket {
    DamageLog* log;
    std::int64_t number;
  };

  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();

  static void Receive(void* source, int level, const char* format, va_list arguments);
  void NoteDamage(std::int64_t packet);

  // A codec's opaque points to the one sent last; its threads, which are fewer by far, to the one they work on.
  std::array<SentPacket, 256> sent_packets_ = {};
  std::size_t sent_ = 0;
  std::atomic<std::int64_t> first_damaged_packet_ = kNone;
  std::atomic<bool> file_is_cut_ = false;
};

}  // namespace lake::video
