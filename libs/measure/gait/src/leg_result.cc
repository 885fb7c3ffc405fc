// From the solved curves to what the caller gets: tracks, trajectory, motion, events, reports.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/gait/butterworth.h"
#include "lake/gait/field.h"
#include "lake/motion/leg_motion.h"
#include "leg_curves.h"
#include "leg_space.h"
#include "sizes.h"

namespace lake::gait {
namespace {

// Adds to the knee angle's standard deviations what a filter takes of the angle: by frame, that of the fit's curves
// after the filter less that before it (deg, NaN where not known). Throws Error for a cutoff that takes a considerable
// share of the angle's variance over time.
void AccountForFilterLoss(const std::vector<double>& taken_deg, double cutoff_hz, motion::LegMotion& motion) {
  // Real sit-to-stands lose this share of their variance at 0.6 to 0.8 Hz, and a millionth at 6 Hz.
  constexpr double kMostShare = 0.05;
  constexpr double kMovement_deg = 1;  // root mean square; less than that may be a still person's own jitter
  std::vector<double> taken, angles;
  for (std::size_t i = 0; i < taken_deg.size(); ++i) {
    if (!std::isfinite(taken_deg[i])) continue;
    taken.push_back(taken_deg[i]);
    angles.push_back(motion.samples[i].knee_deg - taken_deg[i]);
    motion.samples[i].knee_sigma_deg = std::hypot(motion.samples[i].knee_sigma_deg, taken_deg[i]);
  }
  const double rms_deg = RootMeanSquare(taken), share = std::pow(rms_deg / StandardDeviation(angles), 2);
  if (share > kMostShare && rms_deg > kMovement_deg)
    throw Fail(
        "leg fit: a cutoff of {} Hz takes {:.0f} % of the knee angle's variance, {:.1f} deg (RMS): that is the "
        "movement itself; give a higher --cutoff, or none",
        cutoff_hz, 100 * share, rms_deg);
}

constexpr double kCustomaryCutoffHz = 6;

// One marker through all stages; `shown` is its position in the plane as the filter gives it.
struct MarkerOutput {
  const Detections* detections = nullptr;
  std::shared_ptr<const MarkerCurve> curve;
  std::vector<motion::SampleStatus> status;
  std::vector<Eigen::Vector2d> shown;
  std::vector<double> shown_sigma;
  std::vector<double> shown_lateral;  // mm, normal to the plane, of trials in three dimensions
  // Where the filter moves the fit's own curve to: what it takes of the movement. Empty without one.
  std::vector<Eigen::Vector2d> filtered_curve;
};

// Before a marker is first seen and after it is last seen nothing is known of it: it may not have been there. Where it
// is hidden, or something else was taken for it, it is known as well as the curve knows it.
std::vector<motion::SampleStatus> StatusOf(const Detections& d, const MarkerCurve& curve, double most_sigma) {
  using motion::SampleStatus;
  const std::size_t n = d.seen.size();
  const std::vector<char>& fits = d.trusted;
  const auto first = std::find(fits.begin(), fits.end(), 1) - fits.begin();
  const auto last = fits.rend() - std::find(fits.rbegin(), fits.rend(), 1) - 1;
  std::vector<SampleStatus> status(n, SampleStatus::kMissing);
  for (std::size_t i = 0; i < n; ++i) {
    const auto frame = static_cast<std::ptrdiff_t>(i);
    const bool is_detected = fits[i] && !d.IsRebuilt(i);
    if (is_detected || (frame >= first && frame <= last && curve.plane_sigma[i] <= most_sigma))
      status[i] = is_detected ? SampleStatus::kDetected : SampleStatus::kFilled;
  }
  return status;
}

std::vector<Eigen::Vector2d> InPlaneOf(const MarkerCurve& curve) {
  std::vector<Eigen::Vector2d> in_plane;
  for (std::size_t i = 0; i < curve.point.size(); ++i) in_plane.push_back(curve.InPlane(i));
  return in_plane;
}

// The filter that the tables are to go through, and its cutoff.
struct TableFilter {
  LegFilter kind;
  double cutoff_hz;

