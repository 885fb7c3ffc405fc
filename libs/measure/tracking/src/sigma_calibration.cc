#include "lake/tracking/sigma_calibration.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/statistics.h"
#include "lake/dynamics/marker_path.h"
#include "leg_scale.h"
#include "local_path.h"

namespace lake::tracking {
namespace {

constexpr double kFastPx = 0.5;  // per usual frame

constexpr double kHalf_s = 0.067;  // half the window that a path is smooth in

// As long at any frame rate, but of enough samples.
std::size_t HalfWindow(double frame_s) {
  constexpr long kFewest = 4;
  return static_cast<std::size_t>(std::max(kFewest, std::lround(kHalf_s / frame_s)));
}

// Whether a window twice as wide is one in which a path is smooth, too: not at less than 50 Hz.
bool HasWideWindow(double frame_s) {
  constexpr double kWidest = 2.4;
  return 2 * static_cast<double>(HalfWindow(frame_s)) * frame_s <= kWidest * kHalf_s;
}

// The error over the scatter, where it cannot be measured (SlowFactor), by how large the scatter is. Blocks are shifted
// by quarters of a pixel, which leaves up to 0.07 px; more than that is what the encoder did not put right for want of
// bits, and that stays for some frames. Of rendered recordings (x264 medium and veryfast, x265, crf 17 to 40, 60 and
// 120 Hz) it was 1.0 at 0.04 and 0.055 px, 1.05 to 1.08 at 0.063, 1.2 at 0.08, 1.15 to 1.45 at 0.09 to 0.15.
double UsualSlowFactor(double scatter_px) {
  constexpr double kNone_px = 0.055, kRise_px = 0.12, kMost = 1.4;
  return std::clamp(1 + (scatter_px - kNone_px) / kRise_px, 1.0, kMost);
}

// What is frozen at rest over what moves: 0.5 to 0.8 where compression is weak; where it is strong, or errors last
// while the markers move, less is refined afterwards. Where the picture itself is left coarse, which makes the fits'
// own sigma large, what begins and ends slowly is left behind: 0.9 to 1.6 where the scatter is 4.2 times that and less
// (x264 veryfast at crf 33, medium at crf 40), 1.0 to 1.1 at 4.6, less above.
double ShareAtRest(double scatter_px, double slow_factor, double scatter_over_fit) {
  constexpr double kLeast = 0.65, kWhole_px = 0.075, kUsualOverFit = 4.6, kLeftBehind = 1.25;
  if (scatter_px >= kWhole_px) return std::clamp(kUsualOverFit / scatter_over_fit, 1.0, kLeftBehind);
  const double slow = 1 - 1 / (slow_factor * slow_factor);  // of the squares
  return std::max(std::clamp(scatter_px / kWhole_px, kLeast, 1.0), std::min(kLeast + 2 * (1 - kLeast) * slow, 1.0));
}

struct Scatter {
  std::vector<double> residuals;  // px, of both axes, scaled to the deviation of one sample
  std::vector<double> sigmas;     // px, of the fits

  void Add(const Eigen::Vector2d& residual, double sigma) {
    residuals.insert(residuals.end(), {residual.x(), residual.y()});
    sigmas.push_back(sigma);
  }
};

// What a marker's samples are compared by: the detected ones, in order.
struct Seen {
  const std::vector<motion::MarkerSample>& samples;
  const std::vector<double>& time_s;
  double frame_s;  // between them, usually: longer than the recording's own where a converter repeated frames
  std::vector<std::size_t> frames;

