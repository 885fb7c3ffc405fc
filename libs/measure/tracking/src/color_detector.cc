// Coloured markers. They are found by their hue in the decoder's own chroma and measured in the luma, which has four
// times the pixels, or, where they are as bright as what is behind them, in the chroma.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "blob_finder.h"
#include "chroma_planes.h"
#include "detector_kinds.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"

namespace lake::tracking {
namespace {

using Eigen::Vector2d;

cv::Rect ChromaBox(const Vector2d& center_px, double reach_px, const cv::Size& size) {
  const Vector2d low = ChromaFromPx(center_px - Vector2d::Constant(reach_px)),
                 high = ChromaFromPx(center_px + Vector2d::Constant(reach_px));
  return cv::Rect(cv::Point(static_cast<int>(std::floor(low.x())), static_cast<int>(std::floor(low.y()))),
                  cv::Point(static_cast<int>(std::ceil(high.x())) + 1, static_cast<int>(std::ceil(high.y())) + 1)) &
         cv::Rect({}, size);
}

// Where the file says nothing of it, writers put chroma in the middle of two columns or on the left one: half a pixel.
// It is found by the blobs that both luma and chroma show.
class ChromaSite {
 public:
  void Add(const Vector2d& luma_minus_chroma) {
    constexpr double kMost = 1.5;
    if (luma_minus_chroma.norm() > kMost) return;
    sum_ += luma_minus_chroma;
    ++count_;
  }

  Vector2d Shift() const {
    constexpr int kEnough = 12;
    if (count_ < kEnough) return Vector2d::Zero();
    return 0.5 * (2 * sum_ / count_).array().round().cwiseMax(-1).cwiseMin(1);
  }

 private:
  int count_ = 0;
  Vector2d sum_ = Vector2d::Zero();
};

class ColorDetector : public MarkerDetector {
 public:
  ColorDetector(std::vector<MarkerHue> hues, const DetectorRegion& region)
      : hues_(std::move(hues)), region_(region), owner_(1 << 16, kNobody), strength_(1 << 16) {
    for (int cr = 0; cr < 256; ++cr)
      for (int cb = 0; cb < 256; ++cb) Classify(cr, cb);
  }
  bool NeedsColour() const override { return true; }
  bool KnowsIdentities() const override { return hues_.size() > 1; }

  std::vector<MarkerDetection> Detect(const video::VideoFrame& frame, std::span<const MarkerPrediction> predictions,
                                      Look look) override {
    luma_ = frame.luma;
    chroma_ = ChromaPlanes::Of(frame.preview);
    if (look != Look::kNearAgain) LearnNoise();
    found_.clear();
    const cv::Rect region = region_.Of(luma_);
    for (const MarkerPrediction& prediction : predictions)
      if (prediction.identity) {
        const double reach = prediction.gate_px + 2 * prediction.appearance.RadiusPx() + kMarginPx;
        FindSpots(ChromaBox(prediction.position, reach, chroma_.Size()), *prediction.identity);
      }
    if (look == Look::kEverywhere) {
      const cv::Rect all(region.x / 2, region.y / 2, region.width / 2, region.height / 2);
      for (std::size_t hue = 0; hue < hues_.size(); ++hue) FindSpots(all, static_cast<int>(hue));
    }
    std::erase_if(found_, [&](const MarkerDetection& spot) {
      return !region.contains({static_cast<int>(spot.position.x()), static_cast<int>(spot.position.y())});
    });
    return found_;
  }

 private:
  static constexpr std::uint8_t kNobody = 255;
  static constexpr double kMarginPx = 8;

  // Which hue's a sample of the chroma is, if any's, and how strongly: its chroma along that hue, the nearest one, less
  // what is across it.
  void Classify(int cr, int cb) {
    const cv::Vec2d chroma(cr - ChromaPlanes::kNone, cb - ChromaPlanes::kNone);
    const auto nearest = std::max_element(hues_.begin(), hues_.end(), [&](const MarkerHue& a, const MarkerHue& b) {
      return chroma.dot(a.direction) < chroma.dot(b.direction);
    });
    const cv::Vec2d& direction = nearest->direction;
    const double along = chroma.dot(direction), across = std::abs(chroma[1] * direction[0] - chroma[0] * direction[1]);
    const auto at = static_cast<std::size_t>(cr << 8 | cb);
    strength_[at] = cv::saturate_cast<uchar>(nearest->gain * (along - nearest->across * across));
    if (strength_[at] > 0) owner_[at] = static_cast<std::uint8_t>(nearest - hues_.begin());
  }

