// The chroma of a picture in OpenCV's I420 layout: one sample for two by two pixels. Not part of the interface.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace lake::tracking {

// Shares the picture's memory.
struct ChromaPlanes {
  static constexpr double kNone = 128;  // the level of grey

  cv::Mat cb, cr, both;  // `both`: Cb with Cr below it

  static ChromaPlanes Of(const cv::Mat& i420) {
    const int width = i420.cols / 2, height = i420.rows / 3;
    const cv::Mat both(2 * height, width, CV_8UC1, i420.data + std::size_t{4} * width * height);
    return {both.rowRange(0, height), both.rowRange(height, 2 * height), both};
  }

  cv::Size Size() const { return cb.size(); }
  cv::Vec2d At(int y, int x) const { return {cr.at<uchar>(y, x) - kNone, cb.at<uchar>(y, x) - kNone}; }  // Cr, Cb
};

// A place in the picture among the samples, each in the middle of its four pixels.
inline Eigen::Vector2d ChromaFromPx(const Eigen::Vector2d& px) {
  return 0.5 * (px - Eigen::Vector2d::Constant(0.5));
}

inline Eigen::Vector2d PxFromChroma(const Eigen::Vector2d& sample) {
  return 2 * sample + Eigen::Vector2d::Constant(0.5);
}

}  // namespace lake::tracking
