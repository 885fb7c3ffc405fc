// Videos with exact time stamps, written under a temporary name until they are whole.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>

namespace lake {

struct VideoWriterOptions {
  int width = 0;                    // px, even
  int height = 0;                   // px, even
  double frame_rate_hz = 30;        // nominal; the time stamps of frames decide
  int crf = 20;                     // H.264 quality, 17 (fine) … 28 (coarse)
  bool lossless = false;            // H.264 with QP 0, luma kept to the bit (full-range 8 bit)
  bool grey = false;                // frames are CV_8UC1 luma
  const char* preset = "veryfast";  // x264's speed
  int threads = 0;                  // 0: the encoder's own choice
};

class VideoWriter {
 public:
  // H.264 in MP4. Throws Error if the file cannot be made or the size is odd.
  VideoWriter(const std::filesystem::path& path, const VideoWriterOptions& options);
  VideoWriter(VideoWriter&&) noexcept;
  ~VideoWriter();  // without Finish(): removes the unfinished file

  // CV_8UC3 BGR or, for grey, CV_8UC1. Time stamps must increase. Throws Error (a full disk).
  void Write(const cv::Mat& image, double time_s);

  // Completes the file and gives it its final name.
  void Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lake
