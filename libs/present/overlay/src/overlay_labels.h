// Where small labels go, so that they cover neither a marker nor each other, and stay put from frame to frame.
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

namespace lake::overlay {

class OverlayLabels {
 public:
  explicit OverlayLabels(cv::Size picture) : picture_(picture) {}

  // Forgets the frame before, except on which side each label stood.
  void Begin() {
    taken_.clear();
    lines_.clear();
  }

  // What labels of this frame should not cover: areas, and lines (less important).
  void Avoid(const cv::Rect2d& area) { taken_.push_back(area); }
  void AvoidLine(cv::Point2d from, cv::Point2d to) { lines_.emplace_back(from, to); }

  // Top left corner for a label of this size round a disc, one of eight sides; `name` tells labels apart over time.
  cv::Point2d Place(const std::string& name, cv::Point2d centre, double radius_px, cv::Size2d size);

 private:
  double Cost(const cv::Rect2d& label) const;

  cv::Size picture_;
  std::vector<cv::Rect2d> taken_;
  std::vector<std::pair<cv::Point2d, cv::Point2d>> lines_;
  std::map<std::string, int> side_;  // chosen last
};

}  // namespace lake::overlay