  void LearnNoise() {
    luma_noise_.Add(luma_);
    chroma_noise_.Add(chroma_.both);
  }

  // How strongly a box of the chroma has a hue.
  cv::Mat MapOf(const cv::Rect& box, int hue) const {
    cv::Mat map(box.size(), CV_8UC1);
    for (int y = 0; y < box.height; ++y) {
      const uchar *cr = chroma_.cr.ptr(box.y + y) + box.x, *cb = chroma_.cb.ptr(box.y + y) + box.x;
      uchar* out = map.ptr(y);
      for (int x = 0; x < box.width; ++x) {
        const auto at = static_cast<std::size_t>(cr[x] << 8 | cb[x]);
        out[x] = owner_[at] == hue ? strength_[at] : uchar{0};
      }
    }
    return map;
  }

  // Connected parts of the hue that are at least half as strong as their own strongest sample, the strongest first. A
  // brighter lamp elsewhere hides nothing; a coloured wall behind a marker falls below half of it.
  void FindSpots(const cv::Rect& box, int hue) {
    constexpr double kMinStrength = 40;
    constexpr std::size_t kMaxSpots = 12;
    if (box.empty()) return;
    const cv::Mat map = MapOf(box, hue);
    std::vector<Spot> spots;
    for (const Spot& any : SpotsAbove(map, kMinStrength))
      for (Spot& strong : SpotsAbove(map(any.box), std::max(kMinStrength, 0.5 * any.peak))) {
        strong.box += any.box.tl();
        spots.push_back(strong);
      }
    std::sort(spots.begin(), spots.end(), [](const Spot& a, const Spot& b) { return a.peak > b.peak; });
    spots.resize(std::min(spots.size(), kMaxSpots));
    for (const Spot& spot : spots) Measure(map, box, spot, hue);
  }

  struct Spot {
    cv::Rect box;  // among the samples
    double peak;   // its greatest strength
  };

  static std::vector<Spot> SpotsAbove(const cv::Mat& map, double level) {
    constexpr int kMinArea = 3;
    cv::Mat labels, stats, centers;
    const int count = cv::connectedComponentsWithStats(map >= level, labels, stats, centers);
    std::vector<Spot> spots;
    for (int label = 1; label < count; ++label) {
      const int* s = stats.ptr<int>(label);
      if (s[cv::CC_STAT_AREA] < kMinArea) continue;
      Spot spot{{s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]}, 0};
      cv::minMaxLoc(map(spot.box), nullptr, &spot.peak);
      spots.push_back(spot);
    }
    return spots;
  }

  void Measure(const cv::Mat& map, const cv::Rect& map_box, const Spot& spot, int hue) {
    constexpr int kMargin = 2;
    const cv::Rect part = cv::Rect(spot.box.x - kMargin, spot.box.y - kMargin, spot.box.width + 2 * kMargin,
                                   spot.box.height + 2 * kMargin) &
                          cv::Rect({}, map.size());
    MarkerDetection detection = Centroid(map(part), part.tl() + map_box.tl());
    const auto is_known = [&](const MarkerDetection& other) {
      return other.identity == hue && (other.position - detection.position).norm() < detection.appearance.RadiusPx();
    };
    if (std::any_of(found_.begin(), found_.end(), is_known)) return;
    const auto in_luma = FitInLuma(detection.appearance), in_chroma = FitInChroma(detection.appearance, hue);
    if (in_luma && in_chroma) site_.Add(in_luma->position - in_chroma->position);
    if (in_chroma) {
      detection = *in_chroma;
      detection.position += site_.Shift();
    }
    if (in_luma && (!in_chroma || in_luma->sigma_px < in_chroma->sigma_px)) detection = *in_luma;
    detection.appearance.amplitude = spot.peak;  // alike in luma and chroma
    detection.identity = hue;
    found_.push_back(detection);
  }

