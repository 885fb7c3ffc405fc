// The detector of reflective or dark markers: blobs in the luma.
#include <limits>
#include <opencv2/core.hpp>

#include "blob_finder.h"
#include "detector_kinds.h"

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

DetectorKind ReflectiveKind() {
  return {.name = "reflective",
          .prepare = [](const std::filesystem::path&, const TrackOptions& options) -> DetectorMaker {
            return [polarity = options.polarity](const DetectorRegion& region) {
              return MakeReflectiveDetector(polarity, region);
            };
          },
          .identities = [](const TrackOptions&) { return std::vector<int>(); },
          .check = [](const TrackOptions&) {},
          .click = DetectorKind::Click::kNear};
}

}  // namespace lake::tracking
