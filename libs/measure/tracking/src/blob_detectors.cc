// The detectors that see blobs: reflective markers in the luma, coloured ones in how near each pixel is to a colour.
#include <algorithm>
#include <charconv>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "blob_finder.h"
#include "lake/core/error.h"
#include "lake/tracking/marker_detector.h"

namespace lake::tracking {
namespace {

class ReflectiveDetector : public MarkerDetector {
 public:
  ReflectiveDetector(Polarity polarity, const DetectorRegion& region) : polarity_(polarity), finder_(region) {}

  std::vector<MarkerDetection> Detect(const video::VideoFrame& frame, std::span<const MarkerPrediction> predictions,
                                      bool everywhere) override {
    if (polarity_ == Polarity::kBright) return finder_.Detect(frame.luma, predictions, everywhere);
    cv::bitwise_not(frame.luma, inverted_);
    return finder_.Detect(inverted_, predictions, everywhere);
  }

  std::optional<ImageFigures> Figures() const override { return finder_.Figures(); }

 private:
  Polarity polarity_;
  BlobFinder finder_;
  cv::Mat inverted_;
};

// A colour as a direction in the plane of Cr and Cb: its hue, which stays when the light changes.
struct Hue {
  cv::Vec2d direction;  // of (Cr, Cb), unit length
  double chroma = 0;    // of the pure colour
};

Hue HueOf(const cv::Vec3b& bgr) {
  const cv::Mat pixel(1, 1, CV_8UC3, cv::Scalar(bgr[0], bgr[1], bgr[2]));
  cv::Mat converted;
  cv::cvtColor(pixel, converted, cv::COLOR_BGR2YCrCb);
  const cv::Vec3b value = converted.at<cv::Vec3b>(0);
  const cv::Vec2d chroma(value[1] - 128.0, value[2] - 128.0);
  const double length = cv::norm(chroma);
  return {length > 0 ? chroma / length : chroma, length};
}

// How strongly each pixel has one of several hues: its chroma along that hue, where no other of the hues is nearer,
// less what is across it; 0 elsewhere. `ycrcb` as OpenCV makes it, 8-bit with 128 for none.
void MapHue(const cv::Mat& ycrcb, const std::vector<Hue>& hues, std::size_t wanted, cv::Mat& map) {
  constexpr double kGain = 2;      // lamps have a chroma of about 100
  constexpr double kAcross = 0.5;  // names of colours are vague: "blue" lamps are 50° away from #0000ff
  map.create(ycrcb.size(), CV_8U);
  for (int y = 0; y < ycrcb.rows; ++y) {
    const auto* in = ycrcb.ptr<cv::Vec3b>(y);
    uchar* out = map.ptr(y);
    for (int x = 0; x < ycrcb.cols; ++x) {
      const cv::Vec2d chroma(in[x][1] - 128.0, in[x][2] - 128.0);
      const cv::Vec2d& direction = hues[wanted].direction;
      const double along = chroma.dot(direction),
                   across = std::abs(chroma[1] * direction[0] - chroma[0] * direction[1]);
      const bool nearest =
          std::none_of(hues.begin(), hues.end(), [&](const Hue& hue) { return chroma.dot(hue.direction) > along; });
      out[x] = nearest ? cv::saturate_cast<uchar>(kGain * (along - kAcross * across)) : 0;
    }
  }
}

cv::Vec3b ParseColor(const std::string& text) {
  unsigned value = 0;
  const char* end = text.data() + text.size();
  if (text.size() != 7 || text[0] != '#' || std::from_chars(text.data() + 1, end, value, 16).ptr != end)
    throw UsageError(fmt::format("--color '{}': write a colour as \"#RRGGBB\"", text));
  return {static_cast<uchar>(value & 255), static_cast<uchar>(value >> 8 & 255), static_cast<uchar>(value >> 16)};
}

// Where a coloured spot is: the blob model's centre if it is a disc, else (lamps are long, streaked and burnt out) its
// centroid.
MarkerDetection MeasureSpot(const cv::Mat& map, const cv::Rect& box, double noise_variance) {
  const cv::Mat part = map(box);
  const cv::Moments moments = cv::moments(part);
  const Eigen::Vector2d centroid(box.x + moments.m10 / moments.m00, box.y + moments.m01 / moments.m00);
  double peak = 0;
  cv::minMaxLoc(part, nullptr, &peak);
  const double area = moments.m00 / peak;
  const Blob start = DiscBlob(centroid, std::sqrt(area / M_PI));
  BlobFitOptions options;
  options.noise.read_variance = noise_variance;
  const auto fit = FitBlobs(map, std::span(&start, 1), options);
  if (fit && IsMarkerLike(fit->front())) return MakeDetection(fit->front());
  MarkerDetection detection;
  detection.position = centroid;
  // Of the centroid of independent pixels: noise × the spot's extent over its light.
  detection.sigma_px =
      std::sqrt(noise_variance * 0.5 * (moments.mu20 + moments.mu02) / moments.m00 * static_cast<double>(box.area())) /
      moments.m00;
  detection.appearance = start;
  detection.appearance.amplitude = peak;
  detection.quality = 1;
  return detection;
}

class ColorDetector : public MarkerDetector {
 public:
  ColorDetector(const std::vector<std::string>& colors, const DetectorRegion& region) : region_(region) {
    constexpr double kMinChroma = 20;
    for (const std::string& color : colors) {
      hues_.push_back(HueOf(ParseColor(color)));
      if (hues_.back().chroma < kMinChroma)
        throw UsageError(
            fmt::format("--color '{}' is a grey: use --detector reflective, with --polarity dark for black", color));
    }
    noise_.resize(colors.size());
  }
  bool NeedsColour() const override { return true; }
  bool KnowsIdentities() const override { return hues_.size() > 1; }