  // Of a spot that no disc describes: lamps are long, streaked, and too bright in the middle to have a colour, so they
  // are filled from their rims.
  MarkerDetection Centroid(const cv::Mat& map, const cv::Point& corner) const {
    constexpr int kCore = 5;
    static const cv::Mat kDisc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {kCore, kCore});
    cv::Mat filled;
    cv::morphologyEx(map, filled, cv::MORPH_CLOSE, kDisc);
    const cv::Moments moments = cv::moments(filled);
    double peak = 0;
    cv::minMaxLoc(filled, nullptr, &peak);
    const Vector2d center(corner.x + moments.m10 / moments.m00, corner.y + moments.m01 / moments.m00);
    const double noise = 2 * std::sqrt(chroma_noise_.Estimate().Variance(ChromaPlanes::kNone));
    MarkerDetection detection;
    detection.position = PxFromChroma(center);
    // Of the centroid of independent samples: noise × the spot's extent over its light.
    detection.sigma_px =
        2 * noise *
        std::sqrt(0.5 * (moments.mu20 + moments.mu02) / moments.m00 * static_cast<double>(map.size().area())) /
        moments.m00;
    detection.appearance = DiscBlob(detection.position, 2 * std::sqrt(moments.m00 / peak / M_PI));
    detection.appearance.amplitude = peak;
    detection.quality = 1;
    return detection;
  }

  std::optional<MarkerDetection> FitInLuma(const Blob& spot) const {
    const double radius = spot.RadiusPx(), reach = 2 * radius + kMarginPx;
    const cv::Rect box = BoxRound(spot.center, reach) & cv::Rect({}, luma_.size());
    if (box.empty()) return std::nullopt;
    cv::Mat part = luma_(box);
    const Vector2d corner(box.x, box.y);
    const bool is_dark = Contrast(part, spot.center - corner, radius) < 0;
    cv::Mat inverted;
    if (is_dark) {
      cv::bitwise_not(part, inverted);
      part = inverted;
    }
    BlobFitOptions options;
    options.noise = luma_noise_.Estimate();
    if (!is_dark) options.saturation_level = luma_noise_.SaturationLevel();
    const Blob start = DiscBlob(spot.center - corner, radius);
    const auto fits = FitBlobs(part, std::span(&start, 1), options);
    if (!fits || !IsMarkerLike(fits->front())) return std::nullopt;
    MarkerDetection detection = MakeDetection(fits->front());
    detection.position += corner;
    detection.appearance.center += corner;
    constexpr double kMostSize = 1.7, kMostOff = 0.6;
    const double size = detection.appearance.RadiusPx() / radius;
    const bool is_spot =
        size < kMostSize && size > 1 / kMostSize && (detection.position - spot.center).norm() < kMostOff * radius + 0.5;
    return is_spot ? std::optional(detection) : std::nullopt;
  }

  static cv::Rect BoxRound(const Vector2d& center, double reach) {
    return cv::Rect(cv::Point(static_cast<int>(center.x() - reach), static_cast<int>(center.y() - reach)),
                    cv::Point(static_cast<int>(center.x() + reach) + 1, static_cast<int>(center.y() + reach) + 1));
  }

  // Mean level inside a disc less the median level of a ring round it.
  static double Contrast(const cv::Mat& grey, const Vector2d& center, double radius) {
    std::vector<double> inside, around;
    for (int y = 0; y < grey.rows; ++y)
      for (int x = 0; x < grey.cols; ++x) {
        const double distance = (Vector2d(x, y) - center).norm();
        if (distance < 0.7 * radius + 0.5) inside.push_back(grey.at<uchar>(y, x));
        if (distance > 1.4 * radius + 1.5) around.push_back(grey.at<uchar>(y, x));
      }
    return Median(std::move(inside)) - Median(std::move(around));
  }

