// A frame with the spots taken for markers, and beside it the findings on the recording.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace lake::overlay {

struct CheckPicture {
  struct Spot {
    Eigen::Vector2d position;  // px
    double radius_px = 0;
    std::string name{};  // of the marker; empty: another bright spot
  };
  struct Line {
    std::string text, advice;  // no advice: nothing to change
    int grade = 0;             // 0 good, 1 poor, 2 unfit, 3 not judged
  };
  cv::Mat frame;  // CV_8UC1
  std::vector<Spot> spots;
  std::vector<Line> lines;
  std::string title, legend;  // above the lines; below the frame
};

// CV_8UC3, 1600 px wide: the frame on the left, the lines on the right.
cv::Mat DrawCheckPicture(const CheckPicture& picture);

}  // namespace lake::overlay