  std::vector<double> Pass(const std::vector<double>& values, const std::vector<double>& time_s) const {
    return kind == LegFilter::kButterworth ? ZeroPhaseButterworthAtTimes(values, time_s, cutoff_hz)
                                           : dynamics::LowPass(time_s, values, cutoff_hz);
  }

  // Of the standard deviation of white noise: the root sum of squares of the response to an impulse.
  double NoiseGain(double rate_hz) const {
    const auto half = static_cast<std::size_t>(std::ceil(4 * rate_hz / cutoff_hz));
    std::vector<double> impulse(2 * half + 1, 0.0), times;
    impulse[half] = 1;
    for (std::size_t i = 0; i < impulse.size(); ++i) times.push_back(static_cast<double>(i) / rate_hz);
    double sum = 0;
    for (const double value : Pass(impulse, times)) sum += value * value;
    return std::sqrt(sum);
  }
};

bool IsFiltered(const LegFitOptions& options) {
  return options.filter == LegFilter::kButterworth || options.HasSplineCutoff();
}

TableFilter FilterOf(const LegFitOptions& options) {
  return {options.filter, options.cutoff_hz.value_or(kCustomaryCutoffHz)};
}

// Over every run of frames in which the marker is known.
void FilterPositions(MarkerOutput& output, const std::vector<double>& time_s, const TableFilter& table) {
  const std::size_t n = time_s.size();
  output.filtered_curve = InPlaneOf(*output.curve);
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    for (end = begin; end < n && output.status[end] != motion::SampleStatus::kMissing;) ++end;
    if (end - begin >= 3) {
      const std::vector<double> times(time_s.begin() + static_cast<std::ptrdiff_t>(begin),
                                      time_s.begin() + static_cast<std::ptrdiff_t>(end));
      const auto filter = [&](const auto& value_at) {
        std::vector<double> values;
        for (std::size_t i = begin; i < end; ++i) values.push_back(value_at(i));
        const std::vector<double> filtered = table.Pass(values, times);
        for (std::size_t i = begin; i < end; ++i) value_at(i) = filtered[i - begin];
      };
      for (auto* positions : {&output.shown, &output.filtered_curve})
        for (int axis = 0; axis < 2; ++axis) filter([&](std::size_t i) -> double& { return (*positions)[i][axis]; });
      if (!output.shown_lateral.empty()) filter([&](std::size_t i) -> double& { return output.shown_lateral[i]; });
    }
    if (end == begin) ++end;
  }
  const double rate_hz = static_cast<double>(n - 1) / (time_s.back() - time_s.front());
  const double gain = table.NoiseGain(rate_hz);
  for (std::size_t i = 0; i < n; ++i)
    if (output.status[i] == motion::SampleStatus::kDetected) output.shown_sigma[i] *= gain;
}

MarkerOutput MakeOutput(const Detections& d, std::shared_ptr<const MarkerCurve> curve,
                        const std::vector<double>& time_s, double most_sigma, const LegFitOptions& options) {
  MarkerOutput output{&d, std::move(curve), {}, {}, {}, {}, {}};
  output.status = StatusOf(d, *output.curve, most_sigma);
  output.shown = InPlaneOf(*output.curve);
  output.shown_sigma = output.curve->plane_sigma;
  if (!d.lateral.empty())
    for (const dynamics::PathPoint& point : output.curve->point) output.shown_lateral.push_back(point.position.z());
  if (!IsFiltered(options) && options.filter == LegFilter::kSpline) return output;
  for (std::size_t i = 0; i < d.seen.size(); ++i)
    if (d.seen[i]) {
      output.shown[i] = d.in_plane[i];
      output.shown_sigma[i] = d.plane_sigma[i];
    }
  for (std::size_t i = 0; i < output.shown_lateral.size(); ++i)
    if (d.seen[i]) output.shown_lateral[i] = d.lateral[i];
  if (IsFiltered(options)) FilterPositions(output, time_s, FilterOf(options));
  return output;
}

motion::MarkerTrack TrackOf(const MarkerOutput& output) {
  motion::MarkerTrack track{output.detections->name, output.detections->track->samples};
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    motion::MarkerSample& sample = track.samples[i];
    sample.status = output.status[i];
    if (sample.status == motion::SampleStatus::kDetected) sample.sigma = output.detections->sigma[i];
    if (sample.status == motion::SampleStatus::kFilled) {
      sample.position = output.curve->recorded[i];
      sample.sigma = output.curve->recorded_sigma[i];
    }
  }
  return track;
}

