#include "lake/compare/registration.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "sampling.h"

namespace lake::compare {
namespace {

using Eigen::Vector2d;

// Marker positions with NaN where missing, and their sigmas.
struct Path {
  std::vector<double> x, y, sigma;
};

Path TakeMarker(const TrialTables& trial, const std::string& name) {
  const motion::MarkerTrack* track = trial.trajectory.Find(name);
  if (!track) {
    std::string known;
    for (const motion::MarkerTrack& marker : trial.trajectory.markers)
      known += (known.empty() ? "" : ", ") + marker.name;
    throw Fail("{}: no marker '{}'; it has: {}; name the compared markers with --human-knee and --exo-knee, or --map",
               trial.name, name, known);
  }
  Path path;
  for (const motion::MarkerSample& sample : track->samples) {
    const bool known = sample.IsKnown() && sample.position.allFinite();
    path.x.push_back(known ? sample.position.x() : NAN);
    path.y.push_back(known ? sample.position.y() : NAN);
    path.sigma.push_back(known ? sample.sigma : NAN);
  }
  return path;
}

// leg_from_plane: the rotation, with a reflection where the subject faces left, that turns ankle-to-hip of the
// trajectory into that of the kinematics. It carries the facing and the vertical that the leg fit used.
Eigen::Matrix2d FindLegFromPlane(const TrialTables& trial, const Path& ankle, const Path& hip) {
  Eigen::Matrix2d moment = Eigen::Matrix2d::Zero();
  const std::size_t frames = trial.motion.samples.size();
  const auto in_leg = [&](std::size_t i) { return Vector2d(trial.motion.samples[i].ak + trial.motion.samples[i].kh); };
  const auto in_plane = [&](std::size_t i) { return Vector2d(hip.x[i] - ankle.x[i], hip.y[i] - ankle.y[i]); };
  const auto known = [&](std::size_t i) { return in_leg(i).allFinite() && in_plane(i).allFinite(); };
  for (std::size_t i = 0; i < frames; ++i)
    if (known(i)) moment += in_leg(i) * in_plane(i).transpose();
  const Vector2d turn(moment(0, 0) + moment(1, 1), moment(1, 0) - moment(0, 1));
  const Vector2d flip(moment(0, 0) - moment(1, 1), moment(1, 0) + moment(0, 1));
  Eigen::Matrix2d leg_from_plane;
  const Vector2d c = (flip.norm() > turn.norm() ? flip : turn).normalized();
  if (flip.norm() > turn.norm())
    leg_from_plane << c.x(), c.y(), c.y(), -c.x();
  else
    leg_from_plane << c.x(), -c.y(), c.y(), c.x();
  std::vector<double> misfit, length;
  for (std::size_t i = 0; i < frames; ++i)
    if (known(i)) {
      misfit.push_back((in_leg(i) - leg_from_plane * in_plane(i)).norm());
      length.push_back(in_plane(i).norm());
    }
  constexpr double kMostMisfit = 0.02;  // of the leg's length; filtering differently makes thousandths
  if (misfit.empty() || !(Median(misfit) < kMostMisfit * Median(length)))
    throw Fail(
        "{}: the leg's vectors (kinematics.csv) and the markers (trajectory.csv) do not belong together; track it "
        "again",
        trial.name);
  return leg_from_plane;
}

// The frames just before each onset in which the knee keeps its angle: the seated rest. The onset's own frame where
// there are none.
std::vector<std::size_t> SeatedFrames(const TrialTables& trial, const std::vector<StsInterval>& intervals) {
  constexpr double kSameDeg = 5;
  std::vector<std::size_t> frames;
  for (const StsInterval& interval : intervals) {
    std::size_t i = FrameAfter(trial.motion.time_s, interval.onset_s);
    const double knee_deg = trial.motion.samples[i].knee_deg;
    while (std::abs(trial.motion.samples[i].knee_deg - knee_deg) <= kSameDeg) {
      frames.push_back(i);
      if (i-- == 0) break;
    }
  }
  return frames;
}

Vector2d MedianPosition(const Path& path, const std::vector<std::size_t>& frames, const std::string& trial) {
  std::vector<double> x, y;
  for (const std::size_t i : frames)
    if (std::isfinite(path.x[i])) {
      x.push_back(path.x[i]);
      y.push_back(path.y[i]);
    }
  if (x.empty()) throw Fail("{}: the ankle is not seen before any rise: the leg frame has no origin", trial);
  return {Median(x), Median(y)};
}

class Registrar {
 public:
  Registrar(const TrialTables& trial, const RegistrationOptions& options)
      : trial_(trial),
        options_(options),
        ankle_(TakeMarker(trial, options.ankle)),
        knee_(TakeMarker(trial, options.knee)),
        hip_(TakeMarker(trial, options.hip)) {
    if (options.leg_knee != options.knee && trial.trajectory.Find(options.leg_knee))
      leg_knee_ = TakeMarker(trial, options.leg_knee);
  }

