// Single pictures: a frame of the recording (CV_8UC1) with what a person is to see in it. All are CV_8UC3.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
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

// For the person who names the markers: at least 1280 px wide, a whole multiple of the picture.
cv::Mat DrawNumberedSpots(const cv::Mat& luma, const std::vector<NumberedSpot>& spots);

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
  cv::Mat frame;
  std::vector<Spot> spots;
  std::vector<Line> lines;
  std::string title, legend;  // above the lines; below the frame
};

// 1600 px wide: the frame with the spots taken for markers on the left, the findings on the recording on the right.
cv::Mat DrawCheckPicture(const CheckPicture& picture);

struct KneesPicture {
  cv::Mat frame;
  Eigen::Vector2d knee, joint;       // px
  std::vector<Eigen::Vector2d> leg;  // px, the markers that are to be seen, from the ground up: they are in the picture
  std::string distance;              // "37 mm"
};

// 640 px wide: the part of the frame with the leg, the person's knee, the exoskeleton's joint and their distance.
cv::Mat DrawKnees(const KneesPicture& picture);

}  // namespace lake::overlay