motion::MarkerTrack TrajectoryOf(const MarkerOutput& output) {
  motion::MarkerTrack track{output.detections->name, {}};
  for (std::size_t i = 0; i < output.status.size(); ++i) {
    double sigma = output.shown_sigma[i];
    if (!output.filtered_curve.empty())
      sigma = std::hypot(sigma, (output.filtered_curve[i] - output.curve->InPlane(i)).norm() / std::numbers::sqrt2);
    track.samples.push_back({output.shown[i], sigma, output.status[i]});
  }
  return track;
}

motion::MarkerTrack MeasuredOf(const Detections& d) {
  motion::MarkerTrack track{d.name, std::vector<motion::MarkerSample>(d.seen.size())};
  for (std::size_t i = 0; i < d.seen.size(); ++i)
    if (d.seen[i]) track.samples[i] = {d.in_plane[i], d.plane_sigma[i], motion::SampleStatus::kDetected};
  return track;
}

// As detected.
LegPoints RawPoints(const std::vector<MarkerOutput>& leg, std::size_t frame) {
  const auto place = [&](motion::LegMarker marker) -> std::optional<Eigen::Vector2d> {
    const Detections& d = *leg[marker].detections;
    return d.seen[frame] ? std::optional(d.in_plane[frame]) : std::nullopt;
  };
  return {place(kAnkle), place(kKnee), place(kHip), std::nullopt};
}

// Where a segment rests on the ground: the middle of the shortest interval that holds a fifth of its angles, and what
// scatters within it. Of a stride the foot is flat for a quarter (Perry & Burnfield 2010), of a rise all the time.
Measured RestOf(std::vector<double> angles_deg) {
  constexpr double kShare = 0.2;
  std::ranges::sort(angles_deg);
  const auto width = static_cast<std::size_t>(kShare * static_cast<double>(angles_deg.size()));
  std::size_t best = 0;
  for (std::size_t i = 0; i + width < angles_deg.size(); ++i)
    if (angles_deg[i + width] - angles_deg[i] < angles_deg[best + width] - angles_deg[best]) best = i;
  const double from_deg = angles_deg[best], to_deg = angles_deg[best + width];
  return {(from_deg + to_deg) / 2, (to_deg - from_deg) / std::sqrt(12)};
}

// From the horizontal to where the segment rests, and the joint above it.
void FromRest(const motion::Segment& segment, motion::LegMotion& motion, std::vector<std::string>& warnings) {
  std::vector<double> angles_deg;
  for (const motion::LegSample& sample : motion.samples)
    if (const double deg = sample.*segment.angle.deg; std::isfinite(deg)) angles_deg.push_back(deg);
  constexpr double kMost_deg = 90;
  const double middle_deg = Median(angles_deg);
  if (std::abs(middle_deg) > kMost_deg)
    warnings.push_back(fmt::format(
        "no {0}_deg and {1}_deg: '{2}' is behind '{3}' in most frames: exchange their names, or say where the subject "
        "faces",
        segment.angle.name, segment.joint.name, motion::kMarkerNames[segment.upper],
        motion::kMarkerNames[segment.lower]));
  const Measured rest = RestOf(std::move(angles_deg));
  motion.foot_rest_sd_deg = rest.sd;
  for (motion::LegSample& sample : motion.samples) {
    double &deg = sample.*segment.angle.deg, &sigma_deg = sample.*segment.angle.sigma_deg;
    deg = std::abs(middle_deg) > kMost_deg ? motion::LegSample::kUnknown : deg - rest.value;
    sigma_deg = std::isfinite(deg) ? std::hypot(sigma_deg, rest.sd) : motion::LegSample::kUnknown;
    sample.*segment.joint.deg = sample.*segment.above_deg + deg;
    sample.*segment.joint.sigma_deg = std::hypot(sample.*segment.above_sigma_deg, sigma_deg);
  }
}

