// OpenCV's ArUco functions, which have other names and types from OpenCV 4.7 on: the same for both.
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/core/version.hpp>
#include <vector>

#define LAKE_ARUCO_IN_OBJDETECT (CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7))
#if LAKE_ARUCO_IN_OBJDETECT
#include <opencv2/objdetect/charuco_detector.hpp>
#else
#include <opencv2/aruco/charuco.hpp>
#endif

namespace lake::camera {

// `id`: a cv::aruco::PREDEFINED_DICTIONARY_NAME.
inline cv::aruco::Dictionary PredefinedArucoDictionary(int id) {
#if LAKE_ARUCO_IN_OBJDETECT
  return cv::aruco::getPredefinedDictionary(id);
#else
  return *cv::aruco::getPredefinedDictionary(id);
#endif
}

// A marker with its black border of one cell; 8-bit grey, side_px × side_px.
inline cv::Mat DrawArucoMarker(const cv::aruco::Dictionary& dictionary, int marker, int side_px) {
  cv::Mat picture;
#if LAKE_ARUCO_IN_OBJDETECT
  dictionary.generateImageMarker(marker, side_px, picture, 1);
#else
  dictionary.drawMarker(marker, side_px, picture, 1);
#endif
  return picture;
}

struct ArucoMarkers {
  std::vector<std::vector<cv::Point2f>> corners;  // px, clockwise from each marker's own top left
  std::vector<int> ids;
};

inline ArucoMarkers DetectArucoMarkers(const cv::Mat& picture, const cv::aruco::Dictionary& dictionary,
                                       const cv::aruco::DetectorParameters& parameters = {}) {
  ArucoMarkers found;
#if LAKE_ARUCO_IN_OBJDETECT
  cv::aruco::ArucoDetector(dictionary, parameters).detectMarkers(picture, found.corners, found.ids);
#else
  cv::aruco::detectMarkers(picture, cv::makePtr<cv::aruco::Dictionary>(dictionary), found.corners, found.ids,
                           cv::makePtr<cv::aruco::DetectorParameters>(parameters));
#endif
  return found;
}

}  // namespace lake::camera