  std::vector<MarkerDetection> Detect(const video::VideoFrame& frame, std::span<const MarkerPrediction> /*predictions*/,
                                      bool /*everywhere*/) override {
    const cv::Rect box = region_.Of(frame.bgr);
    cv::cvtColor(frame.bgr, ycrcb_, cv::COLOR_BGR2YCrCb);
    std::vector<MarkerDetection> found;
    for (std::size_t i = 0; i < hues_.size(); ++i) {
      MapHue(ycrcb_, hues_, i, map_);
      FillCores(map_);
      constexpr int kNoiseFrames = 6;
      if (noise_[i].Frames() < kNoiseFrames) noise_[i].Add(map_);
      FindSpots(box, static_cast<int>(i), found);
    }
    return found;
  }

 private:
  // The middle of a lamp is too bright to have a colour; it is filled from its rim.
  static void FillCores(cv::Mat& map) {
    constexpr int kCorePx = 11;
    static const cv::Mat kDisc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {kCorePx, kCorePx});
    cv::morphologyEx(map, map, cv::MORPH_CLOSE, kDisc);
    cv::GaussianBlur(map, map, {}, 1);
  }

  // Connected parts of the map that are at least half as strong as its strongest pixel, the largest few.
  void FindSpots(const cv::Rect& box, int identity, std::vector<MarkerDetection>& found) const {
    constexpr double kMinStrength = 40;
    constexpr int kMinArea = 8, kMarginPx = 3;
    constexpr std::size_t kMaxSpots = 6;
    double peak = 0;
    cv::minMaxLoc(map_(box), nullptr, &peak);
    if (peak < kMinStrength) return;
    cv::Mat labels, stats, centers;
    const int count = cv::connectedComponentsWithStats(map_(box) >= 0.5 * peak, labels, stats, centers);
    std::vector<int> order;
    for (int label = 1; label < count; ++label)
      if (stats.at<int>(label, cv::CC_STAT_AREA) >= kMinArea) order.push_back(label);
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return stats.at<int>(a, cv::CC_STAT_AREA) > stats.at<int>(b, cv::CC_STAT_AREA); });
    order.resize(std::min(order.size(), kMaxSpots));
    for (const int label : order) {
      const cv::Rect spot(box.x + stats.at<int>(label, cv::CC_STAT_LEFT) - kMarginPx,
                          box.y + stats.at<int>(label, cv::CC_STAT_TOP) - kMarginPx,
                          stats.at<int>(label, cv::CC_STAT_WIDTH) + 2 * kMarginPx,
                          stats.at<int>(label, cv::CC_STAT_HEIGHT) + 2 * kMarginPx);
      found.push_back(
          MeasureSpot(map_, spot & box, noise_[static_cast<std::size_t>(identity)].Estimate().Variance(128)));
      found.back().identity = identity;
    }
  }

  std::vector<Hue> hues_;
  std::vector<NoiseEstimator> noise_;
  DetectorRegion region_;
  cv::Mat ycrcb_, map_;
};

}  // namespace

std::unique_ptr<MarkerDetector> MakeReflectiveDetector(Polarity polarity, const DetectorRegion& region) {
  return std::make_unique<ReflectiveDetector>(polarity, region);
}

std::unique_ptr<MarkerDetector> MakeColorDetector(const std::vector<std::string>& colors,
                                                  const DetectorRegion& region) {
  if (colors.empty()) throw UsageError("--detector color needs at least one --color \"#RRGGBB\"");
  return std::make_unique<ColorDetector>(colors, region);
}

}  // namespace lake::tracking
