#include "lake/compare/joint_misalignment.h"

#include <algorithm>
#include <cmath>

#include "lake/compare/pointwise_error.h"
#include "lake/core/angles.h"
#include "lake/core/cross.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"
#include "noise.h"

namespace lake::compare {
namespace {

using Eigen::Vector2d;

// The repetitions with the joint's place against the worn knee, in the shank's frame, for their knee.
RegisteredTrial AgainstKnee(const RegisteredTrial& exo) {
  RegisteredTrial against;
  for (const StsCurve& curve : exo.repetitions) {
    if (curve.leg_knee.empty()) continue;
    against.repetitions.push_back(curve);
    StsCurve& relative = against.repetitions.back();
    for (std::size_t i = 0; i < curve.knee.size(); ++i) {
      relative.knee[i] =
          AxesAlong(curve.leg_knee[i] - curve.ankle[i]).transpose() * (curve.knee[i] - curve.leg_knee[i]);
      relative.knee_sigma_mm[i] *= std::sqrt(2.0);  // of joint and knee
    }
  }
  return against;
}

// From the way up to a joint to the way on to the hip; positive in flexion.
double FlexionAt(const Vector2d& joint, const Vector2d& ankle, const Vector2d& hip) {
  const Vector2d shank = joint - ankle, thigh = hip - joint;
  return DegreesFromRadians(std::atan2(Cross(shank, thigh), shank.dot(thigh)));
}

// By how much the angle at a joint differs from that at the leg's own knee; `place_mm`: the joint's against it, shank's
// frame.
double AngleBeside(const StsCurve& leg, std::size_t i, const Vector2d& place_mm) {
  const Vector2d &ankle = leg.ankle[i], &knee = leg.leg_knee[i], &hip = leg.hip[i];
  return FlexionAt(knee + AxesAlong(knee - ankle) * place_mm, ankle, hip) - FlexionAt(knee, ankle, hip);
}

double RelativeRms(const StsCurve& leg, const std::vector<bool>& spike) {
  std::vector<double> relative;
  for (std::size_t i = 0; i < leg.knee.size(); ++i)
    if (!spike[i]) relative.push_back(leg.knee[i].norm() / (leg.leg_knee[i] - leg.ankle[i]).norm());
  return RootMeanSquare(relative);
}

// What sizes are of, spikes left out.
struct Curves {
  std::vector<Vector2d> place_mm, remainder_mm, angle_deg;  // an angle and 0
};

Curves CurvesOf(const StsCurve& leg, const std::vector<Vector2d>& place_mm, const std::vector<bool>& spike) {
  Curves curves;
  Vector2d mean_mm = Vector2d::Zero();
  for (std::size_t i = 0; i < place_mm.size(); ++i) {
    if (spike[i]) continue;
    curves.place_mm.push_back(place_mm[i]);
    mean_mm += place_mm[i];
    curves.angle_deg.emplace_back(AngleBeside(leg, i, place_mm[i]), 0);
  }
  mean_mm /= static_cast<double>(curves.place_mm.size());
  for (const Vector2d& place : curves.place_mm) curves.remainder_mm.emplace_back(place - mean_mm);
  return curves;
}

JointMisalignment::Intervals DrawIntervals(const RegisteredTrial& against, const StsCurve& mean,
                                           const std::vector<bool>& spike, const JointNoise& noise) {
  std::mt19937_64 random(noise.seed);
  const Variation known{.width_percent = noise.width_percent, .event_sd_s = noise.event_sd_s};
  const Curves found = CurvesOf(mean, mean.knee, spike);
  std::vector<std::vector<Vector2d>> place, remainder, angle;
  std::vector<double> mean_x, mean_y;
  for (int k = 0; k < noise.resamples; ++k) {
    ThrowIfInterrupted();
    const std::vector<Vector2d> error = DrawErrorOfMean(against, mean, known, DrawSteadiness(random), random);
    const Curves drawn = CurvesOf(mean, Sum(mean.knee, error), spike);
    place.push_back(Less(drawn.place_mm, found.place_mm));
    remainder.push_back(Less(drawn.remainder_mm, found.remainder_mm));
    angle.push_back(Less(drawn.angle_deg, found.angle_deg));
    const Vector2d mean_mm = drawn.place_mm.front() - drawn.remainder_mm.front();
    mean_x.push_back(mean_mm.x());
    mean_y.push_back(mean_mm.y());
  }
  return {RmsInterval(found.place_mm, place),
          MaxInterval(found.place_mm, place),
          PercentileInterval(mean_x),
          PercentileInterval(mean_y),
          RmsInterval(found.remainder_mm, remainder),
          RmsInterval(found.angle_deg, angle)};
}

}  // namespace

std::optional<JointMisalignment> FindJointMisalignment(const RegisteredTrial& exo, const std::vector<bool>& spike,
                                                       const JointNoise& noise) {
  const RegisteredTrial against = AgainstKnee(exo);
  if (against.repetitions.empty() || std::ranges::all_of(spike, [](bool is) { return is; })) return std::nullopt;
  const StsCurve mean = MeanCurve(against.repetitions);
  const Curves curves = CurvesOf(mean, mean.knee, spike);
  JointMisalignment joint;
  joint.shank_mm = mean.knee;
  for (std::size_t i = 0; i < mean.knee.size(); ++i) {
    const Vector2d in_leg = AxesAlong(mean.leg_knee[i] - mean.ankle[i]) * mean.knee[i];
    joint.thigh_mm.push_back(AxesAlong(mean.hip[i] - mean.leg_knee[i]).transpose() * in_leg);
  }
  joint.rms_mm = std::sqrt(MeanSquare(curves.place_mm));
  for (const Vector2d& place : curves.place_mm) joint.max_mm = std::max(joint.max_mm, place.norm());
  joint.relative_rms = RelativeRms(mean, spike);
  joint.angle_rms_deg = std::sqrt(MeanSquare(curves.angle_deg));
  joint.mean_mm = curves.place_mm.front() - curves.remainder_mm.front();
  joint.remainder_mm = std::sqrt(MeanSquare(curves.remainder_mm));
  joint.repetitions = static_cast<int>(against.repetitions.size());
  if (noise.resamples > 0) joint.intervals = DrawIntervals(against, mean, spike, noise);
  return joint;
}

}  // namespace lake::compare