  RegisteredTrial Register() {
    leg_from_plane_ = FindLegFromPlane(trial_, ankle_, hip_);
    PutOnAxis(knee_);
    const std::vector<StsInterval> intervals = FindStsIntervals(trial_);
    RegisteredTrial registered;
    registered.movement = MovementIn(trial_);
    if (trial_.sight) registered.sight = {*trial_.sight, gait::DepthOf(*trial_.sight, options_.knee)};
    is_from_hip_ = registered.movement == gait::MovementKind::kWalking;
    if (!is_from_hip_) origin_ = MedianPosition(ankle_, SeatedFrames(trial_, intervals), trial_.name);
    for (const StsInterval& interval : intervals) {
      const std::string gap = FindGap(interval);
      if (gap.empty())
        registered.repetitions.push_back(Resample(interval));
      else
        registered.warnings.push_back(gap);
    }
    if (registered.repetitions.empty()) throw Fail("{}; no repetition is left to compare", registered.warnings.front());
    return registered;
  }

 private:
  // A marker that sits beside the joint's axis, on a part that turns with the shank.
  void PutOnAxis(Path& marker) const {
    for (std::size_t i = 0; i < marker.x.size(); ++i) {
      const Vector2d beside = AxesAlong(trial_.motion.samples[i].ak) * options_.marker_at_mm;
      const Vector2d in_plane = leg_from_plane_.transpose() * beside;
      marker.x[i] -= in_plane.x();
      marker.y[i] -= in_plane.y();
    }
  }

  // Empty, or why the repetition cannot be used.
  std::string FindGap(const StsInterval& interval) const {
    const std::pair<const std::string*, const Path*> markers[] = {
        {&options_.ankle, &ankle_}, {&options_.knee, &knee_}, {&options_.hip, &hip_}};
    for (const auto& [name, path] : markers) {
      const double gap_s = LongestGap(trial_.trajectory.time_s, path->x, interval.onset_s, interval.standing_s);
      if (gap_s <= options_.max_gap_s) continue;
      const std::string when =
          std::isfinite(gap_s) ? fmt::format("for {} s", SignificantText(gap_s, 2)) : "at the beginning or end";
      return fmt::format("{}: repetition {} is left out: marker '{}' is missing {} of it", trial_.name,
                         interval.repetition, *name, when);
    }
    return {};
  }

  bool ShowsLegKnee(const StsInterval& interval) const {
    return leg_knee_ && LongestGap(trial_.trajectory.time_s, leg_knee_->x, interval.onset_s, interval.standing_s) <=
                            options_.max_gap_s;
  }

  StsCurve Resample(const StsInterval& interval) const {
    StsCurve curve;
    curve.repetition = interval.repetition;
    curve.duration_s = interval.standing_s - interval.onset_s;
    curve.onset_sd_s = interval.onset_sd_s;
    curve.standing_sd_s = interval.standing_sd_s;
    const std::vector<double>& time_s = trial_.trajectory.time_s;
    if (interval.seat_off_s) curve.seat_off_s = *interval.seat_off_s - interval.onset_s;
    std::vector<double> knee_deg, shank_deg, trunk_deg;
    for (const motion::LegSample& sample : trial_.motion.samples) {
      knee_deg.push_back(sample.knee_deg);
      shank_deg.push_back(sample.shank_deg);
      trunk_deg.push_back(sample.trunk_deg);
    }
    const bool shows_trunk = LongestGap(time_s, trunk_deg, interval.onset_s, interval.standing_s) <= options_.max_gap_s;
    const bool shows_leg_knee = ShowsLegKnee(interval);
    for (int percent = 0; percent < kPercentSamples; ++percent) {
      const double t = interval.onset_s + curve.duration_s * percent / (kPercentSamples - 1);
      const auto place = [&](const Path& path) {
        return Vector2d(ValueAt(time_s, path.x, t), ValueAt(time_s, path.y, t));
      };
      const Vector2d origin = is_from_hip_ ? place(hip_) : origin_;
      const auto in_leg = [&](const Path& path) { return Vector2d(leg_from_plane_ * (place(path) - origin)); };
      curve.ankle.push_back(in_leg(ankle_));
      curve.knee.push_back(in_leg(knee_));
      curve.hip.push_back(in_leg(hip_));
      if (trial_.sight) curve.slope.emplace_back(leg_from_plane_ * trial_.sight->Slope(place(knee_)));
      if (shows_leg_knee) curve.leg_knee.push_back(in_leg(*leg_knee_));
      if (shows_leg_knee && !trial_.motion.knee_rebuilt.empty()) {
        const std::size_t frame = std::min(FrameAfter(time_s, t), time_s.size() - 1);
        curve.rebuilt_sd_mm.push_back(trial_.motion.knee_rebuilt[frame] ? leg_knee_->sigma[frame] : 0);
      }
      curve.knee_deg.push_back(ValueAt(time_s, knee_deg, t));
      curve.shank_deg.push_back(ValueAt(time_s, shank_deg, t));
      curve.trunk_deg.push_back(shows_trunk ? ValueAt(time_s, trunk_deg, t) : NAN);
      const double origin_sigma = is_from_hip_ ? LinearValueAt(time_s, hip_.sigma, t) : 0;
      curve.knee_sigma_mm.push_back(std::hypot(LinearValueAt(time_s, knee_.sigma, t), origin_sigma));
    }
    return curve;
  }

