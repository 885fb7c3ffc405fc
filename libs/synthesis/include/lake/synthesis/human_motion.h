// The human's sit-to-stand, and where an exoskeleton that goes along with it has its knee.
//
// The human's own ankle A and direction psi from ankle to hip are kept (balance); the exoskeleton's knee angle theta
// decides the triangle ankle-knee-hip, with the human's own lengths L = |AK|, |KH| of the same sample:
//   omega = psi + gamma,   gamma = atan2(|KH| sin theta, L + |KH| cos theta)         direction of the shank
//   e = A + (L + p_y) (sin omega, cos omega) + p_x (cos omega, -sin omega) + delta
// p is where the exoskeleton's joint sits against the human knee (shank frame: x anterior, y up), delta the remainder
// that was measured and that the model does not explain. At the human's own knee angle, p = 0 and delta = 0 it is the
// human's knee.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <vector>

#include "lake/compare/registration.h"
#include "lake/linkage/design_file.h"

namespace lake {

// One percent of the motion; leg frame, mm.
struct HumanSample {
  Eigen::Vector2d ankle, knee;
  double shank_mm = 0, thigh_mm = 0;
  double sin_lean = 0, cos_lean = 1;                       // of psi, from the vertical, forward positive
  double knee_rad = 0;                                     // 0 straight, flexion positive
  Eigen::Vector2d remainder_mm = Eigen::Vector2d::Zero();  // delta
};
using HumanMotion = std::vector<HumanSample>;  // kPercentSamples of them

// delta is zero. Throws Error where a segment or the leg has no length.
HumanMotion MakeHumanMotion(const StsCurve& human);

template <typename T>
Eigen::Matrix<T, 2, 1> PredictKnee(const HumanSample& human, const T& theta_rad, const T& placement_x_mm,
                                   const T& placement_y_mm) {
  using std::cos, std::sin, std::sqrt;
  const T along = cos(theta_rad) * human.thigh_mm + human.shank_mm, aside = sin(theta_rad) * human.thigh_mm;
  const T leg = sqrt(along * along + aside * aside);  // ankle to hip
  const T sin_omega = (along * human.sin_lean + aside * human.cos_lean) / leg;
  const T cos_omega = (along * human.cos_lean - aside * human.sin_lean) / leg;
  const T shank = placement_y_mm + human.shank_mm;
  return {shank * sin_omega + placement_x_mm * cos_omega + (human.ankle.x() + human.remainder_mm.x()),
          shank * cos_omega - placement_x_mm * sin_omega + (human.ankle.y() + human.remainder_mm.y())};
}

// The exoskeleton in the human's motion.
struct Prediction {
  std::vector<double> stroke_mm, theta_rad;  // per percent
  StsCurve exo;                              // with the predicted knee; the ankle is the human's
  double relative_rms = 0, rms_mm = 0;       // misalignment, by the comparison's own formula
};

// What a linkage does when its stroke goes through these values (one per percent); nullopt where a stroke lies outside
// its used range (from d_min until the first of standing, a turning point and the end of its assembly).
std::optional<Prediction> Predict(const Links& links, double d_min_mm, double standing_deg,
                                  const Eigen::Vector2d& placement_mm, const std::vector<double>& stroke_mm,
                                  const HumanMotion& human);

// The strokes that give the human's knee angles, those beyond the used range clamped to its ends; nullopt if the
// linkage cannot be assembled at d_min.
std::optional<std::vector<double>> TrackingStrokes(const Links& links, double d_min_mm, double standing_deg,
                                                   const HumanMotion& human);

// T* = 100 max |dd/ds| / max_speed: the time of a sit-to-stand that follows the human's knee exactly. Between samples
// the stroke is taken as linear.
double TrackingTime(const std::vector<double>& tracking_stroke_mm, double max_speed_mm_s);

// The strokes of a program, one per percent: of a constant one linear from the human's first knee angle (at least
// d_min) to the last; of a free one its knots over their own duration. nullopt as above.
std::optional<std::vector<double>> ProgramStrokes(const Design& design, double standing_deg, const HumanMotion& human);

// Sets delta to what the model of the design worn in the exo trial leaves of the measured path. Throws Error if that
// design cannot make the motion.
void SetRemainder(const StsCurve& exo, const Design& worn, double standing_deg, HumanMotion& human);

}  // namespace lake
