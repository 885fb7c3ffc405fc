// A camera, stream, pipe or file opened for what comes from it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "lake/core/file_descriptor.h"
#include "lake/video/live_stream.h"
#include "libav.h"

namespace lake::video {

class LiveInput {
 public:
  // `gives_up` is asked all the time while nothing comes; then opening and reading fail. Throws Error as LiveStream.
  LiveInput(const std::string& input, const LiveStreamOptions& options, std::function<bool()> gives_up);
  LiveInput(const LiveInput&) = delete;
  LiveInput& operator=(const LiveInput&) = delete;

  const AVStream& Stream() const { return *stream_; }

  // libav's result; the packet is one of Stream(), and not empty. Waits for it, or ends with AVERROR_EXIT.
  int Read(AVPacket& packet);

  // False of raw streams, for which libav makes up 25 Hz.
  bool HasTimes() const;
  // Of its stamps: the stream's own; of one without times, one that holds those of any rate.
  AVRational TimeBase() const { return HasTimes() ? stream_->time_base : AVRational{1, 1'200'000}; }

 private:
  void Open(const LiveStreamOptions& options);
  std::string Address(const LiveStreamOptions& options, const AVInputFormat*& format);
  void OpenPipe();
  void CheckDevice(const LiveStreamOptions& options) const;

  std::string input_;
  std::function<bool()> gives_up_;
  std::unique_ptr<FileDescriptor> pipe_;
  libav::Input opened_;
  const AVStream* stream_ = nullptr;  // of opened_
};

}  // namespace lake::video