// From the markers as they are shown. Each errs independently, and alike along both axes.
void SetSegments(const motion::MarkerRecording& trajectory, const LegFitOptions& options, motion::LegMotion& motion,
                 std::vector<std::string>& warnings) {
  for (const motion::Segment& segment : motion::kSegments) {
    const motion::MarkerTrack *lower = trajectory.Find(options.markers.Of(segment.lower)),
                              *upper = trajectory.Find(options.markers.Of(segment.upper));
    const auto is_known = [&](std::size_t i) { return lower->samples[i].IsKnown() && upper->samples[i].IsKnown(); };
    int known = 0;
    for (std::size_t i = 0; lower && upper && i < motion.samples.size(); ++i) known += is_known(i) ? 1 : 0;
    if (known < static_cast<int>(kLeastFrames)) continue;
    for (std::size_t i = 0; i < motion.samples.size(); ++i) {
      if (!is_known(i)) continue;
      const motion::MarkerSample &below = lower->samples[i], &above = upper->samples[i];
      const Eigen::Vector2d in_leg = LegFromPlane(above.position - below.position, motion.facing, options.up);
      SetSegment(segment, in_leg, motion.samples[i]);
      motion.samples[i].*segment.angle.sigma_deg =
          DegreesFromRadians(std::hypot(below.sigma, above.sigma) / in_leg.norm());
    }
    if (segment.Lies()) FromRest(segment, motion, warnings);
  }
}

// From the shown markers' own sigmas, where the fit's covariance does not apply.
double KneeSigmaDeg(const std::vector<MarkerOutput>& leg, const LegCurves& curves, std::size_t i) {
  const MarkerGradient knee = KneeGradient(curves, i);
  double variance = 0;
  for (std::size_t m = 0; m < leg.size(); ++m)
    variance += std::pow(leg[m].shown_sigma[i], 2) * knee.by_marker[m].squaredNorm();
  return DegreesFromRadians(std::sqrt(variance));
}

// The knee angle in space of a sample whose vectors in the plane are known.
double KneeInSpaceOf(const std::vector<MarkerOutput>& leg, const motion::LegSample& sample,
                     const Eigen::Vector3d& flexion_axis, const std::function<double(const MarkerOutput&)>& lateral) {
  if (!std::isfinite(sample.knee_deg)) return sample.knee_deg;
  const double ankle = lateral(leg[kAnkle]), knee = lateral(leg[kKnee]), hip = lateral(leg[kHip]);
  return KneeInSpaceDeg({sample.ak.x(), sample.ak.y(), knee - ankle}, {sample.kh.x(), sample.kh.y(), hip - knee},
                        flexion_axis);
}

void SetSpeedByDifferences(motion::LegMotion& motion) {
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1, after = std::min(i + 1, motion.samples.size() - 1);
    motion.samples[i].knee_deg_s = (motion.samples[after].knee_deg - motion.samples[before].knee_deg) /
                                   (motion.time_s[after] - motion.time_s[before]);
  }
}

