// Pictures as JPEG.
#pragma once

#include <turbojpeg.h>

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "lake/core/error.h"

namespace lake::review {

class JpegEncoder {
 public:
  explicit JpegEncoder(int quality) : quality_(quality), handle_(tjInitCompress()) {
    if (!handle_) throw Error("the JPEG encoder cannot be started");
  }
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;
  ~JpegEncoder() { tjDestroy(handle_); }

  // CV_8UC3 BGR or CV_8UC1.
  std::string Encode(const cv::Mat& picture) {
    const bool is_grey = picture.channels() == 1;
    const int sampling = is_grey ? TJSAMP_GRAY : TJSAMP_420;
    buffer_.resize(tjBufSize(picture.cols, picture.rows, sampling));
    unsigned char* buffer = buffer_.data();
    unsigned long size = buffer_.size();  // the library's type
    if (tjCompress2(handle_, picture.data, picture.cols, static_cast<int>(picture.step), picture.rows,
                    is_grey ? TJPF_GRAY : TJPF_BGR, &buffer, &size, sampling, quality_,
                    TJFLAG_FASTDCT | TJFLAG_NOREALLOC) != 0)
      throw Fail("a frame cannot be written as JPEG: {}", tjGetErrorStr2(handle_));
    return {reinterpret_cast<const char*>(buffer), size};
  }

 private:
  int quality_;
  tjhandle handle_;
  std::vector<unsigned char> buffer_;
};

}  // namespace lake::review
