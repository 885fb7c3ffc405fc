// ArUco markers: identity by their code, position where the diagonals cross.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "detector_kinds.h"
#include "lake/camera/aruco_dictionary.h"
#include "lake/camera/aruco_opencv.h"
#include "lake/core/error.h"

namespace lake::tracking {
namespace {

cv::aruco::Dictionary DictionaryByName(const std::string& name) {
  const std::optional<camera::ArucoDictionary> found = camera::FindArucoDictionary(name);
  if (!found)
    throw UsageError("ArUco dictionary '{}' is not known; there are {}", name, camera::ArucoDictionaryNames());
  return camera::PredefinedArucoDictionary(found->id);
}

Eigen::Vector2d Cross(const std::array<Eigen::Vector2d, 4>& c) {
  const auto first = Eigen::Hyperplane<double, 2>::Through(c[0], c[2]);
  return first.intersection(Eigen::Hyperplane<double, 2>::Through(c[1], c[3]));
}

double Level(const cv::Mat& grey, const Eigen::Vector2d& place) {
  const double x = std::clamp(place.x(), 0.0, grey.cols - 1.001), y = std::clamp(place.y(), 0.0, grey.rows - 1.001);
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const auto row = [&](int r) { return std::lerp(grey.at<uchar>(r, left), grey.at<uchar>(r, left + 1), x - left); };
  return std::lerp(row(top), row(top + 1), y - top);
}

// Where a profile across an edge, from dark inside (negative) to bright outside, rises: the centre of its slope.
std::optional<double> EdgePlace(const cv::Mat& grey, const Eigen::Vector2d& middle, const Eigen::Vector2d& outward,
                                double reach_px) {
  constexpr double kStep = 0.5;
  constexpr double kLeastRise = 15;  // grey levels
  double rise = 0, moment = 0, last = Level(grey, middle - reach_px * outward);
  for (double s = -reach_px + kStep; s <= reach_px; s += kStep) {
    const double level = Level(grey, middle + s * outward), slope = std::max(level - last, 0.0);
    rise += slope;
    moment += slope * (s - kStep / 2);
    last = level;
  }
  return rise > kLeastRise ? std::optional(moment / rise) : std::nullopt;
}

// One side of the square: offset outward and turn against the line through its two corners; px and px per half length.
struct Side {
  Eigen::Vector2d offset_and_turn = Eigen::Vector2d::Zero();
  double offset_variance = 0;
};

// A straight line through the edge's places, robustly: Huber weights.
std::optional<Side> FitSide(const cv::Mat& grey, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                            const Eigen::Vector2d& outward, double reach_px) {
  constexpr double kHuberPx = 0.2, kUsedHalf = 0.8;  // near its ends an edge is round
  constexpr int kLeastPlaces = 5, kRounds = 3;
  const Eigen::Vector2d middle = 0.5 * (from + to), half = 0.5 * (to - from);
  std::vector<Eigen::Vector2d> places;  // along, in half lengths, and outward
  const int count = static_cast<int>(2 * kUsedHalf * half.norm());
  for (int i = 0; i <= count; ++i) {
    const double along = kUsedHalf * (2.0 * i / std::max(count, 1) - 1);
    if (const auto place = EdgePlace(grey, middle + along * half, outward, reach_px))
      places.emplace_back(along, *place);
  }
  if (static_cast<int>(places.size()) < kLeastPlaces) return std::nullopt;
  Side side;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    double square_sum = 0;
    for (const Eigen::Vector2d& place : places) {
      const Eigen::Vector2d row(1, place.x());
      const double residual = place.y() - row.dot(side.offset_and_turn);
      const double weight = round == 0 ? 1 : kHuberPx / std::max(kHuberPx, std::abs(residual));
      normal += weight * row * row.transpose();
      right += weight * place.y() * row;
      square_sum += weight * residual * residual;
    }
    side.offset_and_turn = normal.ldlt().solve(right);
    side.offset_variance = square_sum / (static_cast<double>(places.size()) - 2) * normal.inverse()(0, 0);
  }
  return side;
}

struct Square {
  std::array<Eigen::Vector2d, 4> corners;
  double center_variance = 0;  // per axis, px²
};

// The corners as the crossings of the four sides, each a line through tens of places of its edge. Corners found by
// themselves (cv::cornerSubPix) were off by up to 2.5 px on codes of 5 px per cell, which disturb its window.
std::optional<Square> FitSquare(const cv::Mat& grey, const std::vector<cv::Point2f>& start, int cells) {
  constexpr int kRounds = 3;
  Square square;
  for (std::size_t i = 0; i < 4; ++i) square.corners[i] = Eigen::Vector2d(start[i].x, start[i].y);
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector2d center =
        0.25 * (square.corners[0] + square.corners[1] + square.corners[2] + square.corners[3]);
    std::array<Eigen::Hyperplane<double, 2>, 4> lines;
    double variance = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d &from = square.corners[i], &to = square.corners[(i + 1) % 4];
      const double length = (to - from).norm();
      Eigen::Vector2d outward = Eigen::Vector2d(to.y() - from.y(), from.x() - to.x()) / length;
      if (outward.dot(0.5 * (from + to) - center) < 0) outward = -outward;
      const double reach = std::clamp(0.6 * length / cells, 1.5, 4.0);
      const auto side = FitSide(grey, from, to, outward, reach);
      if (!side) return std::nullopt;
      const double offset = side->offset_and_turn[0], turn = side->offset_and_turn[1];
      lines[i] =
          Eigen::Hyperplane<double, 2>::Through(from + (offset - turn) * outward, to + (offset + turn) * outward);
      variance += side->offset_variance / 8;  // an axis is the mean of two opposite sides; both axes averaged
    }
    for (std::size_t i = 0; i < 4; ++i) square.corners[i] = lines[(i + 3) % 4].intersection(lines[i]);
    square.center_variance = variance;
  }
  return square;
}

