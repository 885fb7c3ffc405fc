// How well a marker could be located at best.
#pragma once

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <string>

#include "lake/core/error.h"
#include "lake/synth/scene.h"

namespace lake {

// The part of a normal value's information on its mean that is left when it is clipped `z` standard deviations above
// the mean: the unclipped ones tell u², the clipped ones together the square of the mean of their u.
inline double InformationKept(double z) {
  if (z > 8) return 1;
  const double density = std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi);
  const double below = 0.5 * std::erfc(-z / std::numbers::sqrt2), above = 0.5 * std::erfc(z / std::numbers::sqrt2);
  return below - z * density + (above > 0 ? density * density / above : 0);
}

// The difference quotient of the picture with the marker moved along one axis, on the region of the unmoved one.
inline cv::Mat Derivative(const synth::Scene& scene, int frame, const std::string& marker, const Eigen::Vector2d& axis,
                          const cv::Rect& region) {
  constexpr double kStep = 0.05;  // px; its square against the squared point-spread is the relative error, below 1 %
  cv::Mat derivative = cv::Mat::zeros(region.size(), CV_64FC(scene.Options().colour ? 3 : 1));
  for (const double side : {-1.0, 1.0}) {
    const synth::ImagePatch moved = scene.RenderMarker(frame, marker, side * kStep * axis);
    const cv::Rect common = cv::Rect(moved.corner, moved.image.size()) & region;
    cv::Mat part;
    moved.image(common - moved.corner).convertTo(part, CV_64F, side / (2 * kStep));
    derivative(common - region.tl()) += part;
  }
  return derivative;
}

// The Cramér–Rao bound of a marker's position in one frame, as recorded without compression: standard deviation in px
// per axis (x, y).
//
// The noise is the rendering's own (NoiseVariance at each pixel, rounding included; pixels that saturate count by the
// information that a clipped normal value keeps). Everything but the two coordinates is taken as known: radius, level,
// point-spread, what lies behind. For a symmetric marker before an even background, estimating those too does not
// change the bound, as they move the picture evenly and the position oddly. Derivatives are central differences of
// noise-free renderings. Throws Error if the marker is outside the picture or cannot be located at all (wholly hidden).
inline Eigen::Vector2d CramerRaoBound(const synth::Scene& scene, int frame, const std::string& marker) {
  const synth::ImagePatch patch = scene.RenderMarker(frame, marker, Eigen::Vector2d::Zero());
  const cv::Rect region(patch.corner, patch.image.size());
  const cv::Mat levels = scene.RenderIdeal(frame)(region).clone();
  const cv::Mat dx = Derivative(scene, frame, marker, Eigen::Vector2d::UnitX(), region);
  const cv::Mat dy = Derivative(scene, frame, marker, Eigen::Vector2d::UnitY(), region);
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  const int values = region.width * levels.channels();
  for (int row = 0; row < region.height; ++row)
    for (int i = 0; i < values; ++i) {
      const double level = levels.ptr<float>(row)[i], variance = synth::NoiseVariance(scene.Options().noise, level);
      const Eigen::Vector2d gradient(dx.ptr<double>(row)[i], dy.ptr<double>(row)[i]);
      information += InformationKept((255 - level) / std::sqrt(variance)) / variance * gradient * gradient.transpose();
    }
  if (!(information.determinant() > 0)) throw Fail("frame {}: nothing is to be seen of marker '{}'", frame, marker);
  return information.inverse().diagonal().cwiseSqrt();
}

}  // namespace lake
