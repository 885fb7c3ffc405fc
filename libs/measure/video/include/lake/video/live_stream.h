// The frames of a camera, a network stream or a pipe as they come, recorded meanwhile as they came.
//
// A thread receives: whatever becomes of the frames, all that arrives is recorded. The coded stream is put into
// Matroska as it is; raw pictures are coded without loss first (FFV1). Clusters are short and written whole, so what
// was recorded up to half a second ago can be read even if the program is killed.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "lake/core/options.h"
#include "lake/video/video_reader.h"

namespace lake::video {

struct LiveStreamOptions {
  std::string size;        // of a V4L2 device: "1280x720"; empty: the device's own
  double rate_hz = 0;      // of a device, or of a stream without time stamps of its own; 0: the device's, the stream's
  std::string format;      // of a device: "mjpeg", "h264"; empty: the device's own
  bool replay = false;     // the input is a file, whose frames come at the pace at which they were taken
  bool is_held = false;    // of a file: its first picture comes, and the others wait for Release()
  double patience_s = 10;  // without data for so long, the stream has ended
  int rotate_deg = 0;      // as in VideoReaderOptions
  double least_free_mb = 64;  // of the recording's disk; recording stops before less is left
};

void Describe(LiveStreamOptions& o, OptionList& options);

struct LiveFrame {
  VideoFrame frame;                               // counted from 0, its time from the first one's stamp
  std::chrono::steady_clock::time_point arrived;  // when its packet was there
};

// Why no more frames come. A clock that is set back ends nothing: stamps go on one interval later.
struct StreamEnd {
  enum class Kind {
    kStopped,    // Stop() was called
    kEnded,      // the stream said so: a file's or a pipe's end, a connection that was closed
    kLost,       // a device that is gone, a network error, silence for `patience_s`
    kDiskFull,   // or a file that cannot be written further
    kUnrecorded  // Matroska does not take what came; what was recorded until then is whole
  };
  Kind kind = Kind::kEnded;
  std::string why;  // in words
};

class LiveStream {
 public:
  // `input`: /dev/video… (once the program has called avdevice_register_all: libavdevice loads forty libraries that
  // other programs do without), an address (rtsp://, udp://, tcp://, http://), "-" for standard input, a named pipe, or
  // with `replay` a file. `recording`: NAME.mkv; while it is under way it is NAME.part.mkv. Throws Error: nothing that
  // can be read, no video, no time stamps and no rate, a recording that is there already, a disk with too little space.
  LiveStream(const std::string& input, const LiveStreamOptions& options, const std::filesystem::path& recording);
  ~LiveStream();

  // Width, height, codec and form of the pictures; the rate and intervals are those of the frames so far.
  const VideoInfo& Info() const;

  // Waits for the next frame. False after the last one. What is damaged, and what builds on it until the next key
  // frame, is recorded and counted, not handed out.
  bool Read(LiveFrame& frame);

  // From any thread: the pictures that `is_held` kept back come.
  void Release();

  // From any thread: nothing more is received, what has been is handed out.
  void Stop();

  // Once Read() has returned false; after Finish() its words tell of the camera's clock, too, if that was set back.
  const StreamEnd& End() const;
  std::int64_t DamagedFrames() const;

  // At any time: pictures that never came, by the gaps that they left in the time stamps: dropped by a camera that is
  // quicker than what receives it, or lost by the network. A break of the stream is one, too.
  std::int64_t MissingFrames() const;

  double FirstStampS() const;  // of the camera's clock, which is this recording's 0

  // Completes the recording, and gives it its name. Call it once, after the last frame; what cannot be completed, as on
  // a full disk, is cut behind its last whole cluster.
  void Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Where a recording is while it is under way: NAME.part.mkv.
std::filesystem::path UnfinishedRecording(const std::filesystem::path& recording);

// Completes what a killed program left under that name: all whole packets. Throws Error where there are none or
// the file is damaged before its end, Interrupted upon Ctrl-C; what was left stays as it is then.
void CompleteRecording(const std::filesystem::path& recording);

}  // namespace lake::video
