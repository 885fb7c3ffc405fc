// The detector of reflective or dark markers: blobs in the luma.
#include <limits>
#include <opencv2/core.hpp>

#include "blob_finder.h"
#include "lake/tracking/marker_detector.h"

namespace lake::tracking {
namespace {

class ReflectiveDetector : public MarkerDetector {
 public:
  ReflectiveDetector(Polarity polarity, const DetectorRegion& region) : polarity_(polarity), finder_(region) {}

  std::vector<MarkerDetection> Detect(const video::VideoFrame& frame, std::span<const MarkerPrediction> predictions,
                                      Look look) override {
    if (polarity_ == Polarity::kBright) return finder_.Detect(frame.luma, predictions, look);
    cv::bitwise_not(frame.luma, inverted_);
    return finder_.Detect(inverted_, predictions, look);
  }

  std::optional<ImageFigures> Figures() const override {
    ImageFigures figures = finder_.Figures();
    if (polarity_ == Polarity::kDark) figures.saturation_level = std::numeric_limits<double>::infinity();
    return figures;
  }

 private:
  Polarity polarity_;
  BlobFinder finder_;
  cv::Mat inverted_;
};

}  // namespace

std::unique_ptr<MarkerDetector> MakeReflectiveDetector(Polarity polarity, const DetectorRegion& region) {
  return std::make_unique<ReflectiveDetector>(polarity, region);
}

}  // namespace lake::tracking
