// Sit-to-stands with known truth: minimum-jerk segment angles, seen exactly.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "lake/core/angles.h"
#include "lake/gait/leg_angles.h"
#include "lake/gait/leg_view.h"

namespace lake {

struct SyntheticLegOptions {
  double rate_hz = 60;
  int repetitions = 2;
  double rest_s = 1.0;  // seated before each rise, and standing before each lowering
  double move_s = 1.8;  // one rise or one lowering
  bool starts_standing = false;
  double time_jitter = 0;  // of a frame's step: irregular stamps
  double shank_mm = 430, thigh_mm = 410, trunk_mm = 260;
  double skin_mm = 0;  // how much the shank's markers come apart with flexion; the thigh's by 1.7 times that
  motion::Facing facing = motion::Facing::kRight;
  Eigen::Vector2d ankle_mm = Eigen::Vector2d(30, 90);
};

struct SyntheticLeg {
  std::vector<double> time_s;
  std::vector<gait::LegPoints> points_mm;  // plane frame
  std::vector<motion::LegSample> truth;    // vectors and angles without noise
  std::vector<double> onset_s;             // when the trunk starts to move, per rise
};

// 0 before 0, 1 after 1, with vanishing speed and acceleration at both (Flash & Hogan 1985).
inline double MinimumJerk(double u) {
  if (u <= 0) return 0;
  if (u >= 1) return 1;
  return u * u * u * (10 + u * (-15 + 6 * u));
}

struct SyntheticAngles {
  double shank_deg, thigh_deg, trunk_deg;
};

// 0 seated … 1 standing, `u` linear in time.
inline SyntheticAngles RiseAngles(double u) {
  const double forward = MinimumJerk(u / 0.5), back = MinimumJerk((u - 0.45) / 0.55);
  return {8 + 12 * MinimumJerk((u - 0.1) / 0.4) - 19 * back, -84 + 86 * MinimumJerk((u - 0.3) / 0.7),
          5 + 35 * forward - 40 * back};
}

inline SyntheticLeg MakeSyntheticLeg(const SyntheticLegOptions& o, unsigned seed = 1) {
  SyntheticLeg leg;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-0.5, 0.5);
  const double cycle_s = 2 * (o.rest_s + o.move_s), total_s = o.repetitions * cycle_s;
  const double offset_s = o.starts_standing ? o.rest_s + o.move_s : 0;
  for (int r = 0; r <= o.repetitions; ++r) {
    const double onset_s = r * cycle_s + o.rest_s - offset_s;
    if (onset_s > 0 && onset_s + o.move_s < total_s) leg.onset_s.push_back(onset_s);
  }
  for (int i = 0; i < total_s * o.rate_hz; ++i) {
    const double t = (i + (i > 0 ? o.time_jitter * jitter(random) : 0)) / o.rate_hz;
    const double phase = std::fmod(t + offset_s, cycle_s);
    const bool lowering = phase > cycle_s / 2;
    const double u = ((lowering ? phase - cycle_s / 2 : phase) - o.rest_s) / o.move_s;
    const SyntheticAngles angles = RiseAngles(lowering ? 1 - u : u);
    const double side = o.facing == motion::Facing::kRight ? 1 : -1;
    const auto along = [&](double length, double lean_deg) {
      const double lean_rad = RadiansFromDegrees(lean_deg);
      return Eigen::Vector2d(side * length * std::sin(lean_rad), length * std::cos(lean_rad));
    };
    const double skin_mm = o.skin_mm * std::sin(RadiansFromDegrees(angles.shank_deg - angles.thigh_deg));
    gait::LegPoints points;
    points.ankle = o.ankle_mm + Eigen::Vector2d(3 * std::sin(2 * t), 1.5 * std::sin(3 * t));
    points.knee = *points.ankle + along(o.shank_mm + skin_mm, angles.shank_deg);
    points.hip = *points.knee + along(o.thigh_mm - 1.7 * skin_mm, angles.thigh_deg);
    points.waist = *points.hip + along(o.trunk_mm, angles.trunk_deg);
    leg.time_s.push_back(t);
    leg.points_mm.push_back(points);
    leg.truth.push_back(gait::MakeLegSample(points, o.facing, Eigen::Vector2d::UnitY()));
  }
  return leg;
}

enum class NoiseKind {
  kWhite,
  kAutoregressive,  // correlation 0.9 from frame to frame
  kBrief,           // correlation 0.5
  kFrozen,          // as video coding makes it: kept while the marker rests, renewed once a second
};

struct TrackNoise {
  double sigma_px = 0.03;
  NoiseKind kind = NoiseKind::kWhite;
  double stated_sigma_px = 0;  // 0: the true one
};

