// Pictures made half as wide and high.
#pragma once

#include <opencv2/core/mat.hpp>

namespace lake::video {

// CV_8UC1: the mean of each four pixels, rounded (halves up); as cv::resize with INTER_AREA has it, in half the time.
// A last odd row or column is left out. `half` is created where it does not have that size.
void Halve(const cv::Mat& picture, cv::Mat& half);

// Also from full range, 0..255, to limited: luma to 16..235, chroma to 16..240.
enum class Sample { kLuma, kChroma };
void HalveToLimitedRange(const cv::Mat& picture, Sample sample, cv::Mat& half);

}  // namespace lake::video
