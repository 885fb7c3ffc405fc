// The detectors that see blobs: reflective markers in the luma, coloured ones in how near each pixel is to a colour.
#include <algorithm>
#include <charconv>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "blob_finder.h"
#include "lake/core/error.h"
#include "lake/tracking/marker_detector.h"

namespace lake {
namespace {

class ReflectiveDetector : public MarkerDetector {
 public:
  ReflectiveDetector(Polarity polarity, const DetectorRegion& region) : polarity_(polarity), finder_(region.crop) {}

  std::vector<MarkerDetection> Detect(const VideoFrame& frame, std::span<const MarkerPrediction> predictions,
                                      bool everywhere) override {
    if (polarity_ == Polarity::kBright) return finder_.Detect(frame.luma, predictions, everywhere);
    cv::bitwise_not(frame.luma, inverted_);
    return finder_.Detect(inverted_, predictions, everywhere);
  }

 private:
  Polarity polarity_;
  BlobFinder finder_;
  cv::Mat inverted_;
};

// A colour as hue and chroma: what stays when the light changes. In the (Cr, Cb) plane of a picture, the pixel's chroma along the
// colour's direction less what is across it, times the colour's own saturation: bright where the colour is, dark elsewhere.
class ColorMap {
 public:
  explicit ColorMap(const cv::Vec3b& bgr) {
    const cv::Vec3d ycc = ToYcc(bgr);
    direction_ = {ycc[1], ycc[2]};
    const double chroma = cv::norm(direction_);
    is_grey_ = chroma < kMinChroma;
    if (!is_grey_) direction_ /= chroma;
  }
  bool IsGrey() const { return is_grey_; }

  // `ycrcb` as OpenCV makes it: 8-bit Y, Cr, Cb with 128 for none.
  void Apply(const cv::Mat& ycrcb, cv::Mat& map) const {
    constexpr double kGain = 1.5;      // strong LED colours have a chroma of about 100
    constexpr double kAcross = 1.2;    // how much a wrong hue counts against a pixel
    map.create(ycrcb.size(), CV_8U);
    for (int y = 0; y < ycrcb.rows; ++y) {
      const auto* in = ycrcb.ptr<cv::Vec3b>(y);
      uchar* out = map.ptr(y);
      for (int x = 0; x < ycrcb.cols; ++x) {
        const double cr = in[x][1] - 128.0, cb = in[x][2] - 128.0;
        const double along = direction_[0] * cr + direction_[1] * cb, across = std::abs(direction_[0] * cb - direction_[1] * cr);
        out[x] = cv::saturate_cast<uchar>(kGain * (along - kAcross * across));
      }
    }
  }

 private:
  static constexpr double kMinChroma = 20;
  static cv::Vec3d ToYcc(const cv::Vec3b& bgr) {
    const cv::Mat pixel(1, 1, CV_8UC3, cv::Scalar(bgr[0], bgr[1], bgr[2]));
    cv::Mat converted;
    cv::cvtColor(pixel, converted, cv::COLOR_BGR2YCrCb);
    const cv::Vec3b value = converted.at<cv::Vec3b>(0);
    return {double(value[0]), value[1] - 128.0, value[2] - 128.0};
  }

  cv::Vec2d direction_;
  bool is_grey_ = false;
};

cv::Vec3b ParseColor(const std::string& text) {
  unsigned value = 0;
  const char* end = text.data() + text.size();
  if (text.size() != 7 || text[0] != '#' || std::from_chars(text.data() + 1, end, value, 16).ptr != end)
    throw UsageError(fmt::format("--color '{}': write a colour as \"#RRGGBB\"", text));
  return {static_cast<uchar>(value & 255), static_cast<uchar>(value >> 8 & 255), static_cast<uchar>(value >> 16)};
}

class ColorDetector : public MarkerDetector {
 public:
  ColorDetector(const std::vector<std::string>& colors, const DetectorRegion& region) {
    for (const std::string& color : colors) {
      maps_.emplace_back(ParseColor(color));
      if (maps_.back().IsGrey())
        throw UsageError(fmt::format("--color '{}' is a grey: use --detector reflective, with --polarity dark for black", color));
      finders_.emplace_back(region.crop);
    }
  }
  bool NeedsColour() const override { return true; }
  bool KnowsIdentities() const override { return maps_.size() > 1; }

  std::vector<MarkerDetection> Detect(const VideoFrame& frame, std::span<const MarkerPrediction> predictions,
                                      bool everywhere) override {
    cv::cvtColor(frame.bgr, ycrcb_, cv::COLOR_BGR2YCrCb);
    std::vector<MarkerDetection> all;
    for (std::size_t i = 0; i < maps_.size(); ++i) {
      maps_[i].Apply(ycrcb_, map_);
      std::vector<MarkerPrediction> own;
      std::copy_if(predictions.begin(), predictions.end(), std::back_inserter(own),
                   [&](const MarkerPrediction& p) { return p.identity == static_cast<int>(i); });
      for (MarkerDetection& detection : finders_[i].Detect(map_, own, everywhere)) {
        detection.identity = static_cast<int>(i);
        all.push_back(detection);
      }
    }
    return all;
  }

 private:
  std::vector<ColorMap> maps_;
  std::vector<BlobFinder> finders_;
  cv::Mat ycrcb_, map_;
};

}  // namespace

std::unique_ptr<MarkerDetector> MakeReflectiveDetector(Polarity polarity, const DetectorRegion& region) {
  return std::make_unique<ReflectiveDetector>(polarity, region);
}

std::unique_ptr<MarkerDetector> MakeColorDetector(const std::vector<std::string>& colors, const DetectorRegion& region) {
  if (colors.empty()) throw UsageError("--detector color needs at least one --color \"#RRGGBB\"");
  return std::make_unique<ColorDetector>(colors, region);
}

}  // namespace lake