class ArucoDetector : public MarkerDetector {
 public:
  ArucoDetector(const std::string& dictionary, const DetectorRegion& region, int markers)
      : dictionary_(DictionaryByName(dictionary)),
        region_(region),
        markers_(markers),
        least_perimeter_(parameters_.minMarkerPerimeterRate) {
    parameters_.cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;
  }

  bool KnowsIdentities() const override { return true; }

  std::vector<MarkerDetection> Detect(const video::VideoFrame& frame, std::span<const MarkerPrediction> predictions,
                                      Look look) override {
    if (look == Look::kNearAgain)
      return FindWhereExpected(frame.luma, predictions).value_or(std::vector<MarkerDetection>());
    if (look == Look::kNear && AreAllFollowed(predictions))
      if (auto found = FindWhereExpected(frame.luma, predictions)) return *std::move(found);
    return FindIn(frame.luma, region_.Of(frame.luma), kAllWindows);
  }

 private:
  bool AreAllFollowed(std::span<const MarkerPrediction> predictions) const {
    for (int id = 0; id < markers_; ++id)
      if (std::none_of(predictions.begin(), predictions.end(), [&](const auto& p) { return p.identity == id; }))
        return false;
    return markers_ > 0;
  }

  // nullopt if one of them is not there. One window finds nearly all that three find; where it does not, all look at
  // the whole picture.
  std::optional<std::vector<MarkerDetection>> FindWhereExpected(const cv::Mat& grey,
                                                                std::span<const MarkerPrediction> predictions) {
    constexpr double kReachRadii = 3, kMarginPx = 12;  // a square's corner is 1.25 of its disc's radii from the middle
    std::vector<MarkerDetection> all;
    for (const MarkerPrediction& prediction : predictions) {
      const double reach = kReachRadii * prediction.appearance.RadiusPx() + kMarginPx;
      const cv::Rect box(static_cast<int>(prediction.position.x() - reach),
                         static_cast<int>(prediction.position.y() - reach), static_cast<int>(2 * reach),
                         static_cast<int>(2 * reach));
      const std::vector<MarkerDetection> there = FindIn(grey, box & region_.Of(grey), kUsualWindow);
      const auto own = std::find_if(there.begin(), there.end(),
                                    [&](const MarkerDetection& d) { return d.identity == prediction.identity; });
      if (own == there.end()) return std::nullopt;
      all.push_back(*own);
    }
    return all;
  }

  // Sides of the windows, px, over whose mean a pixel is bright or dark: from, to, in steps of 10.
  struct ThresholdWindows {
    int least, most;
  };
  static constexpr ThresholdWindows kAllWindows{3, 23}, kUsualWindow{13, 13};

  // A square is as large as it must be in the whole picture.
  std::vector<MarkerDetection> FindIn(const cv::Mat& grey, const cv::Rect& box, const ThresholdWindows& windows) {
    if (box.empty()) return {};
    parameters_.adaptiveThreshWinSizeMin = windows.least;
    parameters_.adaptiveThreshWinSizeMax = windows.most;
    const cv::Rect whole = region_.Of(grey);
    parameters_.minMarkerPerimeterRate =
        least_perimeter_ * std::max(whole.width, whole.height) / std::max(box.width, box.height);
    auto [corners, ids] = camera::DetectArucoMarkers(grey(box), dictionary_, parameters_);
    std::vector<MarkerDetection> found;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      for (cv::Point2f& corner : corners[i])
        corner += cv::Point2f(static_cast<float>(box.x), static_cast<float>(box.y));
      if (const auto square = FitSquare(grey, corners[i], dictionary_.markerSize + 2))
        found.push_back(Measure(*square, corners[i], ids[i]));
    }
    return found;
  }

  static MarkerDetection Measure(const Square& square, const std::vector<cv::Point2f>& corners, int id) {
    MarkerDetection detection;
    detection.position = Cross(square.corners);
    detection.sigma_px = std::sqrt(square.center_variance);
    detection.appearance = DiscBlob(detection.position, std::sqrt(cv::contourArea(corners) / M_PI));
    detection.appearance.amplitude = 1;
    detection.identity = id;
    return detection;
  }

  cv::aruco::Dictionary dictionary_;
  cv::aruco::DetectorParameters parameters_;
  DetectorRegion region_;
  int markers_;
  double least_perimeter_;  // as a part of the picture's longer side
};

}  // namespace

std::unique_ptr<MarkerDetector> MakeArucoDetector(const std::string& dictionary, const DetectorRegion& region) {
  return std::make_unique<ArucoDetector>(dictionary, region, 0);
}

DetectorKind ArucoKind() {
  return {.name = "aruco",
          .prepare = [](const std::filesystem::path&, const TrackOptions& options) -> DetectorMaker {
            return [dictionary = options.dictionary,
                    markers = static_cast<int>(options.names.size())](const DetectorRegion& region) {
              return std::make_unique<ArucoDetector>(dictionary, region, markers);
            };
          },
          .identities = IdentitiesInOrder,
          .check = [](const TrackOptions&) {},
          .click = DetectorKind::Click::kAnywhere};
}

}  // namespace lake::tracking
