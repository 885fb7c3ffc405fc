// From the solved curves to what the caller gets: tracks, trajectory, motion, events, reports.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "filter_loss.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/gait/butterworth.h"
#include "leg_curves.h"
#include "leg_space.h"
#include "sizes.h"

namespace lake::gait {
namespace {

constexpr double kCustomaryCutoffHz = 6;

// One marker through all stages; `shown` is its position in the plane as the filter gives it.
struct MarkerOutput {
  const Detections* detections;
  MarkerCurve curve;
  std::vector<motion::SampleStatus> status;
  std::vector<Eigen::Vector2d> shown;
  std::vector<double> shown_sigma;
  std::vector<double> shown_lateral;  // mm, normal to the plane, of trials in three dimensions
  // Where the filter moves the fit's own curve to: what it takes of the movement. Empty without one.
  std::vector<Eigen::Vector2d> filtered_curve;
};

bool IsOutlier(const Detections& d, const MarkerCurve& curve, std::size_t i, double deviations) {
  return d.seen[i] && (d.track->samples[i].position - curve.recorded[i]).norm() >
                          deviations * curve.scatter[i] * d.sigma[i] + d.jolt[i];
}

// Before a marker is first seen and after it is last seen nothing is known of it: it may not have been there. Where it
// is hidden, or something else was taken for it, it is known as well as the curve knows it.
std::vector<motion::SampleStatus> StatusOf(const Detections& d, const MarkerCurve& curve, double most_sigma,
                                           double outlier_deviations) {
  using motion::SampleStatus;
  const std::size_t n = d.seen.size();
  std::vector<char> fits(n);
  for (std::size_t i = 0; i < n; ++i) fits[i] = d.seen[i] && !IsOutlier(d, curve, i, outlier_deviations);
  const auto first = std::find(fits.begin(), fits.end(), 1) - fits.begin();
  const auto last = fits.rend() - std::find(fits.rbegin(), fits.rend(), 1) - 1;
  std::vector<SampleStatus> status(n, SampleStatus::kMissing);
  for (std::size_t i = 0; i < n; ++i) {
    const auto frame = static_cast<std::ptrdiff_t>(i);
    if (fits[i] || (frame >= first && frame <= last && curve.plane_sigma[i] <= most_sigma))
      status[i] = fits[i] ? SampleStatus::kDetected : SampleStatus::kFilled;
  }
  return status;
}

// Over every run of frames in which the marker is known.
void FilterPositions(MarkerOutput& output, const std::vector<double>& time_s, double cutoff_hz) {
  const std::size_t n = time_s.size();
  output.filtered_curve = output.curve.in_plane;
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    for (end = begin; end < n && output.status[end] != motion::SampleStatus::kMissing;) ++end;
    if (end - begin >= 3) {
      const std::vector<double> times(time_s.begin() + static_cast<std::ptrdiff_t>(begin),
                                      time_s.begin() + static_cast<std::ptrdiff_t>(end));
      const auto filter = [&](const auto& value_at) {
        std::vector<double> values;
        for (std::size_t i = begin; i < end; ++i) values.push_back(value_at(i));
        const std::vector<double> filtered = ZeroPhaseButterworthAtTimes(values, times, cutoff_hz);
        for (std::size_t i = begin; i < end; ++i) value_at(i) = filtered[i - begin];
      };
      for (auto* positions : {&output.shown, &output.filtered_curve})
        for (int axis = 0; axis < 2; ++axis) filter([&](std::size_t i) -> double& { return (*positions)[i][axis]; });
      if (!output.shown_lateral.empty()) filter([&](std::size_t i) -> double& { return output.shown_lateral[i]; });
    }
    if (end == begin) ++end;
  }
  const double rate_hz = static_cast<double>(n - 1) / (time_s.back() - time_s.front());
  const double gain = ButterworthNoiseGain(rate_hz, cutoff_hz);
  for (std::size_t i = 0; i < n; ++i)
    if (output.status[i] == motion::SampleStatus::kDetected) output.shown_sigma[i] *= gain;
}

MarkerOutput MakeOutput(const Detections& d, MarkerCurve curve, const std::vector<double>& time_s, double most_sigma,
                        const LegFitOptions& options) {
  MarkerOutput output{&d, std::move(curve), {}, {}, {}, {}, {}};
  output.status = StatusOf(d, output.curve, most_sigma, options.outlier_deviations);
  output.shown = output.curve.in_plane;
  output.shown_sigma = output.curve.plane_sigma;
  output.shown_lateral = output.curve.lateral;
  if (options.filter == LegFilter::kSpline) return output;
  for (std::size_t i = 0; i < d.seen.size(); ++i)
    if (d.seen[i]) {
      output.shown[i] = d.in_plane[i];
      output.shown_sigma[i] = d.plane_sigma[i];
    }
  for (std::size_t i = 0; i < output.shown_lateral.size(); ++i)
    if (d.seen[i]) output.shown_lateral[i] = d.lateral[i];
  if (options.filter == LegFilter::kButterworth)
    FilterPositions(output, time_s, options.cutoff_hz.value_or(kCustomaryCutoffHz));
  return output;
}

motion::MarkerTrack TrackOf(const MarkerOutput& output) {
  motion::MarkerTrack track{output.detections->name, output.detections->track->samples};
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    motion::MarkerSample& sample = track.samples[i];
    sample.status = output.status[i];
    if (sample.status == motion::SampleStatus::kDetected) sample.sigma = output.detections->sigma[i];
    if (sample.status == motion::SampleStatus::kFilled) {
      sample.position = output.curve.recorded[i];
      sample.sigma = output.curve.recorded_sigma[i];
    }
  }
  return track;
}