  // The chroma along the hue, which is linear in the light, so that a disc's edge looks as its model does.
  std::optional<MarkerDetection> FitInChroma(const Blob& spot, int hue) const {
    const Vector2d center = ChromaFromPx(spot.center);
    const cv::Rect box = BoxRound(center, spot.RadiusPx() + kMarginPx) & cv::Rect({}, chroma_.Size());
    const MarkerHue& color = hues_[static_cast<std::size_t>(hue)];
    constexpr double kBase = 64;
    cv::Mat part(box.size(), CV_8UC1);
    for (int y = 0; y < box.height; ++y)
      for (int x = 0; x < box.width; ++x)
        part.at<uchar>(y, x) =
            cv::saturate_cast<uchar>(kBase + kFitGain * chroma_.At(box.y + y, box.x + x).dot(color.direction));
    const Vector2d corner(box.x, box.y);
    BlobFitOptions options;
    options.noise.read_variance = kFitGain * kFitGain * chroma_noise_.Estimate().Variance(ChromaPlanes::kNone);
    const Blob start = DiscBlob(center - corner, 0.5 * spot.RadiusPx());
    const auto fits = FitBlobs(part, std::span(&start, 1), options);
    if (!fits || !IsMarkerLike(fits->front())) return std::nullopt;
    MarkerDetection detection = MakeDetection(fits->front());
    detection.position = PxFromChroma(detection.position + corner);
    detection.sigma_px *= 2;
    detection.appearance.center = detection.position;
    detection.appearance.unit_circle_from_px *= 0.5;
    detection.appearance.edge_px *= 2;
    return detection;
  }

  static constexpr double kFitGain = 1.5;  // 64 + 1.5 × 127 are 255

  std::vector<MarkerHue> hues_;
  DetectorRegion region_;
  std::vector<std::uint8_t> owner_;  // by Cr and Cb: whose they are …
  std::vector<uchar> strength_;      // … and how strongly
  NoiseEstimator luma_noise_, chroma_noise_;
  ChromaSite site_;
  cv::Mat luma_;
  ChromaPlanes chroma_;
  std::vector<MarkerDetection> found_;
};

MarkerHue FindHue(const std::filesystem::path& video, const MarkerColor& color, bool bt709,
                  const video::VideoReaderOptions& options) {
  if (color.bgr) return HueOfColor(color, bt709);
  video::VideoReaderOptions one = WithChroma(options);
  one.first = one.last.emplace(color.frame);
  one.start_s = one.end_s = std::nullopt;
  video::VideoFrame frame;
  if (!video::VideoReader::Open(video, one)->Read(frame))
    throw Fail("--color {}: {} has no frame {}", color.text, video.string(), color.frame);
  return HueAt(frame, color);
}

// Throws Error where a place has none, or two hardly differ.
std::vector<MarkerHue> FindHues(const std::filesystem::path& video, const TrackOptions& options) {
  const bool bt709 = video::VideoReader::Open(video, options.reader)->Info().bt709;
  std::vector<MarkerHue> hues;
  for (const std::string& text : options.colors) {
    hues.push_back(FindHue(video, ParseMarkerColor(text), bt709, options.reader));
    constexpr double kAlike = 0.98;  // cosine of 11°
    for (std::size_t other = 0; other + 1 < hues.size(); ++other)
      if (hues[other].direction.dot(hues.back().direction) > kAlike)
        throw Fail("--color {} and {}: hardly differ in hue; give one colour for all markers", options.colors[other],
                   text);
  }
  return hues;
}

void CheckColors(const TrackOptions& options) {
  if (options.colors.empty())
    throw UsageError("--detector color needs at least one --color: \"#RRGGBB\", or @X,Y where a marker is");
  if (options.colors.size() > 1 && options.colors.size() != options.names.size())
    throw UsageError("--color: {} colours for {} markers; give one for all or one for each", options.colors.size(),
                     options.names.size());
}

}  // namespace

std::unique_ptr<MarkerDetector> MakeColorDetector(const std::vector<MarkerHue>& hues, const DetectorRegion& region) {
  return std::make_unique<ColorDetector>(hues, region);
}

DetectorKind ColorKind() {
  return {.name = "color",
          .prepare = [](const std::filesystem::path& video, const TrackOptions& options) -> DetectorMaker {
            return [hues = FindHues(video, options)](const DetectorRegion& region) {
              return MakeColorDetector(hues, region);
            };
          },
          .identities =
              [](const TrackOptions& options) {
                return options.colors.size() > 1 ? IdentitiesInOrder(options) : std::vector<int>();
              },
          .check = CheckColors,
          .click = DetectorKind::Click::kNear};
}

}  // namespace lake::tracking