motion::LegMotion MakeMotion(const motion::MarkerRecording& trajectory, const std::vector<MarkerOutput>& leg,
                             const LegCurves& curves, motion::Facing facing, const LegFitOptions& options,
                             std::vector<std::string>& warnings) {
  motion::LegMotion motion;
  motion.unit = trajectory.unit;
  motion.facing = facing;
  motion.frame = trajectory.frame;
  motion.time_s = trajectory.time_s;
  motion.samples.resize(trajectory.Frames());
  SetSegments(trajectory, options, motion, warnings);
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    motion::LegSample& sample = motion.samples[i];
    const motion::LegSample raw = MakeLegSample(RawPoints(leg, i), facing, options.up);
    if (std::isfinite(sample.shank_deg) && std::isfinite(sample.thigh_deg))
      sample.knee_deg = KneeAngleDeg(sample.ak, sample.kh);
    sample.knee_raw_deg = raw.knee_deg;
    if (!leg[kKnee].shown_lateral.empty()) {
      const Eigen::Vector3d& axis = curves.flexion_axis[i];
      sample.knee_deg = KneeInSpaceOf(leg, sample, axis, [&](const MarkerOutput& m) { return m.shown_lateral[i]; });
      sample.knee_raw_deg =
          KneeInSpaceOf(leg, raw, axis, [&](const MarkerOutput& m) { return m.detections->lateral[i]; });
    }
    if (std::isfinite(sample.knee_deg)) {
      sample.knee_sigma_deg = options.filter == LegFilter::kSpline && !IsFiltered(options)
                                  ? curves.knee_sigma_deg[i]
                                  : KneeSigmaDeg(leg, curves, i);
      sample.knee_deg_s = curves.knee_deg_s[i];
    }
  }
  if (options.filter != LegFilter::kSpline || IsFiltered(options)) SetSpeedByDifferences(motion);
  return motion;
}

// Of the fit's knee angle, by frame; NaN where the angle is not known.
std::vector<double> KneeTakenByFilter(const std::vector<MarkerOutput>& leg, const motion::LegMotion& motion,
                                      const Eigen::Vector2d& up) {
  std::vector<double> taken_deg;
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    const auto knee_deg = [&](const auto& position) {
      return MakeLegSample({position(leg[kAnkle]), position(leg[kKnee]), position(leg[kHip]), std::nullopt},
                           motion.facing, up)
          .knee_deg;
    };
    taken_deg.push_back(std::isfinite(motion.samples[i].knee_deg)
                            ? knee_deg([&](const MarkerOutput& m) { return m.filtered_curve[i]; }) -
                                  knee_deg([&](const MarkerOutput& m) { return m.curve->InPlane(i); })
                            : motion::LegSample::kUnknown);
  }
  return taken_deg;
}

// RMS rates of a segment's length within kSkin_s of each frame.
std::vector<double> LengthRates(const LegCurves& curves, LegSegmentIndex segment, const std::vector<double>& time_s) {
  constexpr double kSkin_s = 0.1;
  std::vector<double> rates;
  for (std::size_t i = 0, begin = 0, end = 0; i < time_s.size(); ++i) {
    while (time_s[begin] < time_s[i] - kSkin_s) ++begin;
    while (end < time_s.size() && time_s[end] <= time_s[i] + kSkin_s) ++end;
    double square = 0;
    for (std::size_t k = begin; k < end; ++k) square += std::pow(LengthGradient(curves, segment, k).Rate(curves, k), 2);
    rates.push_back(std::sqrt(square / static_cast<double>(end - begin)));
  }
  return rates;
}

// The same signals with what the skin makes of the speeds in their deviations: bones keep their lengths, so as fast as
// a segment's changes its markers slide, or it turns out of the plane, and across the segment as fast as along it.
StsSignals WithSkin(StsSignals signals, const LegCurves& curves) {
  const std::vector<double> shank = LengthRates(curves, kShank, signals.time_s),
                            thigh = LengthRates(curves, kThigh, signals.time_s),
                            trunk = curves.HasTrunk() ? LengthRates(curves, kTrunk, signals.time_s) : shank;
  StsDeviations& sd = signals.sd;
  for (std::size_t i = 0; i < signals.time_s.size(); ++i) {
    sd.hip_up_speed[i] = std::hypot(sd.hip_up_speed[i], shank[i], thigh[i]);
    sd.knee_deg_s[i] = std::hypot(sd.knee_deg_s[i], DegreesFromRadians(shank[i] / curves.Length(kShank, i)),
                                  DegreesFromRadians(thigh[i] / curves.Length(kThigh, i)));
    if (curves.HasTrunk())
      sd.trunk_deg_s[i] = std::hypot(sd.trunk_deg_s[i], DegreesFromRadians(trunk[i] / curves.Length(kTrunk, i)));
  }
  return signals;
}