motion::MarkerTrack TrajectoryOf(const MarkerOutput& output) {
  motion::MarkerTrack track{output.detections->name, {}};
  for (std::size_t i = 0; i < output.status.size(); ++i) {
    double sigma = output.shown_sigma[i];
    if (!output.filtered_curve.empty())
      sigma = std::hypot(sigma, (output.filtered_curve[i] - output.curve.in_plane[i]).norm() / std::numbers::sqrt2);
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

LegPoints PointsAt(const std::vector<MarkerOutput>& leg, std::size_t frame, bool raw) {
  LegPoints points;
  const std::array<std::optional<Eigen::Vector2d>*, kLegMarkers> places = {&points.ankle, &points.knee, &points.hip,
                                                                           &points.waist};
  for (std::size_t m = 0; m < leg.size(); ++m) {
    if (raw && leg[m].detections->seen[frame]) *places[m] = leg[m].detections->in_plane[frame];
    if (!raw && leg[m].status[frame] != motion::SampleStatus::kMissing) *places[m] = leg[m].shown[frame];
  }
  return points;
}

// From the markers' own sigmas, where the fit's covariance does not apply.
double KneeSigmaDeg(const std::vector<MarkerOutput>& leg, const motion::LegSample& sample, std::size_t i) {
  const auto length = [&](LegMarker below, const Eigen::Vector2d& in_plane) {
    const auto &from = leg[below].shown_lateral, &to = leg[below + 1u].shown_lateral;
    return from.empty() ? in_plane.norm() : std::hypot(in_plane.norm(), to[i] - from[i]);
  };
  const double shank = length(kAnkle, sample.ak), thigh = length(kKnee, sample.kh);
  const double at_knee =
      1 / (shank * shank) + 1 / (thigh * thigh) + 2 * std::cos(RadiansFromDegrees(sample.knee_deg)) / (shank * thigh);
  const auto variance = [&](LegMarker m) { return leg[m].shown_sigma[i] * leg[m].shown_sigma[i]; };
  return DegreesFromRadians(
      std::sqrt(variance(kAnkle) / (shank * shank) + variance(kHip) / (thigh * thigh) + variance(kKnee) * at_knee));
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

motion::LegMotion MakeMotion(const motion::MarkerRecording& recording, const std::vector<MarkerOutput>& leg,
                             const LegCurves& curves, const LegModel& model, motion::Facing facing,
                             const LegFitOptions& options) {
  motion::LegMotion motion;
  motion.unit = PlaneUnit(model.view);
  motion.facing = facing;
  motion.frame = recording.frame;
  motion.time_s = recording.time_s;
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    motion::LegSample sample = MakeLegSample(PointsAt(leg, i, false), facing, options.up);
    const motion::LegSample raw = MakeLegSample(PointsAt(leg, i, true), facing, options.up);
    sample.knee_raw_deg = raw.knee_deg;
    if (!leg[kKnee].shown_lateral.empty()) {
      const Eigen::Vector3d& axis = curves.flexion_axis[i];
      sample.knee_deg = KneeInSpaceOf(leg, sample, axis, [&](const MarkerOutput& m) { return m.shown_lateral[i]; });
      sample.knee_raw_deg =
          KneeInSpaceOf(leg, raw, axis, [&](const MarkerOutput& m) { return m.detections->lateral[i]; });
    }
    if (std::isfinite(sample.knee_deg)) {
      sample.knee_sigma_deg =
          options.filter == LegFilter::kSpline ? curves.knee_sigma_deg[i] : KneeSigmaDeg(leg, sample, i);
      sample.knee_deg_s = curves.knee_deg_s[i];
    }
    motion.samples.push_back(sample);
  }
  if (options.filter != LegFilter::kSpline) SetSpeedByDifferences(motion);
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
                                  knee_deg([&](const MarkerOutput& m) { return m.curve.in_plane[i]; })
                            : motion::LegSample::kUnknown);
  }
  return taken_deg;
}

