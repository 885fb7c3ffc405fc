// Walks drawn with known heel strikes and toe-offs: the foot strikes with the heel, lies flat, rises over the toe and
// swings; the hip goes at constant speed.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "lake/motion/marker_recording.h"

namespace lake {

struct DrawnWalkOptions {
  double rate_hz = 100, length_s = 6, stride_s = 1.1, stride_mm = 1300, stance = 0.62;
  double direction = 1;       // 1 towards +x, −1 towards −x
  bool is_treadmill = false;  // the hip stays
  bool is_backward = false;   // the same, played backward
  double noise_mm = 0;
  unsigned seed = 1;
};

struct DrawnFoot {
  Eigen::Vector2d heel, toe, ankle;
};

// At a phase in strides (whole numbers are heel strikes), x from the place of the heel at the first.
inline DrawnFoot DrawFoot(double phase, const DrawnWalkOptions& o) {
  constexpr double kFoot_mm = 200, kSole_mm = 40, kDegree = 0.0174533;
  const double whole = std::floor(phase), u = phase - whole, flat = 0.14, rise = 0.6 * o.stance;
  const auto smooth = [](double v) { return v <= 0 ? 0 : v >= 1 ? 1 : v * v * v * (10 + v * (-15 + 6 * v)); };
  const auto along = [](double deg) { return Eigen::Vector2d(std::cos(deg * kDegree), std::sin(deg * kDegree)); };
  const double off_deg = -55, strike_deg = 15;
  Eigen::Vector2d heel(0, kSole_mm);
  double pitch_deg = 0;
  if (u < flat) {
    pitch_deg = strike_deg * std::pow(1 - u / flat, 2);
  } else if (u < o.stance) {
    pitch_deg = off_deg * std::pow(std::max(0.0, (u - rise) / (o.stance - rise)), 2);
    heel = Eigen::Vector2d(kFoot_mm, kSole_mm) - kFoot_mm * along(pitch_deg);
  } else {
    const double v = (u - o.stance) / (1 - o.stance);
    pitch_deg = off_deg + (strike_deg - off_deg) * smooth(v / 0.9);
    const Eigen::Vector2d from = Eigen::Vector2d(kFoot_mm, kSole_mm) - kFoot_mm * along(off_deg);
    heel.x() = from.x() + (o.stride_mm - from.x()) * smooth(0.05 + 0.95 * v);
    heel.y() = kSole_mm + (from.y() - kSole_mm) * std::pow(1 - v, 4) * (1 + 4 * v) + 260 * v * v * (1 - v) +
               2500 * v * v * std::pow(1 - v, 4);
  }
  heel.x() += whole * o.stride_mm;
  const Eigen::Vector2d forward = along(pitch_deg), up(-forward.y(), forward.x());
  return {heel, heel + kFoot_mm * forward, heel + 45 * forward + 50 * up};
}

// Markers ankle, knee, hip, waist, heel, toe, other_ankle, other_heel, other_toe in the plane frame, mm. Heel strikes
// are at (k + 0.3) strides of stride_s, toe-offs at `stance` after them, those of the other leg half a stride later.
inline motion::MarkerRecording DrawWalk(const DrawnWalkOptions& o) {
  motion::MarkerRecording recording;
  recording.unit = motion::LengthUnit::kMm;
  for (const char* name : {"ankle", "knee", "hip", "waist", "heel", "toe", "other_ankle", "other_heel", "other_toe"})
    recording.markers.push_back({name, {}});
  std::mt19937 random(o.seed);
  std::normal_distribution<double> noise(0, 1);
  const auto frames = static_cast<int>(o.length_s * o.rate_hz);
  for (int i = 0; i < frames; ++i) {
    const double t = i / o.rate_hz, at = (o.is_backward ? o.length_s - t : t) / o.stride_s - 0.3;
    const DrawnFoot own = DrawFoot(at, o);
    DrawnFoot other = DrawFoot(at - 0.5, o);
    for (Eigen::Vector2d* place : {&other.heel, &other.toe, &other.ankle}) place->x() += 0.5 * o.stride_mm;
    // The heel strikes a quarter of a stride and some before the hip.
    const Eigen::Vector2d hip(at * o.stride_mm - 0.22 * o.stride_mm, 915 + 15 * std::cos(4 * 3.14159265 * (at - 0.25)));
    const Eigen::Vector2d leg = hip - own.ankle;
    const double bent = std::sqrt(std::max(0.0, std::pow(435, 2) - leg.squaredNorm() / 4));
    const Eigen::Vector2d knee = own.ankle + leg / 2 + bent * Eigen::Vector2d(leg.y(), -leg.x()).normalized();
    const Eigen::Vector2d places[] = {
        own.ankle, knee, hip, hip + Eigen::Vector2d(0, 200), own.heel, own.toe, other.ankle, other.heel, other.toe};
    recording.frame.push_back(i);
    recording.time_s.push_back(t);
    for (std::size_t m = 0; m < recording.markers.size(); ++m) {
      const double x = places[m].x() - (o.is_treadmill ? at * o.stride_mm : 0);
      recording.markers[m].samples.push_back(
          {Eigen::Vector2d(o.direction * x + o.noise_mm * noise(random), places[m].y() + o.noise_mm * noise(random)),
           o.noise_mm, motion::SampleStatus::kDetected});
    }
  }
  return recording;
}

}  // namespace lake
