// A frame of an exoskeleton trial with the person's knee, the exoskeleton's joint and the distance between them.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace lake::overlay {

struct KneesPicture {
  cv::Mat frame;                     // CV_8UC1
  Eigen::Vector2d knee, joint;       // px
  std::vector<Eigen::Vector2d> leg;  // px, the markers that are to be seen, from the ground up: they are in the picture
  std::string distance;              // "37 mm"
};

// CV_8UC3, 640 px wide: the part of the frame with the leg.
cv::Mat DrawKnees(const KneesPicture& picture);

}  // namespace lake::overlay