// RMS rates of a segment's length within kSkin_s of each frame.
std::vector<double> LengthRates(const LegCurves& curves, LegState length, const std::vector<double>& time_s) {
  constexpr double kSkin_s = 0.1;
  std::vector<double> rates;
  for (std::size_t i = 0, begin = 0, end = 0; i < time_s.size(); ++i) {
    while (time_s[begin] < time_s[i] - kSkin_s) ++begin;
    while (end < time_s.size() && time_s[end] <= time_s[i] + kSkin_s) ++end;
    double square = 0;
    for (std::size_t k = begin; k < end; ++k) square += std::pow(curves.rate[k][length], 2);
    rates.push_back(std::sqrt(square / static_cast<double>(end - begin)));
  }
  return rates;
}

// The same signals with what the skin makes of the speeds in their deviations: bones keep their lengths, so as fast as
// a segment's changes its markers slide, or it turns out of the plane, and across the segment as fast as along it.
StsSignals WithSkin(StsSignals signals, const LegCurves& curves) {
  const std::vector<double> shank = LengthRates(curves, kShankLength, signals.time_s),
                            thigh = LengthRates(curves, kThighLength, signals.time_s);
  const bool has_trunk = curves.markers == kLegMarkers;
  const std::vector<double> trunk =
      has_trunk ? LengthRates(curves, kTrunkLength, signals.time_s) : std::vector<double>();
  StsDeviations& sd = signals.sd;
  for (std::size_t i = 0; i < signals.time_s.size(); ++i) {
    const StateVector& state = curves.state[i];
    sd.hip_up_speed[i] = std::hypot(sd.hip_up_speed[i], shank[i], thigh[i]);
    sd.knee_deg_s[i] = std::hypot(sd.knee_deg_s[i], DegreesFromRadians(shank[i] / state[kShankLength]),
                                  DegreesFromRadians(thigh[i] / state[kThighLength]));
    if (has_trunk)
      sd.trunk_deg_s[i] = std::hypot(sd.trunk_deg_s[i], DegreesFromRadians(trunk[i] / state[kTrunkLength]));
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
    const StateVector& state = curves.state[i];
    signals.hip_height.push_back(value(known, curves.marker[kHip].in_plane[i].dot(up)));
    signals.hip_up_speed.push_back(value(known, curves.hip_speed_in_leg[i].y()));
    signals.hip_behind.push_back(value(known, -state[kShankLength] * std::sin(state[kShankAngle]) -
                                                  state[kThighLength] * std::sin(state[kThighAngle])));
    signals.knee_deg.push_back(value(known, DegreesFromRadians(state[kShankAngle] - state[kThighAngle])));
    signals.knee_deg_s.push_back(value(known, curves.knee_deg_s[i]));
    signals.trunk_deg.push_back(value(trunk, DegreesFromRadians(state[kTrunkAngle])));
    signals.trunk_deg_s.push_back(value(trunk, DegreesFromRadians(curves.rate[i][kTrunkAngle])));
    signals.shank_deg.push_back(value(known, DegreesFromRadians(state[kShankAngle])));
    signals.shank_deg_s.push_back(value(known, DegreesFromRadians(curves.rate[i][kShankAngle])));
    signals.hip_deg_s.push_back(
        value(trunk, DegreesFromRadians(curves.rate[i][kTrunkAngle] - curves.rate[i][kThighAngle])));
  }
  return signals;
}