  double Time(std::size_t k) const { return time_s[frames[k]]; }
  const motion::MarkerSample& Sample(std::size_t k) const { return samples[frames[k]]; }
};

// The residual of the middle of a window of detected samples, scaled; nullopt if too many between them are missing.
std::optional<Eigen::Vector2d> Residual(const Seen& seen, std::size_t middle, std::size_t half) {
  constexpr int kDegree = 4;
  constexpr double kLongest = 2;  // of as many frames in a row
  if (middle < half || middle + half >= seen.frames.size()) return std::nullopt;
  const double span_s = seen.Time(middle + half) - seen.Time(middle - half);
  if (span_s > kLongest * 2 * static_cast<double>(half) * seen.frame_s) return std::nullopt;
  LocalPath path(kDegree, seen.Time(middle));
  for (std::size_t k = middle - half; k <= middle + half; ++k) path.Add(seen.Time(k), seen.Sample(k).position);
  const PathPoint smooth = path.Fit();
  // White noise of variance 1 leaves a residual of variance 1 − the sample's own weight.
  return (seen.Sample(middle).position - smooth.position) / std::sqrt(1 - smooth.own_weight);
}

bool IsFast(const Seen& seen, std::size_t k) {
  const std::size_t a = k > 0 ? k - 1 : k, b = std::min(k + 1, seen.frames.size() - 1);
  return a != b && (seen.Sample(b).position - seen.Sample(a).position).norm() >
                       kFastPx * (seen.Time(b) - seen.Time(a)) / seen.frame_s;
}

// The standard deviation of the residuals, those beyond four robust deviations left out.
double TrimmedDeviation(const std::vector<double>& residuals) {
  const double limit = 4 * RobustDeviation(residuals);
  std::vector<double> kept;
  for (const double residual : residuals)
    if (std::abs(residual) <= limit) kept.push_back(residual);
  return RootMeanSquare(kept);
}

constexpr std::size_t kEnough = 60;  // samples

// What compression adds to the scatter; nullopt where too few samples show it.
std::optional<SigmaCalibration> CompressionIn(const Scatter& scatter) {
  if (scatter.sigmas.size() < kEnough) return std::nullopt;
  SigmaCalibration found;
  found.fit_px = Median(scatter.sigmas);  // a few take in that something was displaced
  found.scatter_px = TrimmedDeviation(scatter.residuals);
  found.compression_px = std::sqrt(std::max(0.0, std::pow(found.scatter_px, 2) - std::pow(found.fit_px, 2)));
  return found;
}

void Append(const Scatter& more, Scatter& all) {
  all.residuals.insert(all.residuals.end(), more.residuals.begin(), more.residuals.end());
  all.sigmas.insert(all.sigmas.end(), more.sigmas.begin(), more.sigmas.end());
}

// What is known of a recording's markers, each by its samples about smooth paths.
struct Scatters {
  std::vector<Seen> markers;
  std::vector<Scatter> fast, slow;  // of each marker
  Scatter all_fast, all;            // of all markers
};

Scatters ScattersOf(const motion::MarkerRecording& recording) {
  Scatters found;
  for (const motion::MarkerTrack& marker : recording.markers) {
    Seen seen{marker.samples, recording.time_s, 0, {}};
    std::vector<double> times_s;
    for (std::size_t i = 0; i < marker.samples.size(); ++i)
      if (marker.samples[i].status == motion::SampleStatus::kDetected) {
        seen.frames.push_back(i);
        times_s.push_back(recording.time_s[i]);
      }
    seen.frame_s = MedianInterval(times_s.size() > 1 ? times_s : recording.time_s);
    found.markers.push_back(std::move(seen));
  }
  for (const Seen& seen : found.markers) {
    Scatter fast, slow;
    for (std::size_t k = 0; k < seen.frames.size(); ++k)
      if (const auto residual = Residual(seen, k, HalfWindow(seen.frame_s)))
        (IsFast(seen, k) ? fast : slow).Add(*residual, seen.Sample(k).sigma);
    Append(fast, found.all_fast);
    Append(fast, found.all);
    Append(slow, found.all);
    found.fast.push_back(std::move(fast));
    found.slow.push_back(std::move(slow));
  }
  return found;
}

// Whether markers that move at other times hold still at rest, so that what scatters while they move is the encoder's:
// who jitters does so at rest too. Of rendered legs they scatter 0.01 to 0.3 times as much there, and where that is
// most, less than the fits' own sigma; of a person's optical markers 0.5 to 1 times.
bool HoldStillAtRest(const Scatters& scatters, const SigmaCalibration& pooled) {
  constexpr double kStill = 0.3;
  Scatter at_rest, moving;
  for (std::size_t m = 0; m < scatters.markers.size(); ++m) {
    if (scatters.fast[m].sigmas.size() < kEnough) continue;
    Append(scatters.slow[m], at_rest);
    Append(scatters.fast[m], moving);
  }
  if (at_rest.sigmas.size() < kEnough) return false;
  return TrimmedDeviation(at_rest.residuals) < std::max(kStill * TrimmedDeviation(moving.residuals), pooled.fit_px);
}

// The error over the scatter. Errors that last for some frames are followed by a smooth path, in a wide window less
// than in a narrow one. Of errors of which each frame keeps a share (0.1 to 0.6), the error over the narrow window's
// scatter is the scatters' ratio to the power of 1.8 to 2.8; of rendered recordings (x264 ultrafast to medium, x265) it
// was the ratio's square within a fifth: 1.02 to 1.05 with little compression, 1.2 to 1.5 with much, 1.5 to 1.9 where
// motion is coded in whole pixels (ultrafast). A person's jitter is no error, and has such a ratio too.
// Frames of less than 50 Hz are so far apart that hardly any error lasts: 1.03 to 1.13 times the scatter at 24 and 30
// Hz.
std::optional<double> SlowFactor(const Scatters& scatters) {
  constexpr double kMost = 2;
  if (!HasWideWindow(scatters.markers.front().frame_s)) return 1;
  std::vector<double> narrow, wide;
  for (std::size_t m = 0; m < scatters.markers.size(); ++m) {
    const Seen& seen = scatters.markers[m];
    if (scatters.fast[m].sigmas.size() < kEnough) continue;
    const std::size_t half = HalfWindow(seen.frame_s);
    for (std::size_t k = 0; k < seen.frames.size(); ++k) {
      if (!IsFast(seen, k)) continue;
      const auto in_wide = Residual(seen, k, 2 * half), in_narrow = Residual(seen, k, half);
      if (!in_wide || !in_narrow) continue;
      wide.insert(wide.end(), {in_wide->x(), in_wide->y()});
      narrow.insert(narrow.end(), {in_narrow->x(), in_narrow->y()});
    }
  }
  if (narrow.size() < 2 * kEnough) return std::nullopt;
  return std::clamp(std::pow(TrimmedDeviation(wide) / TrimmedDeviation(narrow), 2), 1.0, kMost);
}

// Standard deviations beyond the fits' own sigmas, px: while a marker moves, and while it rests.
struct Displacement {
  double moving = 0, at_rest = 0;
};

// Where no person jitters. A marker of little contrast is displaced farther before the encoder finds it worth a
// correction. One that is slow stays displaced for some frames, and its smooth path goes along, so its own scatter may
// show too little.
std::vector<Displacement> OfWhatHoldsStill(const Scatters& scatters, const SigmaCalibration& pooled) {
  const std::optional<double> slow_factor = SlowFactor(scatters);
  const auto error_px = [&](double scatter_px) {
    return scatter_px * slow_factor.value_or(UsualSlowFactor(scatter_px));
  };
  std::vector<Displacement> found;
  for (const Scatter& fast : scatters.fast) {
    const double own_px = CompressionIn(fast).value_or(pooled).compression_px,
                 most_px = std::max(own_px, pooled.compression_px);
    found.push_back(
        {error_px(own_px),
         ShareAtRest(most_px, slow_factor.value_or(1), pooled.scatter_px / pooled.fit_px) * error_px(most_px)});
  }
  return found;
}

// While it moves: at rest the displacement is frozen and does not show.
std::vector<dynamics::PathSample> MovingPath(const Seen& seen) {
  std::vector<dynamics::PathSample> path;
  for (std::size_t k = 0; k < seen.frames.size(); ++k)
    if (IsFast(seen, k)) path.push_back({seen.Time(k), seen.Sample(k).position, seen.Sample(k).sigma});
  return path;
}

double FitsSigma(const Seen& seen) {
  std::vector<double> sigmas;
  for (std::size_t k = 0; k < seen.frames.size(); ++k) sigmas.push_back(seen.Sample(k).sigma);
  return Median(std::move(sigmas));
}

// The error of a person's markers over their fits' sigma, from what the motion's model leaves to the measurement,
// `scatter` times that sigma. The model tells errors apart from the person's motion, but not from the skin's tremor,
// which is as white, and it takes errors that last for some frames for motion: so the scatter has less than half of the
// say. Of the markers of 75 rendered recordings of people (x264, x265, MPEG-4; 24 to 120 Hz, 0.001 to 0.9 bits per
// pixel), moving or slow, the error was k scatter^0.43 (bits per pixel / 0.01)^−0.12 within a factor of 1.25 (1 SD;
// each recording by the others). The factors k here are a tenth larger than found, as errors that last do more to an
// angle than to a position. In MPEG-4, of 13 more recordings, the error was 0.79 of what H.264's k gives (within a
// factor of 1.2); H.264's stands for codecs that were not measured. Where each picture is coded by itself (Motion JPEG,
// seven recordings) the error was 1.3 times the fits' sigma, whatever the scatter.
double ErrorOverFit(const video::VideoInfo& video, double scatter) {
  constexpr double kOfScatter = 0.43, kOfBits = -0.12, kUsualBitsPerPixel = 0.01, kCodedByItself = 1.3;
  constexpr double kMostScatter = 10;  // 95 % of the markers had less; more is the person's
  if (video.is_lossless) return 1;
  if (video.coded_frame_by_frame) return kCodedByItself;
  const double k = video.codec == "hevc"    ? 2.9
                   : video.codec == "mpeg4" ? 1.8
                                            : 2.25,
               bits = video.bits_per_pixel.value_or(kUsualBitsPerPixel) / kUsualBitsPerPixel;
  return k * std::pow(std::min(scatter, kMostScatter), kOfScatter) * std::pow(bits, kOfBits);
}

// Of what compression adds to the error of a person's markers: what smoothing does not take away, in 84 rendered films
// of people 0.74 (0.4 where coding was strong, 0.85 where it was weak).
constexpr double kLasting = 0.7;

// What a person's markers err beyond the fits' sigmas, moving or slow: but for errors that last, no more than the
// marker's own path allows.
std::vector<Displacement> OfPeople(const Scatters& scatters, const video::VideoInfo& video, double unit_mm) {
  std::vector<std::vector<dynamics::PathSample>> paths;
  for (const Seen& seen : scatters.markers) paths.push_back(MovingPath(seen));
  const dynamics::LearntMotion pooled = dynamics::LearnMotion(paths, unit_mm);
  std::vector<Displacement> found;
  for (std::size_t m = 0; m < paths.size(); ++m) {
    const dynamics::LearntMotion own =
        paths[m].size() < kEnough ? pooled : dynamics::LearnMotion(std::span(&paths[m], 1), unit_mm);
    const double fit_px = FitsSigma(scatters.markers[m]),
                 error_px = ErrorOverFit(video, pooled.extra_sigma / fit_px) * fit_px,
                 most_px = own.extra_sigma_at_most,
                 beyond_px = std::min(std::sqrt(std::max(0.0, error_px * error_px - fit_px * fit_px)),
                                      most_px * UsualSlowFactor(most_px));
    found.push_back({.moving = beyond_px, .at_rest = beyond_px});
  }
  return found;
}

}  // namespace

double UsualErrorOverFit(const video::VideoInfo& video) {
  constexpr double kUsualScatter = 4.3;  // the median of H.264's
  return ErrorOverFit(video, kUsualScatter);
}

SigmaCalibration CalibrateSigmas(const video::VideoInfo& video, motion::MarkerRecording& recording) {
  const Scatters scatters = ScattersOf(recording);
  const bool is_moving = scatters.all_fast.sigmas.size() >= kEnough;
  const auto pooled = CompressionIn(is_moving ? scatters.all_fast : scatters.all);
  if (!pooled) return {};
  const bool hold_still = HoldStillAtRest(scatters, *pooled);
  const std::vector<Displacement> found =
      hold_still ? OfWhatHoldsStill(scatters, *pooled) : OfPeople(scatters, video, MillimetresPerPx(recording));
  std::vector<double> added, sigmas;
  for (std::size_t m = 0; m < scatters.markers.size(); ++m) {
    const Seen& seen = scatters.markers[m];
    for (std::size_t k = 0; k < seen.frames.size(); ++k) {
      double& sigma = recording.markers[m].samples[seen.frames[k]].sigma;
      sigma = std::hypot(sigma, IsFast(seen, k) ? found[m].moving : found[m].at_rest);
      if (!IsFast(seen, k) && is_moving) continue;
      added.push_back(found[m].moving);
      sigmas.push_back(sigma);
    }
  }
  SigmaCalibration calibration = *pooled;
  calibration.compression_px = RootMeanSquare(added);
  if (!hold_still) calibration.lasting_share = kLasting * std::pow(RootMeanSquare(added) / RootMeanSquare(sigmas), 2);
  return calibration;
}

}  // namespace lake::tracking