// Events are read from the fit's own curves, whatever filter the tables get.
StsSignals MakeStsSignals(const motion::LegMotion& motion, const std::vector<MarkerOutput>& leg,
                          const LegCurves& curves, double leg_length, const Eigen::Vector2d& up) {
  StsSignals signals;
  signals.frame = motion.frame;
  signals.time_s = motion.time_s;
  signals.leg_length = leg_length;
  signals.sd = curves.sd;
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    const bool known = std::isfinite(motion.samples[i].knee_deg);
    const bool trunk = leg.size() == kLegMarkers && std::isfinite(motion.samples[i].trunk_deg);
    const auto value = [&](bool is_known, double v) { return is_known ? v : motion::LegSample::kUnknown; };
    const MarkerGradient shank = AngleGradient(curves, kShank, i), thigh = AngleGradient(curves, kThigh, i),
                         trunk_angle = curves.HasTrunk() ? AngleGradient(curves, kTrunk, i) : MarkerGradient();
    const auto speed_deg_s = [&](const MarkerGradient& angle) { return DegreesFromRadians(angle.Rate(curves, i)); };
    const double shank_deg = DegreesFromRadians(curves.AngleRad(kShank, i)),
                 thigh_deg = DegreesFromRadians(curves.AngleRad(kThigh, i));
    signals.hip_height.push_back(value(known, curves.marker[kHip].InPlane(i).dot(up)));
    signals.hip_up_speed.push_back(value(known, HipHeightGradient(curves).Rate(curves, i)));
    signals.hip_behind.push_back(value(known, -(curves.Vector(kShank, i) + curves.Vector(kThigh, i)).x()));
    signals.knee_deg.push_back(value(known, shank_deg - thigh_deg));
    signals.knee_deg_s.push_back(value(known, curves.knee_deg_s[i]));
    signals.trunk_deg.push_back(value(trunk, trunk ? DegreesFromRadians(curves.AngleRad(kTrunk, i)) : 0));
    signals.trunk_deg_s.push_back(value(trunk, speed_deg_s(trunk_angle)));
    signals.shank_deg.push_back(value(known, shank_deg));
    signals.shank_deg_s.push_back(value(known, speed_deg_s(shank)));
    signals.hip_deg_s.push_back(value(trunk, speed_deg_s(trunk_angle - thigh)));
  }
  return signals;
}

SegmentReport ReportSegment(LegSegmentIndex segment, const std::array<Detections, kLegMarkers>& leg,
                            const LegCurves& curves) {
  const motion::Segment& of = motion::kSegments[segment];
  const Detections &below = leg[of.lower], &above = leg[of.upper];
  std::vector<double> lengths, variances, fitted;
  for (std::size_t i = 0; i < below.seen.size(); ++i) {
    if (!below.trusted[i] || !above.trusted[i]) continue;
    const double in_plane = (above.in_plane[i] - below.in_plane[i]).norm();
    lengths.push_back(below.lateral.empty() ? in_plane : std::hypot(in_plane, above.lateral[i] - below.lateral[i]));
    variances.push_back(below.plane_sigma[i] * below.plane_sigma[i] + above.plane_sigma[i] * above.plane_sigma[i]);
    fitted.push_back(curves.Length(segment, i));
  }
  SegmentReport report;
  report.name = of.vector_name;
  report.length = Mean(fitted);
  report.length_sigma = std::sqrt(Mean(variances) / static_cast<double>(lengths.size()));
  report.variation = std::sqrt(std::max(0.0, std::pow(StandardDeviation(lengths), 2) - Mean(variances)));
  return report;
}

