// The frames of a video in any order, for a page to show: frame n is the n-th that video::VideoReader hands out from
// the beginning, whatever was shown before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "lake/video/video_reader.h"

namespace lake::review {

struct FrameStoreOptions {
  std::size_t most_bytes = std::size_t{192} << 20;  // of pictures kept
  int ahead = 24;                                   // frames decoded beyond the one that was asked for last
  int behind = 24;                                  // and kept before one, where they are decoded on the way to it
  int quality = 90;                                 // of the JPEG, 1 to 100
};

struct StoredFrame {
  std::shared_ptr<const std::string> jpeg;
  cv::Mat luma;  // CV_8UC1, as the tracker measures in it
};

// CV_8UC3, blue green red: its colours as the page shows them. Throws Error.
cv::Mat ColoursOf(const StoredFrame& frame);

// One thread decodes, and goes on behind the frame that was asked for last. May be asked by several threads.
class FrameStore {
 public:
  // Of the reader's options how it is turned and the rates count; its frames are those of the whole file. Throws Error
  // as VideoReader::Open does.
  FrameStore(const std::filesystem::path& video, const video::VideoReaderOptions& reader,
             const FrameStoreOptions& options = {});
  ~FrameStore();

  const video::VideoInfo& Info() const;

  // Waits until the frame is decoded. Throws Error where there is none of that number, or the file is damaged before
  // it.
  StoredFrame Frame(std::int64_t frame);

  std::size_t BytesKept() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lake::review