SegmentReport ReportSegment(const char* name, const Detections& below, const Detections& above, const LegCurves& curves,
                            LegMarker lower, int state) {
  const bool lateral = !below.lateral.empty();
  const MarkerCurve &curve_below = curves.marker[lower], &curve_above = curves.marker[lower + 1u];
  std::vector<double> lengths, variances;
  std::vector<double> fitted;
  for (std::size_t i = 0; i < below.seen.size(); ++i) {
    if (!below.trusted[i] || !above.trusted[i]) continue;
    const double in_plane = (above.in_plane[i] - below.in_plane[i]).norm();
    lengths.push_back(lateral ? std::hypot(in_plane, above.lateral[i] - below.lateral[i]) : in_plane);
    variances.push_back(below.plane_sigma[i] * below.plane_sigma[i] + above.plane_sigma[i] * above.plane_sigma[i]);
    fitted.push_back(lateral ? std::hypot(curves.state[i][state], curve_above.lateral[i] - curve_below.lateral[i])
                             : curves.state[i][state]);
  }
  SegmentReport report;
  report.name = name;
  report.length = Mean(fitted);
  report.length_sigma = std::sqrt(Mean(variances) / static_cast<double>(lengths.size()));
  report.variation = std::sqrt(std::max(0.0, std::pow(StandardDeviation(lengths), 2) - Mean(variances)));
  return report;
}

