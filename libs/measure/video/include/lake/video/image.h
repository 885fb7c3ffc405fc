// Single pictures, through the same decoders as videos.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace lake::video {

// CV_8UC3 BGR if `colour`, else CV_8UC1, turned upright as its EXIF orientation says. PNG, JPEG, TIFF, BMP and what
// else libav decodes; of a video its first frame. Throws Error as VideoReader does.
cv::Mat ReadImage(const std::filesystem::path& path, bool colour);

// A CV_8UC1 or CV_8UC3 (BGR) picture as PNG, atomically. Throws Error (a full disk, another type of matrix).
void WriteImage(const std::filesystem::path& path, const cv::Mat& image);

}  // namespace lake::video
