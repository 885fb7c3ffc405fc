// Packets of one video stream into a Matroska file that can be read at any time.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>

#include "libav.h"

namespace lake::video {

class Recorder {
 public:
  // `time_base`: of the packets. Throws Error where the file is there already, cannot be made, or Matroska has no place
  // for the codec.
  Recorder(std::filesystem::path path, const AVCodecParameters& codec, AVRational time_base, AVRational rate);
  ~Recorder();

  // Stamps from 0. Throws Error when the file cannot be written further; what was written before stays readable.
  void Write(const AVPacket& packet);

  // Whether that was the disk's doing, and not the packet's.
  bool IsDiskFailing() const { return is_disk_failing_; }

  // Writes index and duration. Throws Error as Write().
  void Finish();

 private:
  struct Close {
    void operator()(AVFormatContext* output) const {
      avio_closep(&output->pb);
      avformat_free_context(output);
    }
  };

  void Check(int result, const char* what);
  void CloseCluster();
  [[noreturn]] void FailWhole(const std::string& why);

  std::filesystem::path path_;
  std::unique_ptr<AVFormatContext, Close> output_;
  AVRational time_base_;
  libav::Packet packet_ = libav::NewPacket();
  std::chrono::steady_clock::time_point cluster_began_;
  bool is_disk_failing_ = false;
  std::int64_t whole_bytes_ = 0;  // of the file, in whole clusters
};

}  // namespace lake::video
