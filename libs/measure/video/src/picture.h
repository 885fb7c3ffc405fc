// Decoded frames as matrices: the luma plane where it lies, everything else converted.
#pragma once

#include <opencv2/core/mat.hpp>

#include "libav.h"
#include "orientation.h"

namespace lake::video {

// How the luma of a pixel format comes out as 8 bits.
enum class LumaAccess {
  kPlane,        // 8-bit, samples side by side: shared with the decoder
  kInterleaved,  // 8-bit, packed with chroma or alpha: extracted
  kDeepPlane,    // 9 to 16 bits: scaled down. Limited-range video keeps its limits (16..235)
  kFromRgb,      // no luma: 0.299 R + 0.587 G + 0.114 B (BT.601), 0..255
};

// Throws Error for formats that cannot be decoded to a picture in memory (hardware frames).
LumaAccess LumaAccessOf(AVPixelFormat format);

// Cb, Cr or Y of a picture in OpenCV's I420 layout, sharing its memory; `plane` 0 is Y.
cv::Mat I420Plane(const cv::Mat& i420, int plane);

// The matrix of written video by its size: BT.709 from 1280 px width or 577 px height on, else BT.601.
bool IsHighDefinition(int width, int height);

// VideoInfo::bt709.
bool IsBt709(const AVFrame& frame);

// VideoInfo::white_level.
int WhiteLevel(const AVFrame& frame);

// Whether a preview as stored keeps levels of 0..255.
bool KeepsFullRange(const AVFrame& frame);

// All frames must be of one size and format.
class PictureConverter {
 public:
  explicit PictureConverter(const AVFrame& like);

  // CV_8UC1; for kPlane it points into the frame.
  cv::Mat Luma(const AVFrame& frame);

  // CV_8UC3, 0..255, by the frame's matrix and range. If the frame does not name a matrix: BT.709 for more than 1279 ×
  // 576, else BT.601.
  cv::Mat Bgr(const AVFrame& frame);

  // VideoFrame::preview of the turned picture; `as_stored` as in VideoReaderOptions.
  cv::Mat Preview(const AVFrame& frame, int max_width_px, bool as_stored, const Orientation& orientation);

 private:
  void ScalePreview(const AVFrame& frame, const cv::Mat& i420);

  LumaAccess access_;
  libav::Scaler to_bgr_;
  libav::Scaler to_preview_;
};

}  // namespace lake::video
