// Any patch: found by normalised cross-correlation, measured by least squares against the patch as it was cut.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "detector_kinds.h"
#include "lake/core/error.h"

namespace lake::tracking {
namespace {

constexpr double kFoundCorrelation = 0.75;  // the patch is there
constexpr double kRenewCorrelation = 0.90;  // below this the patch has changed enough to be cut anew
constexpr std::size_t kMaxSamples = 12;     // of one patch; the first is never forgotten

// A patch centred on its marker exactly, to a fraction of a pixel.
struct Sample {
  cv::Mat grey;                                              // CV_32F, square, odd size
  Eigen::Vector2d drift_variance = Eigen::Vector2d::Zero();  // of its centre, from the samples it was cut by
};

constexpr int kTaps = 6;  // of the interpolation

// Lanczos' kernel of three lobes for a place `fraction` px after the third of six pixels, its sum one.
cv::Mat InterpolationKernel(double fraction) {
  const auto sinc = [](double u) { return std::abs(u) < 1e-9 ? 1.0 : std::sin(M_PI * u) / (M_PI * u); };
  cv::Mat kernel(kTaps, 1, CV_32F);
  for (int i = 0; i < kTaps; ++i) {
    const double u = i - (kTaps / 2 - 1) - fraction;
    kernel.at<float>(i) = static_cast<float>(sinc(u) * sinc(u / 3));
  }
  return kernel / cv::sum(kernel)[0];
}

// The picture round a place between its pixels. (cv::remap knows places to 1/32 px only.)
cv::Mat Cut(const cv::Mat& picture, const Eigen::Vector2d& center, int half) {
  constexpr int kBefore = kTaps / 2 - 1;
  const int size = 2 * half + 1;
  const int left = static_cast<int>(std::floor(center.x())) - half - kBefore,
            top = static_cast<int>(std::floor(center.y())) - half - kBefore;
  cv::Mat window(size + kTaps - 1, size + kTaps - 1, CV_32F);
  for (int y = 0; y < window.rows; ++y)
    for (int x = 0; x < window.cols; ++x)
      window.at<float>(y, x) =
          picture.at<uchar>(std::clamp(top + y, 0, picture.rows - 1), std::clamp(left + x, 0, picture.cols - 1));
  cv::Mat patch;
  cv::sepFilter2D(window, patch, CV_32F, InterpolationKernel(center.x() - std::floor(center.x())),
                  InterpolationKernel(center.y() - std::floor(center.y())), {kBefore, kBefore});
  return patch(cv::Rect(kBefore, kBefore, size, size)).clone();
}

double Correlation(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat result;
  cv::matchTemplate(a, b, result, cv::TM_CCOEFF_NORMED);
  return result.at<float>(0);
}

struct Match {
  Eigen::Vector2d center;
  Eigen::Matrix2d covariance;
  double correlation = 0;
};

// Shift, gain and offset that make the picture the patch (Lucas & Kanade 1981), Gauss–Newton with the patch's own
// gradient.
std::optional<Match> Refine(const cv::Mat& picture, const Sample& sample, Eigen::Vector2d center) {
  const int half = sample.grey.rows / 2;
  cv::Mat dx, dy;
  cv::Sobel(sample.grey, dx, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(sample.grey, dy, CV_32F, 0, 1, 3, 1.0 / 8);
  constexpr int kMaxIterations = 20;
  constexpr double kConvergedPx = 1e-3;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const cv::Mat now = Cut(picture, center, half);
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    double square_sum = 0;
    const int count = (2 * half - 1) * (2 * half - 1);
    for (int y = 1; y < 2 * half; ++y)
      for (int x = 1; x < 2 * half; ++x) {
        const Eigen::Vector4d row(dx.at<float>(y, x), dy.at<float>(y, x), sample.grey.at<float>(y, x), 1);
        normal += row * row.transpose();
        right += row * now.at<float>(y, x);
        square_sum += std::pow(now.at<float>(y, x), 2);
      }
    const auto factor = normal.ldlt();
    const Eigen::Vector4d solution = factor.solve(right);
    const double gain = solution[2];
    if (!(gain > 0.2) || !(gain < 5)) return std::nullopt;
    const Eigen::Vector2d step = -solution.head<2>() / gain;  // the picture shows the patch shifted by this
    center += step;
    if (step.norm() > half) return std::nullopt;
    if (step.norm() > kConvergedPx) continue;
    const double variance = std::max(0.0, square_sum - solution.dot(right)) / (count - 4);
    const Eigen::Matrix4d inverse = factor.solve(Eigen::Matrix4d::Identity());
    return Match{center, inverse.topLeftCorner<2, 2>() * variance / (gain * gain),
                 Correlation(Cut(picture, center, half), sample.grey)};
  }
  return std::nullopt;
}

class TemplateDetector : public MarkerDetector {
 public:
  TemplateDetector(const std::vector<MarkerSeed>& seeds, const std::vector<cv::Mat>& pictures,
                   const DetectorRegion& region)
      : region_(region), seeds_(seeds) {
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      half_ = std::clamp(pictures[i].rows / 50, 8, 24);
      Sample sample{Cut(pictures[i], seeds[i].position, half_)};
      cv::Scalar mean, deviation;
      cv::meanStdDev(sample.grey, mean, deviation);
      constexpr double kMinDeviation = 3;  // grey levels
      if (deviation[0] < kMinDeviation)
        throw Fail("--seed {}={},{}@{}: the picture is even there, a patch of it cannot be found again", seeds[i].name,
                   seeds[i].position.x(), seeds[i].position.y(), seeds[i].frame);
      samples_.push_back({sample});
    }
  }

