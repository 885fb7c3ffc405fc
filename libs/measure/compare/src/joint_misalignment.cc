#include "lake/compare/joint_misalignment.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

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

struct Figures {
  double rms_mm = 0, max_mm = 0, remainder_mm = 0, angle_rms_deg = 0;
  Vector2d mean_mm = Vector2d::Zero();
};

// From the way up to a joint to the way on to the hip; positive in flexion.
double FlexionAt(const Vector2d& joint, const Vector2d& ankle, const Vector2d& hip) {
  const Vector2d shank = joint - ankle, thigh = hip - joint;
  return DegreesFromRadians(std::atan2(Cross(shank, thigh), shank.dot(thigh)));
}

// `leg`: with the leg's own knee; `place_mm`: the joint's against it, shank's frame.
Figures FiguresOf(const StsCurve& leg, const std::vector<Vector2d>& place_mm, const std::vector<bool>& spike) {
  Figures figures;
  double square = 0, samples = 0, angle_square = 0;
  for (std::size_t i = 0; i < place_mm.size(); ++i) {
    if (spike[i]) continue;
    ++samples, square += place_mm[i].squaredNorm(), figures.mean_mm += place_mm[i];
    figures.max_mm = std::max(figures.max_mm, place_mm[i].norm());
    const Vector2d &ankle = leg.ankle[i], &knee = leg.leg_knee[i], &hip = leg.hip[i];
    const Vector2d joint = knee + AxesAlong(knee - ankle) * place_mm[i];
    angle_square += std::pow(FlexionAt(joint, ankle, hip) - FlexionAt(knee, ankle, hip), 2);
  }
  figures.mean_mm /= samples;
  figures.rms_mm = std::sqrt(square / samples);
  figures.angle_rms_deg = std::sqrt(angle_square / samples);
  figures.remainder_mm = std::sqrt(std::max(0.0, square / samples - figures.mean_mm.squaredNorm()));
  return figures;
}

double RelativeRms(const StsCurve& leg, const std::vector<bool>& spike) {
  std::vector<double> relative;
  for (std::size_t i = 0; i < leg.knee.size(); ++i)
    if (!spike[i]) relative.push_back(leg.knee[i].norm() / (leg.leg_knee[i] - leg.ankle[i]).norm());
  return RootMeanSquare(relative);
}

// By how much deviations drawn from n repetitions fall short of what Student's t asks for.
double StudentFactor(std::size_t n) {
  constexpr double kUpper = 0.975, kNormal = 1.959964;
  if (n < 2) return 1;
  return quantile(boost::math::students_t(static_cast<double>(n - 1)), kUpper) / kNormal;
}

JointMisalignment::Intervals DrawIntervals(const RegisteredTrial& against, const StsCurve& mean,
                                           const std::vector<bool>& spike, const JointNoise& noise) {
  std::mt19937_64 random(noise.seed);
  const double factor = StudentFactor(against.repetitions.size());
  std::vector<double> rms, max, mean_x, mean_y, remainder, angle;
  for (int k = 0; k < noise.resamples; ++k) {
    ThrowIfInterrupted();
    std::vector<Vector2d> place = DrawErrorOfMean(against, mean, noise.width_percent, random);
    for (std::size_t i = 0; i < place.size(); ++i) place[i] = mean.knee[i] + factor * place[i];
    const Figures figures = FiguresOf(mean, place, spike);
    rms.push_back(figures.rms_mm), max.push_back(figures.max_mm), remainder.push_back(figures.remainder_mm);
    angle.push_back(figures.angle_rms_deg);
    mean_x.push_back(figures.mean_mm.x()), mean_y.push_back(figures.mean_mm.y());
  }
  return {PercentileInterval(rms),    PercentileInterval(max),       PercentileInterval(mean_x),
          PercentileInterval(mean_y), PercentileInterval(remainder), PercentileInterval(angle)};
}

}  // namespace

std::optional<JointMisalignment> FindJointMisalignment(const RegisteredTrial& exo, const std::vector<bool>& spike,
                                                       const JointNoise& noise) {
  const RegisteredTrial against = AgainstKnee(exo);
  if (against.repetitions.empty() || std::ranges::all_of(spike, [](bool is) { return is; })) return std::nullopt;
  const StsCurve mean = MeanCurve(against.repetitions);
  const Figures figures = FiguresOf(mean, mean.knee, spike);
  JointMisalignment joint;
  joint.shank_mm = mean.knee;
  for (std::size_t i = 0; i < mean.knee.size(); ++i) {
    const Vector2d in_leg = AxesAlong(mean.leg_knee[i] - mean.ankle[i]) * mean.knee[i];
    joint.thigh_mm.push_back(AxesAlong(mean.hip[i] - mean.leg_knee[i]).transpose() * in_leg);
  }
  joint.rms_mm = figures.rms_mm, joint.max_mm = figures.max_mm;
  joint.relative_rms = RelativeRms(mean, spike);
  joint.angle_rms_deg = figures.angle_rms_deg;
  joint.mean_mm = figures.mean_mm, joint.remainder_mm = figures.remainder_mm;
  joint.repetitions = static_cast<int>(against.repetitions.size());
  if (noise.resamples > 0) joint.intervals = DrawIntervals(against, mean, spike, noise);
  return joint;
}

}  // namespace lake::compare
