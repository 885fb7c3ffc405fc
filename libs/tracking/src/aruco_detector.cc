// ArUco markers: identity by their code, position where the diagonals cross.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "lake/core/error.h"
#include "lake/tracking/marker_detector.h"
#include "lake/tracking/noise_estimate.h"

namespace lake {
namespace {

constexpr int kCornerWindow = 4;  // half size in px of what a corner is refined in

cv::Ptr<cv::aruco::Dictionary> DictionaryByName(const std::string& name) {
  static const std::array<const char*, 17> kNames = {
      "DICT_4X4_50",  "DICT_4X4_100",  "DICT_4X4_250", "DICT_4X4_1000", "DICT_5X5_50",        "DICT_5X5_100",
      "DICT_5X5_250", "DICT_5X5_1000", "DICT_6X6_50",  "DICT_6X6_100",  "DICT_6X6_250",       "DICT_6X6_1000",
      "DICT_7X7_50",  "DICT_7X7_100",  "DICT_7X7_250", "DICT_7X7_1000", "DICT_ARUCO_ORIGINAL"};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (name == kNames[i])
      return cv::aruco::getPredefinedDictionary(static_cast<int>(i));  // OpenCV numbers them in this order
  throw UsageError(fmt::format("ArUco dictionary '{}' is not known; there are {}", name, fmt::join(kNames, ", ")));
}

Eigen::Vector2d Cross(const std::vector<cv::Point2f>& c) {
  const auto point = [&](int i) {
    return Eigen::Vector2d(c[static_cast<std::size_t>(i)].x, c[static_cast<std::size_t>(i)].y);
  };
  const auto first = Eigen::Hyperplane<double, 2>::Through(point(0), point(2));
  return first.intersection(Eigen::Hyperplane<double, 2>::Through(point(1), point(3)));
}

// Variance per axis of a corner found by cv::cornerSubPix: noise over the gradients' structure.
double CornerVariance(const cv::Mat& grey, const cv::Point2f& corner, double noise_variance) {
  Eigen::Matrix2d structure = Eigen::Matrix2d::Zero();
  for (int y = -kCornerWindow; y <= kCornerWindow; ++y)
    for (int x = -kCornerWindow; x <= kCornerWindow; ++x) {
      const int px = std::clamp(static_cast<int>(std::lround(corner.x)) + x, 1, grey.cols - 2);
      const int py = std::clamp(static_cast<int>(std::lround(corner.y)) + y, 1, grey.rows - 2);
      const Eigen::Vector2d gradient(0.5 * (grey.at<uchar>(py, px + 1) - grey.at<uchar>(py, px - 1)),
                                     0.5 * (grey.at<uchar>(py + 1, px) - grey.at<uchar>(py - 1, px)));
      structure += gradient * gradient.transpose();
    }
  return noise_variance * structure.inverse().trace() / 2;
}

class ArucoDetector : public MarkerDetector {
 public:
  ArucoDetector(const std::string& dictionary, const DetectorRegion& region)
      : dictionary_(DictionaryByName(dictionary)),
        parameters_(cv::aruco::DetectorParameters::create()),
        crop_(region.crop) {
    parameters_->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
    parameters_->cornerRefinementWinSize = kCornerWindow;
  }

  bool KnowsIdentities() const override { return true; }

  std::vector<MarkerDetection> Detect(const VideoFrame& frame, std::span<const MarkerPrediction> /*predictions*/,
                                      bool /*everywhere*/) override {
    constexpr int kNoiseFrames = 6;
    if (noise_.Frames() < kNoiseFrames) noise_.Add(frame.luma);
    const cv::Rect all(0, 0, frame.luma.cols, frame.luma.rows), box = crop_.empty() ? all : crop_ & all;
    std::vector<std::vector<cv::Point2f>> corners;
    std::vector<int> ids;
    cv::aruco::detectMarkers(frame.luma(box), dictionary_, corners, ids, parameters_);
    std::vector<MarkerDetection> found;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      for (cv::Point2f& corner : corners[i])
        corner += cv::Point2f(static_cast<float>(box.x), static_cast<float>(box.y));
      found.push_back(Measure(frame.luma, corners[i], ids[i]));
    }
    return found;
  }

 private:
  MarkerDetection Measure(const cv::Mat& grey, const std::vector<cv::Point2f>& corners, int id) const {
    const double noise = noise_.Estimate().Variance(128);
    double variance = 0;
    for (const cv::Point2f& corner : corners) variance += CornerVariance(grey, corner, noise) / 16;  // mean of four
    MarkerDetection detection;
    detection.position = Cross(corners);
    detection.sigma_px = std::sqrt(variance);
    detection.appearance = DiscBlob(detection.position, std::sqrt(cv::contourArea(corners) / M_PI));
    detection.appearance.amplitude = 1;
    detection.identity = id;
    return detection;
  }

  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  cv::Ptr<cv::aruco::DetectorParameters> parameters_;
  cv::Rect crop_;
  NoiseEstimator noise_;
};

}  // namespace

std::unique_ptr<MarkerDetector> MakeArucoDetector(const std::string& dictionary, const DetectorRegion& region) {
  return std::make_unique<ArucoDetector>(dictionary, region);
}

}  // namespace lake