MarkerReport ReportMarker(const MarkerOutput& output, const motion::MarkerRecording& recording, const LegView& view,
                          std::vector<OutlierReport>& outliers) {
  const Detections& d = *output.detections;
  MarkerReport report;
  report.name = d.name;
  std::vector<double> squares, parallax, scatter;
  for (std::size_t i = 0; i < d.seen.size(); ++i) {
    report.detected += output.status[i] == motion::SampleStatus::kDetected;
    report.filled += output.status[i] == motion::SampleStatus::kFilled;
    report.missing += output.status[i] == motion::SampleStatus::kMissing;
    if (!d.seen[i]) continue;
    const double distance = (d.track->samples[i].position - output.curve->recorded[i]).norm(),
                 deviations = distance / (output.curve->scatter[i] * d.sigma[i]);
    scatter.push_back(output.curve->scatter[i]);
    if (distance > report.worst) {
      report.worst = distance;
      report.worst_frame = recording.frame[i];
    }
    if (!d.trusted[i]) {
      ++report.outliers;
      outliers.push_back(
          {.frame = recording.frame[i], .marker = d.name, .residual = distance, .deviations = deviations});
    } else {
      squares.push_back(distance * distance / 2);
    }
    if (view.camera_from_plane && !view.recorded_in_plane)
      parallax.push_back(
          (PlaneFromRecorded(view, d.track->samples[i].position, d.depth_mm + 1) - d.in_plane[i]).norm());
  }
  report.rms = std::sqrt(Mean(squares));
  report.noise_scale = std::max(1.0, RootMeanSquare(scatter));
  if (!parallax.empty()) report.parallax_per_depth = Median(parallax);
  return report;
}

// A marker seen too rarely for a curve: its detections as they are.
MarkerOutput Unsmoothed(const Detections& d) {
  MarkerCurve curve;
  curve.plane_sigma = d.plane_sigma;
  curve.recorded_sigma = d.sigma;
  curve.scatter.assign(d.seen.size(), 1);
  curve.point.resize(d.seen.size());
  MarkerOutput output;
  for (std::size_t i = 0; i < d.seen.size(); ++i) {
    curve.recorded.push_back(d.track->samples[i].position);
    output.status.push_back(d.seen[i] ? motion::SampleStatus::kDetected : motion::SampleStatus::kMissing);
  }
  output.detections = &d;
  output.curve = std::make_shared<const MarkerCurve>(std::move(curve));
  output.shown = d.in_plane;
  output.shown_sigma = d.plane_sigma;
  return output;
}

// A marker that is not the leg's.
MarkerOutput MakeExtra(const motion::MarkerRecording& recording, Detections& d, const LegView& view, double most_sigma,
                       double unit_mm, const LegFitOptions& options, std::vector<std::string>& warnings) {
  if (std::cmp_greater_equal(std::ranges::count(d.trusted, 1), kLeastFrames))
    return MakeOutput(d, std::make_shared<const MarkerCurve>(SmoothMarker(recording.time_s, view, options, unit_mm, d)),
                      recording.time_s, most_sigma, options);
  warnings.push_back(
      fmt::format("marker '{}' is seen in fewer than {} frames and left as it is", d.name, kLeastFrames));
  d.trusted = d.seen;
  return Unsmoothed(d);
}

void AddMarkers(const motion::MarkerRecording& recording, const std::vector<MarkerOutput>& leg, const LegView& view,
                double most_sigma, double skin, double unit_mm, const LegFitOptions& options, LegFitResult& result) {
  result.tracks = {recording.unit, recording.frame, recording.time_s, {}};
  result.trajectory = result.measured = {PlaneUnit(view), recording.frame, recording.time_s, {}};
  const auto add = [&](const MarkerOutput& output) {
    result.tracks.markers.push_back(TrackOf(output));
    result.trajectory.markers.push_back(TrajectoryOf(output));
    result.measured.markers.push_back(MeasuredOf(*output.detections));
    result.markers.push_back(ReportMarker(output, recording, view, result.outliers));
  };
  for (const motion::MarkerTrack& track : recording.markers) {
    const auto own = std::find_if(leg.begin(), leg.end(), [&](const auto& o) { return o.detections->track == &track; });
    if (own != leg.end()) {
      add(*own);
    } else {
      Detections detections = CollectDetections(recording, track, view, skin);
      add(MakeExtra(recording, detections, view, most_sigma, unit_mm, options, result.warnings));
    }
  }
  std::stable_sort(result.outliers.begin(), result.outliers.end(),
                   [](const auto& a, const auto& b) { return a.frame < b.frame; });
}

