// Whether a picture is the one before it once more. Not part of the interface.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace lake::tracking {

// Something that moves: where it was in the picture before, and how far it should have come since.
struct ExpectedStep {
  Eigen::Vector2d position, step;  // px
  double radius_px = 0;
};

// Compares two hypotheses about all that should have moved: that the picture is the one before, up to coding noise, and
// that everything is where it was expected. False also where nothing moves by a third of a pixel or more, as nothing
// can be detected then.
bool IsRepeated(const cv::Mat& before, const cv::Mat& now, const std::vector<ExpectedStep>& expected);

// How unlike the picture round all places is to that before, if everything made its expected step: of squared grey
// levels, relative to how uneven the picture is there. 0 is perfect; a marker that is off by a pixel of its radius of
// four makes 0.12. NaN if nothing was expected to move.
double Mismatch(const cv::Mat& before, const cv::Mat& now, const std::vector<ExpectedStep>& expected);

}  // namespace lake::tracking