// The markers as seen under a view, with noise. Names ankle, knee, hip, waist.
inline motion::MarkerRecording MakeTracks(const std::vector<double>& time_s,
                                          const std::vector<gait::LegPoints>& points_mm, const gait::LegView& view,
                                          const TrackNoise& noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise.sigma_px);
  motion::MarkerRecording recording;
  recording.unit = view.recorded_in_plane ? motion::LengthUnit::kMm : motion::LengthUnit::kPx;
  recording.time_s = time_s;
  for (std::size_t i = 0; i < time_s.size(); ++i) recording.frame.push_back(static_cast<std::int64_t>(i));
  const std::pair<const char*, std::optional<Eigen::Vector2d> gait::LegPoints::*> markers[] = {
      {"ankle", &gait::LegPoints::ankle},
      {"knee", &gait::LegPoints::knee},
      {"hip", &gait::LegPoints::hip},
      {"waist", &gait::LegPoints::waist}};
  for (const auto& [name, point] : markers) {
    motion::MarkerTrack track{name, {}};
    Eigen::Vector2d error{normal(random), normal(random)}, last = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      const Eigen::Vector2d seen =
          gait::RecordedFromPlane<double>(view, Eigen::Vector2d(*(points_mm[i].*point)), view.Depth(name));
      const Eigen::Vector2d drawn{normal(random), normal(random)};
      const bool resting = i > 0 && (seen - last).norm() < 0.1 && i % 60 != 0;
      if (noise.kind == NoiseKind::kWhite || (noise.kind == NoiseKind::kFrozen && !resting)) error = drawn;
      if (noise.kind == NoiseKind::kAutoregressive) error = 0.9 * error + std::sqrt(1 - 0.81) * drawn;
      if (noise.kind == NoiseKind::kBrief) error = 0.5 * error + std::sqrt(1 - 0.25) * drawn;
      last = seen;
      const double sigma = noise.stated_sigma_px > 0 ? noise.stated_sigma_px : noise.sigma_px;
      track.samples.push_back({seen + error, sigma, motion::SampleStatus::kDetected});
    }
    recording.markers.push_back(track);
  }
  return recording;
}

// A 1280 × 720 camera square to the plane at 2 mm per px, without a lens: a scale bar is enough.
inline gait::LegView ScaledView() {
  gait::LegView view;
  view.mm_per_px = 2;
  return view;
}

// A camera with a lens, 3 m away, turned by 12° and tilted by 4°.
inline gait::LegView CalibratedView() {
  gait::LegView view;
  view.camera = camera::Camera{1280, 720, 1100, 1104, 645, 352, {-0.18, 0.06, 4e-4, -3e-4, 0}};
  camera::PlanePose pose = camera::PlanePose::Identity();
  pose.linear() = (Eigen::AngleAxisd(RadiansFromDegrees(180 - 4), Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(RadiansFromDegrees(12), Eigen::Vector3d::UnitY()))
                      .toRotationMatrix();
  pose.translation() = Eigen::Vector3d(-100, 650, 3000);
  view.camera_from_plane = pose;
  return view;
}

// How the fitted knee angle compares with the truth.
struct KneeErrors {
  double rms_deg = 0, raw_rms_deg = 0, worst_deg = 0;
  double cover = 0;       // share inside ± 2 sd
  double normalized = 0;  // rms of error / sd
  double peak_deg = 0;    // of the largest and the smallest angle, the worse
};

inline KneeErrors CompareKnee(const motion::LegMotion& motion, const std::vector<motion::LegSample>& truth) {
  KneeErrors errors;
  double squares = 0, raw_squares = 0, normalized = 0, most = -1e9, least = 1e9, true_most = -1e9, true_least = 1e9;
  int count = 0, raw_count = 0, covered = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const motion::LegSample& sample = motion.samples[i];
    if (std::isfinite(sample.knee_raw_deg))
      ++raw_count, raw_squares += std::pow(sample.knee_raw_deg - truth[i].knee_deg, 2);
    if (!std::isfinite(sample.knee_deg)) continue;
    const double error = sample.knee_deg - truth[i].knee_deg;
    ++count, squares += error * error, normalized += std::pow(error / sample.knee_sigma_deg, 2);
    covered += std::abs(error) <= 2 * sample.knee_sigma_deg;
    errors.worst_deg = std::max(errors.worst_deg, std::abs(error));
    most = std::max(most, sample.knee_deg), true_most = std::max(true_most, truth[i].knee_deg);
    least = std::min(least, sample.knee_deg), true_least = std::min(true_least, truth[i].knee_deg);
  }
  errors.rms_deg = std::sqrt(squares / count), errors.raw_rms_deg = std::sqrt(raw_squares / raw_count);
  errors.cover = static_cast<double>(covered) / count, errors.normalized = std::sqrt(normalized / count);
  errors.peak_deg = std::max(std::abs(most - true_most), std::abs(least - true_least));
  return errors;
}

}  // namespace lake
