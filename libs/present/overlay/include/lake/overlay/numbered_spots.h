// A frame of the recording with numbered spots, for the person who names the markers.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace lake::overlay {

struct NumberedSpot {
  int id = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // px of the picture
  double radius_px = 0;
  bool in_frame = true;               // else it was seen in other frames only, and its ring is dashed
  bool moves = false;                 // what rests is drawn fainter
  std::vector<Eigen::Vector2d> path;  // px
};

// Writes a PNG of at least 1280 px in width, in whole multiples of the picture. Throws Error if it cannot be written;
// then there is no file.
void DrawNumberedSpots(const cv::Mat& luma, const std::vector<NumberedSpot>& spots, const std::filesystem::path& out);

}  // namespace lake::overlay
