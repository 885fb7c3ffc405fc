#include "blob_finder.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>

#include "lake/core/statistics.h"

namespace lake::tracking {
namespace {

constexpr double kMaxRelativeResidual = 0.12;  // of anything that is taken for a marker
constexpr double kUnsure = 0.5;                // of the radius: a place that is known less well is no measurement
constexpr double kMatters = 0.1;               // of the radius: by less a streak's length changes the picture little
constexpr double kKnownShape = 0.04;           // relative standard deviation, of what makes a streak

// A patch that a fit touches must not be much larger than the blob, or the next blob comes in.
double Reach(const Blob& blob) {
  return blob.RadiusPx() + 2.5 * blob.edge_px + 0.5 * blob.blur_px.norm();
}

// Groups of predictions whose pictures touch; each group is fitted as one.
std::vector<std::vector<std::size_t>> TouchingGroups(const std::vector<Blob>& blobs) {
  std::vector<int> group(blobs.size());
  std::iota(group.begin(), group.end(), 0);
  for (std::size_t i = 0; i < blobs.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if ((blobs[i].center - blobs[j].center).norm() < Reach(blobs[i]) + Reach(blobs[j]) && group[i] != group[j])
        std::replace(group.begin(), group.end(), group[i], group[j]);
  std::vector<std::vector<std::size_t>> groups(blobs.size());
  for (std::size_t i = 0; i < blobs.size(); ++i) groups[static_cast<std::size_t>(group[i])].push_back(i);
  std::erase_if(groups, [](const auto& members) { return members.empty(); });
  return groups;
}

}  // namespace

bool IsMarkerLike(const BlobFit& fit) {
  constexpr double kMaxAspect = 2.0;
  const double radius = fit.blob.RadiusPx();
  return fit.blob.AspectRatio() < kMaxAspect && fit.relative_residual < kMaxRelativeResidual && radius >= 0.8 &&
         fit.blob.edge_px < std::max(1.5, 0.8 * radius) && fit.SigmaPx() < 0.25 * radius;
}

MarkerDetection MakeDetection(const BlobFit& fit) {
  MarkerDetection detection;
  detection.position = fit.blob.center;
  detection.sigma_px = fit.SigmaPx();
  detection.appearance = fit.blob;
  detection.background = fit.background;
  detection.quality = fit.relative_residual;
  return detection;
}

bool ShutterEstimator::Wants(const Eigen::Vector2d& velocity_px) const {
  constexpr double kFastPx = 3;  // per frame; slower streaks tell little
  return samples_ < kPlenty && velocity_px.norm() > kFastPx;
}

void ShutterEstimator::Add(const cv::Mat& grey, const Blob& blob, const Eigen::Vector2d& velocity_px,
                           const BlobFitOptions& options) {
  BlobFitOptions stiff = options;
  stiff.shape_freedom = 0.05;  // else the ellipse takes the streak's place
  std::array<double, kCandidates.size()> cost;
  for (std::size_t i = 0; i < kCandidates.size(); ++i) {
    Blob start = blob;
    start.blur_px = kCandidates[i] * velocity_px;
    const auto fit = FitBlobs(grey, std::span(&start, 1), stiff);
    if (!fit) return;
    cost[i] = std::log(fit->front().chi_square);
  }
  for (std::size_t i = 0; i < cost.size(); ++i) cost_[i] += cost[i];
  if (++samples_ < kEnough) return;
  // The vertex of the parabola through the best candidate and its neighbours, in the square of the fraction: a streak
  // changes the picture by the square of its length.
  const auto best = static_cast<std::size_t>(std::min_element(cost_.begin(), cost_.end()) - cost_.begin());
  fraction_ = kCandidates[best];
  if (best == 0 || best + 1 == kCandidates.size()) return;
  const auto square = [&](std::size_t i) { return kCandidates[i] * kCandidates[i]; };
  const auto slope = [&](std::size_t i) { return (cost_[i] - cost_[i - 1]) / (square(i) - square(i - 1)); };
  const double turns = (slope(best + 1) - slope(best)) / (0.5 * (square(best + 1) - square(best - 1)));
  fraction_ = std::sqrt(0.5 * (square(best - 1) + square(best)) - slope(best) / turns);
}

// How the noise grows with the level comes from the pictures; how strong it is, from the fits, if there are any:
// coding takes noise away where nothing moves.
void BlobFinder::LearnNoise(const cv::Mat& grey) {
  if (!noise_.Add(grey)) return;
  fit_options_.saturation_level = noise_.SaturationLevel();
  const double before = fit_options_.noise.Variance(level_);
  fit_options_.noise = noise_.Estimate();
  if (level_ > 0 && !noise_.IsBeginning())
    ScaleNoise(before / fit_options_.noise.Variance(level_));
  else
    chi_square_ = 1;
}

void BlobFinder::ScaleNoise(double factor) {
  fit_options_.noise.read_variance *= factor;
  fit_options_.noise.gain *= factor;
}

Blob BlobFinder::Start(const MarkerPrediction& prediction, const Eigen::Vector2d& place) const {
  Blob start = prediction.appearance;
  start.center = place;
  start.blur_px = shutter_.Fraction() * prediction.VelocityAt(place);
  return start;
}

// Standard deviation of the path of what is found there: by what is not known of the shutter, and of its speed.
double BlobFinder::StreakDeviation(const MarkerPrediction& prediction, const Eigen::Vector2d& place) const {
  const Eigen::Vector2d velocity_px = prediction.VelocityAt(place);
  const double shutter_sd = shutter_.IsKnown() ? 0.03 : 0.3,
               speed_sd = 0.5 * (velocity_px - prediction.velocity_px).norm() + 0.1 * velocity_px.norm();
  return std::hypot(shutter_sd * velocity_px.norm(), shutter_.Fraction() * speed_sd);
}

// Whether a fit is the marker that was followed, whole: a part of it, or it and something else, would be measured in a
// wrong place.
bool BlobFinder::LooksLike(const BlobFit& fit, const MarkerPrediction& prediction) const {
  const Blob& now = fit.blob;
  const Blob& before = prediction.appearance;
  if ((now.center - prediction.position).norm() > prediction.gate_px) return false;
  const double radius = before.RadiusPx();
  if (fit.SigmaPx() > kUnsure * radius) return false;
  // What an error of the assumed streak does to the apparent size.
  const double streak_error = (shutter_.IsKnown() ? 0.1 : 0.4) * prediction.velocity_px.norm();
  // Coding spreads a small streak's light, more in one frame than in the next, and loses none; what hides a part of a
  // marker takes its light, and what comes beside it adds some.
  constexpr double kSameLight = 0.1, kSpread = 2;
  const double brightness = now.amplitude / before.amplitude, light = brightness * std::pow(now.RadiusPx() / radius, 2);
  const double size_tolerance =
      (std::abs(light - 1) < kSameLight ? kSpread : 1) * (0.05 + 0.25 / radius * 0.5 + 0.35 * streak_error / radius);
  const double axis_change = (now.unit_circle_from_px - before.unit_circle_from_px).norm() * radius;
  if (axis_change > 1.5 * size_tolerance) return false;
  if (std::abs(now.RadiusPx() / radius - 1) > size_tolerance) return false;
  if (light < 0.6 || light > 1.6) return false;
  return fit.relative_residual < std::min(kMaxRelativeResidual, 2.5 * prediction.quality + 0.01);
}

void BlobFinder::FitTogether(const cv::Mat& grey, std::span<const MarkerPrediction> predictions,
                             const std::vector<std::size_t>& members, std::vector<std::optional<BlobFit>>& fits) const {
  BlobFitOptions options = fit_options_;
  options.shape_freedom = 0.05;
  std::vector<Blob> starts;
  starts.reserve(members.size());
  for (const std::size_t member : members) starts.push_back(Start(predictions[member], predictions[member].position));
  if (const auto joint = FitBlobs(grey, starts, options)) {
    for (std::size_t i = 0; i < members.size(); ++i)
      if (LooksLike((*joint)[i], predictions[members[i]])) fits[members[i]] = (*joint)[i];
  }
}

// A marker of known shape that moves evenly while the shutter is open: its path then is expected from where it is
// found, and fitted. While the shutter is unknown it may be as sharp as at rest: what leaves less is believed.
std::optional<BlobFit> BlobFinder::FitAt(const cv::Mat& grey, const Eigen::Vector2d& place,
                                         const MarkerPrediction& prediction) const {
  BlobFitOptions options = fit_options_;
  options.shape_freedom = 0.3;
  std::vector<Blob> starts = {Start(prediction, place)};
  const double radius = starts[0].RadiusPx(), streak_sd_px = StreakDeviation(prediction, place);
  if (streak_sd_px > kMatters * radius) {
    options.streak_freedom_px = streak_sd_px;
    options.shape_freedom = kKnownShape;
  }
  if (!shutter_.IsKnown() && starts[0].blur_px.norm() > radius) {
    starts.push_back(starts[0]);
    starts.back().blur_px.setZero();
  }
  std::optional<BlobFit> best;
  for (const Blob& start : starts) {
    const auto fit = FitBlobs(grey, std::span(&start, 1), options);
    if (!fit || !LooksLike(fit->front(), prediction)) continue;
    if (!best || fit->front().relative_residual < best->relative_residual) best = fit->front();
  }
  return best;
}

// Where a prediction's blob and its surroundings may be.
cv::Rect BlobFinder::BoxAround(const cv::Mat& grey, const MarkerPrediction& prediction) const {
  const double reach = prediction.gate_px + 4 * prediction.appearance.RadiusPx() + 8;
  return cv::Rect(static_cast<int>(prediction.position.x() - reach), static_cast<int>(prediction.position.y() - reach),
                  static_cast<int>(2 * reach), static_cast<int>(2 * reach)) &
         region_.Of(grey);
}

std::optional<BlobFit> BlobFinder::SearchAndFit(const cv::Mat& grey, const MarkerPrediction& prediction) const {
  const double radius = prediction.appearance.RadiusPx();
  const cv::Rect box = BoxAround(grey, prediction);
  if (box.empty()) return std::nullopt;
  BlobSearchOptions search;
  search.min_radius_px = 0.6 * radius;
  search.max_radius_px = 1.6 * radius;
  // A streak's light is spread over its length.
  const double fastest_px = prediction.velocity_px.norm() + prediction.velocity_by_place * prediction.gate_px,
               longest = shutter_.Fraction() * fastest_px / radius;
  search.min_contrast = 0.3 * prediction.appearance.amplitude / (1 + 0.5 * longest);
  search.streaks = longest > 1;
  search.max_count = 6;
  std::optional<BlobFit> nearest;
  for (const BlobCandidate& candidate : FindBlobs(grey, box, search)) {
    const std::optional<BlobFit> fit = FitAt(grey, candidate.position, prediction);
    if (!fit) continue;
    const auto distance = [&](const BlobFit& f) { return (f.blob.center - prediction.position).norm(); };
    if (!nearest || distance(*fit) < distance(*nearest)) nearest = fit;
  }
  return nearest;
}

void BlobFinder::LearnFromFits(const cv::Mat& grey, std::span<const MarkerPrediction> predictions,
                               const std::vector<std::optional<BlobFit>>& fits) {
  std::vector<double> chi_squares;
  const auto follow = [](double& mean, double value) { mean = mean == 0 ? value : 0.98 * mean + 0.02 * value; };
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (!fits[i]) continue;
    chi_squares.push_back(fits[i]->chi_square);
    // A running median, in steps of two per cent.
    chi_square_ *= fits[i]->chi_square > chi_square_ ? 1.02 : 1 / 1.02;
    follow(contrast_, fits[i]->blob.amplitude);
    follow(level_, fits[i]->background + 0.5 * fits[i]->blob.amplitude);
    const Eigen::Vector2d velocity_px = predictions[i].VelocityAt(fits[i]->blob.center);
    if (shutter_.Wants(velocity_px)) {
      Blob blob = predictions[i].appearance;
      blob.center = fits[i]->blob.center;
      shutter_.Add(grey, blob, velocity_px, fit_options_);
    }
  }
  if (chi_squares.empty()) {
    level_ = 0;
    return;
  }
  LearnNoiseFromFits(std::move(chi_squares));
}

// The noise as the fits see it, so that robust weights and sigmas mean what they say. Where the camera's gain leaps,
// most of them say so two frames in a row.
void BlobFinder::LearnNoiseFromFits(std::vector<double> chi_squares) {
  constexpr double kStep = 1.05, kLeap = 2;
  const bool can_tell = chi_squares.size() > 1;
  const double now = Median(std::move(chi_squares));
  misjudged_ = can_tell && (now > kLeap || now < 1 / kLeap) ? misjudged_ + 1 : 0;
  if (misjudged_ > 1) chi_square_ = now;
  if (chi_square_ < kStep && chi_square_ > 1 / kStep) return;
  ScaleNoise(chi_square_);
  chi_square_ = 1;
}

// The size of a candidate is a guess within a factor of two, and a fit can settle on a wrong size: several are tried,
// and the one that leaves least is believed.
std::optional<BlobFit> BlobFinder::FitNew(const cv::Mat& grey, const BlobCandidate& candidate) const {
  constexpr double kGoodResidual = 0.03;
  std::optional<BlobFit> best;
  for (const double factor : {1.0, 0.65, 1.6}) {
    const Blob start = DiscBlob(candidate.position, factor * candidate.radius_px);
    const auto fit = FitBlobs(grey, std::span(&start, 1), fit_options_);
    if (!fit || !IsMarkerLike(fit->front())) continue;
    if (!best || fit->front().relative_residual < best->relative_residual) best = fit->front();
    if (best->relative_residual < kGoodResidual) break;
  }
  return best;
}

bool BlobFinder::WasRefused(const BlobCandidate& candidate) const {
  return std::any_of(refusals_.begin(), refusals_.end(), [&](const Refusal& refusal) {
    return (refusal.candidate.position - candidate.position).norm() < 0.5 * candidate.radius_px &&
           std::abs(refusal.candidate.contrast - candidate.contrast) < 0.15 * candidate.contrast;
  });
}

void BlobFinder::FindNew(const cv::Mat& grey, const cv::Rect& box, std::span<const MarkerPrediction> predictions,
                         std::vector<MarkerDetection>& found) {
  constexpr int kRefusedFor = 30;  // searches of the whole picture
  if (box.empty()) return;
  BlobSearchOptions search;
  if (!predictions.empty()) {
    // Once markers are followed, only what is about as large as most of them is of interest.
    std::vector<double> radii;
    for (const auto& prediction : predictions) radii.push_back(prediction.appearance.RadiusPx());
    search.min_radius_px = std::max(search.min_radius_px, 0.55 * Quantile(radii, 0.25));
    search.max_radius_px = 1.8 * Quantile(radii, 0.75);
  }
  const double noise = std::sqrt(fit_options_.noise.Variance(128));
  search.min_contrast = std::max({search.min_contrast, 5 * noise, 0.15 * contrast_});
  const std::size_t known = found.size();
  for (const BlobCandidate& candidate : FindBlobs(grey, box, search)) {
    const auto touches = [&](const Eigen::Vector2d& place, double radius) {
      return (place - candidate.position).norm() < radius + candidate.radius_px;
    };
    const auto end = found.begin() + static_cast<std::ptrdiff_t>(known);
    if (std::any_of(found.begin(), end, [&](const auto& d) { return touches(d.position, d.appearance.RadiusPx()); }))
      continue;
    if (WasRefused(candidate)) continue;
    if (const auto fit = FitNew(grey, candidate))
      found.push_back(MakeDetection(*fit));
    else
      refusals_.push_back({candidate, kRefusedFor});
  }
}

std::vector<MarkerDetection> BlobFinder::Detect(const cv::Mat& grey, std::span<const MarkerPrediction> predictions,
                                                Look look) {
  if (look != Look::kNearAgain) LearnNoise(grey);
  std::vector<Blob> starts;
  for (const MarkerPrediction& prediction : predictions) starts.push_back(Start(prediction, prediction.position));
  std::vector<std::optional<BlobFit>> fits(predictions.size());
  for (const auto& members : TouchingGroups(starts)) {
    if (members.size() > 1 && members.size() <= kMaxJointBlobs) FitTogether(grey, predictions, members, fits);
    for (const std::size_t member : members)
      if (!fits[member]) fits[member] = FitAt(grey, predictions[member].position, predictions[member]);
  }
  for (std::size_t i = 0; i < predictions.size(); ++i)
    if (!fits[i]) fits[i] = SearchAndFit(grey, predictions[i]);
  if (look != Look::kNearAgain) LearnFromFits(grey, predictions, fits);

  std::vector<MarkerDetection> found;
  for (const auto& fit : fits) {
    if (!fit) continue;
    const MarkerDetection detection = MakeDetection(*fit);
    const auto twin = std::find_if(found.begin(), found.end(), [&](const MarkerDetection& other) {
      return (other.position - detection.position).norm() < 0.5 * detection.appearance.RadiusPx();
    });
    if (twin == found.end())
      found.push_back(detection);
    else if (detection.quality < twin->quality)
      *twin = detection;
  }
  for (std::size_t i = 0; i < predictions.size() && look == Look::kNear; ++i)
    if (!fits[i] && predictions[i].was_missed) FindNew(grey, BoxAround(grey, predictions[i]), predictions, found);
  if (look == Look::kEverywhere) {
    std::erase_if(refusals_, [](Refusal& refusal) { return --refusal.searches_left < 0; });
    FindNew(grey, region_.Of(grey), predictions, found);
  }
  return found;
}

}  // namespace lake::tracking
