// What a frame takes of memory.
#pragma once

#include <cstddef>

#include "lake/video/video_reader.h"

namespace lake::video {

inline std::size_t BytesOf(const VideoFrame& frame) {
  const auto bytes = [](const cv::Mat& picture) { return picture.total() * picture.elemSize(); };
  return 3 * bytes(frame.luma) / 2 + bytes(frame.bgr) + bytes(frame.preview);  // the decoder keeps the chroma too
}

}  // namespace lake::video