double MedianLength(const LegCurves& curves, LegSegmentIndex segment) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < curves.knee_deg_s.size(); ++i)
    lengths.push_back(curves.Vector(segment, i).head<2>().norm());
  return Median(std::move(lengths));
}

// Of the frames in which the knee was rebuilt, those in which that is certain enough to be given, and their deviation.
void TakeRebuilt(const MarkerOutput& knee, RebuiltKnee& rebuilt) {
  std::vector<double> sd_mm;
  for (std::size_t i = 0; i < rebuilt.frames.size(); ++i) {
    rebuilt.frames[i] = rebuilt.frames[i] && knee.status[i] == motion::SampleStatus::kFilled;
    if (rebuilt.frames[i]) sd_mm.push_back(knee.shown_sigma[i]);
  }
  if (!sd_mm.empty()) rebuilt.sd_mm = RootMeanSquare(sd_mm);
}

}  // namespace

void FillResult(const motion::MarkerRecording& recording, const std::array<Detections, kLegMarkers>& detections,
                const LegCurves& curves, const LegView& view, motion::Facing facing, double skin,
                const LegFitOptions& options, LegFitResult& result) {
  const double shank = MedianLength(curves, kShank), thigh = MedianLength(curves, kThigh);
  const double most_sigma = options.most_filled_sigma * shank;
  std::vector<MarkerOutput> leg;
  for (std::size_t m = 0; m < static_cast<std::size_t>(curves.markers); ++m)
    leg.push_back(MakeOutput(detections[m], {std::shared_ptr<void>(), &curves.marker[m]}, recording.time_s, most_sigma,
                             options));  // not owned
  AddMarkers(recording, leg, view, most_sigma, skin, UnitMm(view, shank), options, result);
  if (result.rebuilt_knee) TakeRebuilt(leg[kKnee], *result.rebuilt_knee);
  for (const LegSegmentIndex segment : {kShank, kThigh, kTrunk})
    if (segment != kTrunk || curves.HasTrunk()) result.segments.push_back(ReportSegment(segment, detections, curves));
  result.motion = MakeMotion(result.trajectory, leg, curves, facing, options, result.warnings);
  if (result.rebuilt_knee || !options.technical.empty())
    result.tracks.knee_rebuilt = result.motion.knee_rebuilt =
        result.rebuilt_knee ? result.rebuilt_knee->frames : std::vector<char>(recording.Frames(), 0);
  if (IsFiltered(options))
    AccountForFilterLoss(KneeTakenByFilter(leg, result.motion, options.up), FilterOf(options).cutoff_hz, result.motion);
  result.signals = MakeStsSignals(result.motion, leg, curves, shank + thigh, options.up);
  FoundStsEvents found = FindStsEvents(WithSkin(result.signals, curves));
  result.events = std::move(found.events);
  result.without_seat = std::move(found.without_seat);
  if (found.begins_during_rise)
    result.warnings.emplace_back("the recording begins after a seat was left: that rise has no onset and is left out");
  if (found.begins_during_lean)
    result.warnings.emplace_back(
        "the recording begins while the first rise is under way, without the rest before it: that rise has no onset "
        "and no percent");
  if (!result.without_seat.empty())
    result.warnings.push_back(fmt::format(
        "rises without a seat, as from a squat, are left out ({}): before them the hip neither rests nor is so far "
        "behind the feet that a seat must carry it; if they are rises, give their events with --events",
        result.without_seat.size()));
  SetRepetitions(result.events, result.motion);
}

}  // namespace lake::gait
