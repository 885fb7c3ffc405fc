#include "lake/synth/cramer_rao.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "lake/core/error.h"

namespace lake::synth {
namespace {

using Eigen::Vector2d;

// The part of a normal value's information on its mean that is left when it is clipped `z` standard deviations above
// the mean: the unclipped ones tell u², the clipped ones together the square of the mean of their u.
double InformationKept(double z) {
  if (z > 8) return 1;
  const double density = std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi);
  const double below = 0.5 * std::erfc(-z / std::numbers::sqrt2), above = 0.5 * std::erfc(z / std::numbers::sqrt2);
  return below - z * density + (above > 0 ? density * density / above : 0);
}

// The difference quotient of the picture with the marker moved along one axis, on the region of the unmoved one.
cv::Mat Derivative(const Scene& scene, int frame, const std::string& marker, const Vector2d& axis,
                   const cv::Rect& region) {
  constexpr double kStep = 0.05;  // px; its square against the squared point-spread is the relative error, below 1 %
  cv::Mat derivative = cv::Mat::zeros(region.size(), CV_64FC(scene.Options().colour ? 3 : 1));
  for (const double side : {-1.0, 1.0}) {
    const ImagePatch moved = scene.RenderMarker(frame, marker, side * kStep * axis);
    const cv::Rect common = cv::Rect(moved.corner, moved.image.size()) & region;
    cv::Mat part;
    moved.image(common - moved.corner).convertTo(part, CV_64F, side / (2 * kStep));
    derivative(common - region.tl()) += part;
  }
  return derivative;
}

}  // namespace

Vector2d CramerRaoBound(const Scene& scene, int frame, const std::string& marker) {
  const ImagePatch patch = scene.RenderMarker(frame, marker, Vector2d::Zero());
  const cv::Rect region(patch.corner, patch.image.size());
  const cv::Mat levels = scene.RenderIdeal(frame)(region).clone();
  const cv::Mat dx = Derivative(scene, frame, marker, Vector2d::UnitX(), region);
  const cv::Mat dy = Derivative(scene, frame, marker, Vector2d::UnitY(), region);
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  const int values = region.width * levels.channels();
  for (int row = 0; row < region.height; ++row)
    for (int i = 0; i < values; ++i) {
      const double level = levels.ptr<float>(row)[i], variance = NoiseVariance(scene.Options().noise, level);
      const Vector2d gradient(dx.ptr<double>(row)[i], dy.ptr<double>(row)[i]);
      information += InformationKept((255 - level) / std::sqrt(variance)) / variance * gradient * gradient.transpose();
    }
  if (!(information.determinant() > 0)) throw Fail("frame {}: nothing is to be seen of marker '{}'", frame, marker);
  return information.inverse().diagonal().cwiseSqrt();
}

}  // namespace lake::synth