  bool KnowsIdentities() const override { return true; }

  std::vector<MarkerDetection> Detect(const video::VideoFrame& frame, std::span<const MarkerPrediction> predictions,
                                      Look look) override {
    std::vector<MarkerDetection> found;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const auto prediction = std::find_if(predictions.begin(), predictions.end(), [&](const MarkerPrediction& p) {
        return p.identity == static_cast<int>(i);
      });
      std::optional<Match> match;
      if (prediction != predictions.end())
        match = Find(frame.luma, samples_[i], Around(frame.luma, prediction->position, prediction->gate_px));
      if (!match && look == Look::kEverywhere) {
        const bool pointed_at = frame.index == seeds_[i].frame;
        match = Find(frame.luma, samples_[i],
                     pointed_at ? Around(frame.luma, seeds_[i].position, half_) : region_.Of(frame.luma));
      }
      if (!match || IsTaken(match->center, static_cast<int>(i), predictions, found)) continue;
      MarkerDetection detection;
      detection.position = match->center;
      detection.sigma_px = std::sqrt(0.5 * match->covariance.trace());
      detection.appearance = DiscBlob(match->center, half_);
      detection.appearance.amplitude = 1;
      detection.quality = 1 - match->correlation;
      detection.identity = static_cast<int>(i);
      found.push_back(detection);
    }
    return found;
  }

 private:
  // Patches may look alike: where another one is, or is expected, this one is not.
  bool IsTaken(const Eigen::Vector2d& place, int identity, std::span<const MarkerPrediction> predictions,
               const std::vector<MarkerDetection>& found) const {
    const auto is_other = [&](const auto& other) {
      return other.identity != identity && (other.position - place).norm() < 0.5 * half_;
    };
    return std::any_of(predictions.begin(), predictions.end(), is_other) ||
           std::any_of(found.begin(), found.end(), is_other);
  }

  cv::Rect Around(const cv::Mat& picture, const Eigen::Vector2d& center, double gate) const {
    const double reach = std::min(gate, 2.0 * half_) + half_ + 1;
    return cv::Rect(static_cast<int>(center.x() - reach), static_cast<int>(center.y() - reach),
                    static_cast<int>(2 * reach) + 2, static_cast<int>(2 * reach) + 2) &
           region_.Of(picture);
  }

  // The best of the patch's samples in a part of the picture; a new sample is cut when it has changed.
  std::optional<Match> Find(const cv::Mat& picture, std::vector<Sample>& samples, const cv::Rect& box) const {
    const int size = 2 * half_ + 1;
    if (box.width <= size || box.height <= size) return std::nullopt;
    cv::Mat part;
    picture(box).convertTo(part, CV_32F);
    std::optional<Match> best;
    for (const Sample& sample : samples) {
      cv::Mat score;
      cv::matchTemplate(part, sample.grey, score, cv::TM_CCOEFF_NORMED);
      double peak = 0;
      cv::Point place;
      cv::minMaxLoc(score, nullptr, &peak, nullptr, &place);
      if (peak < kFoundCorrelation) continue;
      auto match = Refine(picture, sample, Eigen::Vector2d(box.x + place.x + half_, box.y + place.y + half_));
      if (!match || match->correlation < kFoundCorrelation) continue;
      match->covariance += sample.drift_variance.asDiagonal();
      if (!best || match->correlation > best->correlation) best = match;
      if (best->correlation > kRenewCorrelation) break;  // earlier samples drift less: the first good one is taken
    }
    if (best && best->correlation < kRenewCorrelation) {
      if (samples.size() == kMaxSamples) samples.erase(samples.begin() + 1);
      samples.push_back({Cut(picture, best->center, half_), best->covariance.diagonal()});
    }
    return best;
  }

  DetectorRegion region_;
  std::vector<MarkerSeed> seeds_;
  int half_ = 12;
  std::vector<std::vector<Sample>> samples_;  // by identity
};

DetectorMaker PreparePatches(const std::filesystem::path& video, const TrackOptions& options) {
  std::vector<cv::Mat> pictures;
  for (const MarkerSeed& seed : options.seeds) pictures.push_back(video::ReadLuma(video, seed.frame, options.reader));
  return [seeds = options.seeds, pictures](const DetectorRegion& region) {
    return MakeTemplateDetector(seeds, pictures, region);
  };
}

// Of each name its seed's index.
std::vector<int> PatchOfNames(const TrackOptions& options) {
  std::vector<int> identities;
  for (const std::string& name : options.names)
    identities.push_back(
        static_cast<int>(std::ranges::find(options.seeds, name, &MarkerSeed::name) - options.seeds.begin()));
  return identities;
}

void CheckPatches(const TrackOptions& options) {
  if (options.seeds.size() != options.names.size())
    throw UsageError("--detector template needs a --seed for each marker: the patch is cut there");
  for (const MarkerSeed& seed : options.seeds)
    if (seed.candidate)
      throw UsageError("--seed {}=#{}: --detector template needs the place in px", seed.name, *seed.candidate);
}

}  // namespace

std::unique_ptr<MarkerDetector> MakeTemplateDetector(const std::vector<MarkerSeed>& seeds,
                                                     const std::vector<cv::Mat>& pictures,
                                                     const DetectorRegion& region) {
  return std::make_unique<TemplateDetector>(seeds, pictures, region);
}

DetectorKind TemplateKind() {
  return {.name = "template",
          .prepare = PreparePatches,
          .identities = PatchOfNames,
          .check = CheckPatches,
          .click = DetectorKind::Click::kNot};
}

}  // namespace lake::tracking