  const TrialTables& trial_;
  const RegistrationOptions& options_;
  Path ankle_, knee_, hip_;
  std::optional<Path> leg_knee_;
  Eigen::Matrix2d leg_from_plane_ = Eigen::Matrix2d::Identity();
  bool is_from_hip_ = false;  // who walks travels
  Vector2d origin_ = Vector2d::Zero();
};

template <typename T>
std::vector<T> MeanOf(const std::vector<StsCurve>& curves, std::vector<T> StsCurve::*member) {
  std::vector<T> mean = curves.front().*member;
  for (std::size_t c = 1; c < curves.size(); ++c)
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += (curves[c].*member)[i];
  for (T& value : mean) value /= static_cast<double>(curves.size());
  return mean;
}

}  // namespace

RegisteredTrial RegisterTrial(const TrialTables& trial, const RegistrationOptions& options) {
  if (trial.trajectory.unit != motion::LengthUnit::kMm || trial.motion.unit != motion::LengthUnit::kMm)
    throw Fail(
        "{}: its lengths are in px; a comparison needs mm: give it a scale: --camera with a plane, --scale or "
        "--plane-points",
        trial.name);
  if (trial.trajectory.time_s != trial.motion.time_s)
    throw Fail("{}: trajectory.csv has {} frames and kinematics.csv {}, or other times; track it again", trial.name,
               trial.trajectory.Frames(), trial.motion.samples.size());
  return Registrar(trial, options).Register();
}

StsCurve MeanCurve(const std::vector<StsCurve>& curves) {
  if (curves.size() == 1) return curves.front();
  StsCurve mean;
  mean.ankle = MeanOf(curves, &StsCurve::ankle);
  mean.knee = MeanOf(curves, &StsCurve::knee);
  mean.hip = MeanOf(curves, &StsCurve::hip);
  if (std::ranges::none_of(curves, [](const StsCurve& curve) { return curve.leg_knee.empty(); }))
    mean.leg_knee = MeanOf(curves, &StsCurve::leg_knee);
  // What is learnt wrong is wrong in all of them.
  if (std::ranges::none_of(curves, [](const StsCurve& curve) { return curve.rebuilt_sd_mm.empty(); }))
    mean.rebuilt_sd_mm = MeanOf(curves, &StsCurve::rebuilt_sd_mm);
  if (std::ranges::none_of(curves, [](const StsCurve& curve) { return curve.slope.empty(); }))
    mean.slope = MeanOf(curves, &StsCurve::slope);
  mean.knee_deg = MeanOf(curves, &StsCurve::knee_deg);
  mean.shank_deg = MeanOf(curves, &StsCurve::shank_deg);
  mean.trunk_deg = MeanOf(curves, &StsCurve::trunk_deg);
  mean.knee_sigma_mm = MeanOf(curves, &StsCurve::knee_sigma_mm);
  for (double& sigma : mean.knee_sigma_mm) sigma /= std::sqrt(static_cast<double>(curves.size()));
  for (const StsCurve& curve : curves) mean.duration_s += curve.duration_s / static_cast<double>(curves.size());
  return mean;
}

std::vector<double> ShankLengths(const StsCurve& curve) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < curve.knee.size(); ++i) lengths.push_back((curve.knee[i] - curve.ankle[i]).norm());
  return lengths;
}

Eigen::Matrix2d AxesAlong(const Vector2d& up_the_leg) {
  const Vector2d y = up_the_leg.normalized();
  Eigen::Matrix2d axes;
  axes << y.y(), y.x(), -y.x(), y.y();
  return axes;
}

Eigen::Matrix2d ShankAxes(const StsCurve& curve, std::size_t sample) {
  return AxesAlong(curve.knee[sample] - curve.ankle[sample]);
}

}  // namespace lake::compare
