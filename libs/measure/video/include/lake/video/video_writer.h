// Videos with exact time stamps, written under a temporary name until they are whole.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace lake::video {

struct VideoWriterOptions {
  int width = 0;                    // px, even
  int height = 0;                   // px, even
  double frame_rate_hz = 30;        // nominal; the time stamps of frames decide
  int crf = 20;                     // H.264 quality, 17 (fine) … 28 (coarse)
  bool lossless = false;            // H.264 with QP 0, luma kept to the bit (full-range 8 bit)
  bool grey = false;                // frames are CV_8UC1, written as full-range luma: the reader gives the same levels
  bool i420 = false;                // frames are YUV 4:2:0 as VideoFrame::preview, written without conversion
  bool full_range = false;          // levels of i420 frames: 0..255, else 16..235
  std::optional<bool> bt709 = {};   // matrix of colours, BT.709 or BT.601; unset: by the size
  const char* preset = "veryfast";  // x264's speed, "ultrafast" … "placebo"
  int threads = 0;                  // 0: the encoder's own choice
};

class VideoWriter {
 public:
  // H.264 in MP4; BGR becomes limited-range 4:2:0, unless given otherwise BT.709 from 1280 px width or 577 px height
  // on, else BT.601. Throws Error if the file cannot be made, a side is odd, or an option is out of its range.
  VideoWriter(const std::filesystem::path& path, const VideoWriterOptions& options);
  VideoWriter(VideoWriter&&) noexcept;
  ~VideoWriter();  // without Finish(): removes the unfinished file

  // CV_8UC3 BGR; CV_8UC1 for grey; CV_8UC1 of 3/2 height for i420. Time stamps are kept to 1/90000 s; they start at 0
  // or later and must increase. Throws Error (a full disk).
  void Write(const cv::Mat& image, double time_s);

  // Completes the file and gives it its final name. Throws Error if there is no frame, or as Write.
  void Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lake::video
