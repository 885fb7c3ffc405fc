#include "lake/compare/joint_misalignment.h"

#include <algorithm>
#include <cmath>

#include "lake/compare/pointwise_error.h"
#include "lake/core/angles.h"
#include "lake/core/cross.h"
#include "lake/core/distributions.h"
#include "lake/core/statistics.h"
#include "standard_errors.h"

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

// All but intervals.
JointMisalignment OfMean(const RegisteredTrial& against, const std::vector<bool>& spike) {
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
  return joint;
}

// All but that of the remainder.
JointMisalignment::Intervals IntervalsOf(const RegisteredTrial& against, const std::vector<bool>& spike,
                                         const JointMisalignment& joint) {
  const auto figures = [](const JointMisalignment& j) {
    return Eigen::ArrayXd(Eigen::Vector<double, 5>(j.rms_mm, j.max_mm, j.angle_rms_deg, j.mean_mm.x(), j.mean_mm.y()));
  };
  const Eigen::ArrayXd found = figures(joint),
                       variance =
                           JackknifeError([&](const RegisteredTrial&trial) { return figures(OfMean(trial, spike)); },
                                          against, found)
                               .variance;
  const auto around = [&](Eigen::Index figure) {
    return StudentInterval(found[figure], variance[figure], joint.repetitions - 1);
  };
  const auto of_size = [&](Eigen::Index figure) {
    const Interval interval = around(figure);
    return Interval{std::max(0.0, interval.low), interval.high};
  };
  return {.rms_mm = of_size(0),
          .max_mm = of_size(1),
          .mean_x_mm = around(3),
          .mean_y_mm = around(4),
          .remainder_mm = {},
          .angle_rms_deg = of_size(2)};
}

// The next rise's place differs from the mean of n by its own slip and the mean's error, s² (1 + 1/n) along an axis of
// slip s, and by how the joint was put there. Both axes' slips make one variance of 2 (n − 1) degrees of freedom.
void AddNextRise(const RegisteredTrial& against, const std::vector<bool>& spike, double replacement_sd_mm,
                 JointMisalignment& joint, Interval* interval) {
  const auto n = static_cast<double>(against.repetitions.size());
  double squares = 0;
  for (const StsCurve& curve : against.repetitions)
    squares += (OfMean({{curve}, {}}, spike).mean_mm - joint.mean_mm).squaredNorm();
  const double freedom = 2 * (n - 1), slip_variance = squares / freedom, within = std::pow(joint.remainder_mm, 2);
  const auto left = [&](double variance) {
    return std::sqrt(within + 2 * (variance * (1 + 1 / n) + replacement_sd_mm * replacement_sd_mm));
  };
  joint.remainder_mm = left(slip_variance);
  if (!interval) return;
  constexpr double kTail = 0.025;
  *interval = {left(squares / ChiSquaredQuantile(freedom, 1 - kTail)),
               left(squares / ChiSquaredQuantile(freedom, kTail))};
}

}  // namespace

std::optional<JointMisalignment> FindJointMisalignment(const RegisteredTrial& exo, const std::vector<bool>& spike,
                                                       const JointOptions& options) {
  const RegisteredTrial against = AgainstKnee(exo);
  if (against.repetitions.empty() || std::ranges::all_of(spike, [](bool is) { return is; })) return std::nullopt;
  JointMisalignment joint = OfMean(against, spike);
  if (joint.repetitions < 2) return joint;
  if (options.intervals) joint.intervals = IntervalsOf(against, spike, joint);
  AddNextRise(against, spike, options.replacement_sd_mm, joint,
              joint.intervals ? &joint.intervals->remainder_mm : nullptr);
  return joint;
}

double MarkerNoiseOfMeanMm(const StsCurve& curve) {
  return RootMeanSquare(curve.knee_sigma_mm) * std::sqrt(kMarkersOfAJoint / kIndependentSamples);
}

}  // namespace lake::compare
