// Where blobs could be: a coarse search of a whole picture or a part of it, to start precise fits from.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace lake::tracking {

struct BlobCandidate {
  Eigen::Vector2d position;  // px, to about half a radius
  double radius_px = 0;      // to about a factor of 1.5
  double contrast = 0;       // grey levels above the surroundings
};

struct BlobSearchOptions {
  double min_radius_px = 1.5;
  double max_radius_px = 40;
  double min_contrast = 10;     // grey levels
  std::size_t max_count = 128;  // the strongest are kept
  bool streaks = false;         // also what goes on as a line
};

// Bright spots that are darker all round, strongest first: maxima of centre minus surroundings over a pyramid of halved
// pictures (a difference of boxes; Lindeberg 1998 for the principle), without edges and, unless `streaks`, lines.
// `region` limits the search; positions are those of the whole picture.
std::vector<BlobCandidate> FindBlobs(const cv::Mat& grey, const cv::Rect& region, const BlobSearchOptions& options);

}  // namespace lake::tracking
