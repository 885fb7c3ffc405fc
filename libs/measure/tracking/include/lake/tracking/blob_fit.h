// Where a marker is, to a few hundredths of a pixel: least-squares fit of a model of its image.
//
// Model of a pixel's grey level, u = offset of the pixel from the blob's centre:
//
//   I(u) = b0 + (b1 u.x + b2 u.y) (1 - L(u)) + A L(u),
//   L(u) = mean over the exposure of Phi(d(u - tau * blur) / edge),   tau in [-1/2, 1/2]
//
// (the marker hides what is behind it) with Phi the normal distribution function and d the signed distance (positive
// inside) to the ellipse |M u| = 1, to first order (Sampson 1982): d(u) = (1 - |M u|) |M u| / |M^T M u|. This is a
// disc, seen obliquely, through a Gaussian point-spread and the pixel's area, streaked by its motion. Its parameters
// apart from the centre are symmetric about the centre, so fitting them costs the position no precision, and the
// position reaches the Cramér–Rao bound of the image noise but for the background's slope: 4 % at a radius of 4 px.
//
// Neighbours whose images touch are fitted together with one background, as a neighbour's light would pull an isolated
// fit.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <vector>

namespace lake::tracking {

// The variance of a pixel's grey level: read noise² + gain × level. In grey levels.
struct NoiseModel {
  double read_variance = 4;
  double gain = 0;

  double Variance(double level) const { return read_variance + gain * (level > 0 ? level : 0); }
};

struct Blob {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();                   // px, image frame
  Eigen::Matrix2d unit_circle_from_px = Eigen::Matrix2d::Identity();  // M, symmetric; 1/radius for a disc
  double edge_px = 0.8;                               // standard deviation of the edge: point-spread and pixel area
  Eigen::Vector2d blur_px = Eigen::Vector2d::Zero();  // path during the exposure
  double amplitude = 0;                               // grey levels above the background

  double RadiusPx() const;  // of the disc of equal area
  // Where its light is 100 grey levels, or half of what it has. Where a marker saturates, radius, edge and amplitude
  // take each other's place from frame to frame; this is measured all the same.
  double ApparentRadiusPx() const;
  double AspectRatio() const;  // longest over shortest axis, >= 1
};

Blob DiscBlob(const Eigen::Vector2d& center, double radius_px);

struct BlobFit {
  Blob blob;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of the centre, px², from the fit's own residuals
  double background = 0;                                 // grey level under the centre
  double chi_square = 0;  // mean of (residual / noise sd)² per degree of freedom: 1 if model and noise are right
  double relative_residual = 0;  // root mean square residual over amplitude

  // One standard deviation per axis, px.
  double SigmaPx() const;
};

struct BlobFitOptions {
  NoiseModel noise;
  double shape_freedom = 1;      // relative standard deviation of the given axes and edge as prior knowledge
  double streak_freedom_px = 0;  // standard deviation of the given paths during the exposure; 0: they are as given
  double slope_freedom =
      0.003;             // the background's slope per px over the amplitude: its standard deviation as prior knowledge
  double margin_px = 2;  // background beyond 2.5 edge widths that takes part in the fit
  double saturation_level = 255;  // a pixel of this level may have been any brighter
  double huber = 3;               // residuals beyond this many noise sd count linearly
  int max_iterations = 20;
  double converged_px = 0.002;  // last step of a centre; each is at most about half of the one before it
  // After max_iterations: where pixels cross the saturation the cost jumps, and steps of a few 0.001 px need not end.
  double usable_px = 0.02;
};

// Fits all starts together (at most kMaxJointBlobs). nullopt if it does not converge, a blob leaves the picture, loses
// its contrast or its size, or wanders further from its start than its own radius plus blur.
inline constexpr std::size_t kMaxJointBlobs = 4;
std::optional<std::vector<BlobFit>> FitBlobs(const cv::Mat& grey, std::span<const Blob> starts,
                                             const BlobFitOptions& options);

}  // namespace lake::tracking