MarkerReport ReportMarker(const MarkerOutput& output, const motion::MarkerRecording& recording, const LegView& view,
                          double outlier_deviations, std::vector<OutlierReport>& outliers) {
  const Detections& d = *output.detections;
  MarkerReport report;
  report.name = d.name;
  std::vector<double> squares, parallax, scatter;
  for (std::size_t i = 0; i < d.seen.size(); ++i) {
    report.detected += output.status[i] == motion::SampleStatus::kDetected;
    report.filled += output.status[i] == motion::SampleStatus::kFilled;
    report.missing += output.status[i] == motion::SampleStatus::kMissing;
    if (!d.seen[i]) continue;
    const double distance = (d.track->samples[i].position - output.curve.recorded[i]).norm(),
                 deviations = distance / (output.curve.scatter[i] * d.sigma[i]);
    scatter.push_back(output.curve.scatter[i]);
    if (distance > report.worst) {
      report.worst = distance;
      report.worst_frame = recording.frame[i];
    }
    if (IsOutlier(d, output.curve, i, outlier_deviations)) {
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
  report.noise_scale = RootMeanSquare(scatter);
  if (!parallax.empty()) report.parallax_per_depth = Median(parallax);
  return report;
}

// A marker seen too rarely for a curve: its detections as they are.
MarkerOutput Unsmoothed(const Detections& d) {
  MarkerOutput output{&d,
                      {d.in_plane, {}, d.plane_sigma, d.sigma, true, std::vector<double>(d.seen.size(), 1), {}, {}, {}},
                      {},
                      d.in_plane,
                      d.plane_sigma,
                      {},
                      {}};
  for (std::size_t i = 0; i < d.seen.size(); ++i) {
    output.curve.recorded.push_back(d.track->samples[i].position);
    output.status.push_back(d.seen[i] ? motion::SampleStatus::kDetected : motion::SampleStatus::kMissing);
  }
  return output;
}

// A marker that is not the leg's.
MarkerOutput MakeExtra(const motion::MarkerRecording& recording, const Detections& d, const LegView& view,
                       double most_sigma, const LegFitOptions& options, std::vector<std::string>& warnings) {
  if (std::cmp_greater_equal(std::ranges::count(d.trusted, 1), kLeastFrames)) {
    MarkerCurve curve = SmoothMarker(recording, d, view, options);
    if (!curve.settled) warnings.push_back(UnsettledWarning(fmt::format("marker '{}'", d.name)));
    return MakeOutput(d, std::move(curve), recording.time_s, most_sigma, options);
  }
  warnings.push_back(
      fmt::format("marker '{}' is seen in fewer than {} frames and left as it is", d.name, kLeastFrames));
  return Unsmoothed(d);
}

void AddMarkers(const motion::MarkerRecording& recording, const std::vector<MarkerOutput>& leg, const LegView& view,
                double most_sigma, double skin, const LegFitOptions& options, LegFitResult& result) {
  result.tracks = {recording.unit, recording.frame, recording.time_s, {}};
  result.trajectory = result.measured = {PlaneUnit(view), recording.frame, recording.time_s, {}};
  const auto add = [&](const MarkerOutput& output) {
    result.tracks.markers.push_back(TrackOf(output));
    result.trajectory.markers.push_back(TrajectoryOf(output));
    result.measured.markers.push_back(MeasuredOf(*output.detections));
    result.markers.push_back(ReportMarker(output, recording, view, options.outlier_deviations, result.outliers));
  };
  for (const motion::MarkerTrack& track : recording.markers) {
    const auto own = std::find_if(leg.begin(), leg.end(), [&](const auto& o) { return o.detections->track == &track; });
    if (own != leg.end()) {
      add(*own);
    } else {
      const Detections detections = CollectDetections(recording, track, view, skin);
      add(MakeExtra(recording, detections, view, most_sigma, options, result.warnings));
    }
  }
  std::stable_sort(result.outliers.begin(), result.outliers.end(),
                   [](const auto& a, const auto& b) { return a.frame < b.frame; });
}

double MedianLength(const LegCurves& curves, LegState length) {
  std::vector<double> lengths;
  for (const StateVector& state : curves.state) lengths.push_back(state[length]);
  return Median(std::move(lengths));
}

}  // namespace

void FillResult(const motion::MarkerRecording& recording, const std::array<Detections, kLegMarkers>& detections,
                const LegCurves& curves, const LegModel& model, motion::Facing facing, double skin,
                const LegFitOptions& options, LegFitResult& result) {
  const double shank = MedianLength(curves, kShankLength), thigh = MedianLength(curves, kThighLength);
  const double most_sigma = options.most_filled_sigma * shank;
  std::vector<MarkerOutput> leg;
  for (std::size_t m = 0; m < static_cast<std::size_t>(curves.markers); ++m)
    leg.push_back(MakeOutput(detections[m], curves.marker[m], recording.time_s, most_sigma, options));
  AddMarkers(recording, leg, model.view, most_sigma, skin, options, result);
  result.segments.push_back(ReportSegment("ak", detections[kAnkle], detections[kKnee], curves, kAnkle, kShankLength));
  result.segments.push_back(ReportSegment("kh", detections[kKnee], detections[kHip], curves, kKnee, kThighLength));
  if (curves.markers == kLegMarkers)
    result.segments.push_back(ReportSegment("hw", detections[kHip], detections[kWaist], curves, kHip, kTrunkLength));
  result.motion = MakeMotion(recording, leg, curves, model, facing, options);
  if (options.filter == LegFilter::kButterworth)
    AccountForFilterLoss(KneeTakenByFilter(leg, result.motion, options.up),
                         options.cutoff_hz.value_or(kCustomaryCutoffHz), result.motion);
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
        "rises without a seat, as from a squat, are left out ({}): before them the hip neither rests nor is "
        "so far behind the feet that a seat must carry it; if they are rises, give their events "
        "with --events",
        result.without_seat.size()));
  SetRepetitions(result.events, result.motion);
}

}  // namespace lake::gait
