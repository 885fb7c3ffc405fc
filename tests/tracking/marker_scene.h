// Marker images made another way than the detector's model: the disc's exact area in fine cells, blurred by a sampled
// Gaussian, summed into pixels. For tests of position, not of whole recordings (libs/synth renders those).
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

namespace lake {

struct SceneMarker {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double radius_px = 4;
  double amplitude = 150;
  Eigen::Vector2d blur_px = Eigen::Vector2d::Zero();
  double aspect = 1;  // vertical over horizontal axis
};

struct SceneNoise {
  double read_sd = 1.5;
  double gain = 0.01;
};

// Noise-free grey levels, CV_64F.
inline cv::Mat DrawMarkers(const cv::Size& size, const std::vector<SceneMarker>& markers, double psf_px,
                           double background) {
  constexpr int kCells = 8;  // per pixel and axis
  cv::Mat fine(size * kCells, CV_64F, cv::Scalar(0));
  cv::Rect lit;  // where there is light, in cells
  for (const SceneMarker& marker : markers) {
    const int exposures = marker.blur_px.norm() > 0 ? 200 : 1;
    for (int e = 0; e < exposures; ++e) {
      const Eigen::Vector2d center = marker.center + ((e + 0.5) / exposures - 0.5) * marker.blur_px;
      const double reach = marker.radius_px + 2, inside = std::max(0.0, marker.radius_px - 1.0 / kCells),
                   outside = marker.radius_px + 1.0 / kCells;
      const double left = (center.x() - reach) * kCells, top = (center.y() - reach) * kCells, side = 2 * reach * kCells;
      lit |= cv::Rect(cv::Rect2d(left, top, side, side));
      for (int y = int((center.y() - reach) * kCells); y < int((center.y() + reach) * kCells); ++y)
        for (int x = int((center.x() - reach) * kCells); x < int((center.x() + reach) * kCells); ++x) {
          if (x < 0 || y < 0 || x >= fine.cols || y >= fine.rows) continue;
          const double u = (x + 0.5) / kCells - 0.5 - center.x(),
                       v = ((y + 0.5) / kCells - 0.5 - center.y()) / marker.aspect;
          const double squared = u * u + v * v;  // whose root only cells at the edge need
          if (squared > outside * outside) continue;
          const double coverage = squared < inside * inside
                                      ? 1
                                      : std::clamp((marker.radius_px - std::sqrt(squared)) * kCells + 0.5, 0.0, 1.0);
          fine.at<double>(y, x) += marker.amplitude * coverage / exposures;
        }
    }
  }
  const int spread = static_cast<int>(std::ceil(4 * psf_px * kCells)) + 2;  // beyond the end of OpenCV's kernel
  const cv::Rect touched =
      cv::Rect(lit.tl() - cv::Point(spread, spread), lit.br() + cv::Point(spread, spread)) & cv::Rect({}, fine.size());
  if (psf_px > 0 && !touched.empty()) cv::GaussianBlur(fine(touched), fine(touched), {}, psf_px * kCells);
  cv::Mat grey;
  cv::resize(fine, grey, size, 0, 0, cv::INTER_AREA);
  return grey + background;
}

inline cv::Mat AddNoise(const cv::Mat& levels, const SceneNoise& noise, std::mt19937& generator) {
  std::normal_distribution<double> normal;
  cv::Mat grey(levels.size(), CV_8U);
  for (int y = 0; y < levels.rows; ++y)
    for (int x = 0; x < levels.cols; ++x) {
      const double level = levels.at<double>(y, x);
      const double noisy = level + normal(generator) * std::sqrt(noise.read_sd * noise.read_sd + noise.gain * level);
      grey.at<uchar>(y, x) = cv::saturate_cast<uchar>(noisy);
    }
  return grey;
}

}  // namespace lake
