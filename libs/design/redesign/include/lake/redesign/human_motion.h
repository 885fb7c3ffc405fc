// The human's sit-to-stand, and where an exoskeleton that follows it has its knee.
//
// The human's own ankle A and direction psi from ankle to hip are kept (balance); the exoskeleton's knee angle theta
// decides the triangle ankle-knee-hip, with the human's own lengths L = |AK|, |KH| of the same sample:
//   omega = psi + gamma,   gamma = atan2(|KH| sin theta, L + |KH| cos theta)         direction of the shank
//   e = A + (L + p_y + delta_y) (sin omega, cos omega) + (p_x + delta_x) (cos omega, -sin omega)
// p is where the exoskeleton's joint sits against the human knee (shank frame: x anterior, y up), delta how its mount
// slipped on the leg: what the exoskeleton trial's own leg and the worn placement do not explain of the measured joint.
// At the human's own knee angle, p = 0 and delta = 0 it is the human's knee.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <vector>

#include "lake/compare/registration.h"
#include "lake/linkage/design_file.h"

namespace lake::redesign {

// One percent of the motion; leg frame, mm.
struct HumanSample {
  Eigen::Vector2d ankle, knee;
  double shank_mm = 0, thigh_mm = 0;
  double sin_lean = 0, cos_lean = 1;                  // of psi, from the vertical, forward positive
  double knee_rad = 0;                                // 0 straight, flexion positive
  Eigen::Vector2d slip_mm = Eigen::Vector2d::Zero();  // delta, shank frame
};
// At equal steps from 0 to 100 %: kPercentSamples of them, or fewer for a search that need not be exact.
using HumanMotion = std::vector<HumanSample>;

// At what percent a sample of a motion lies.
inline double PercentOf(std::size_t sample, const HumanMotion& motion) {
  return 100.0 * static_cast<double>(sample) / static_cast<double>(motion.size() - 1);
}

// The same, the leg leaning farther forward by these angles, one per sample; none: as it is. What the exoskeleton's
// knee is compared with stays.
HumanMotion Leaning(HumanMotion motion, const std::vector<double>& leg_rad);

// Every `step`th sample; `step` divides 100.
HumanMotion Thinned(const HumanMotion& motion, std::size_t step);

// From the curve's compared knee; delta is zero. Throws Error where a segment or the leg has no length.
HumanMotion MakeHumanMotion(const compare::StsCurve& human);

// Means over the motion, mm.
struct SegmentLengths {
  double shank_mm = 0, thigh_mm = 0;
};
SegmentLengths SegmentsOf(const HumanMotion& motion);

// With another lean of the leg than the human's.
template <typename T, typename Lean>
Eigen::Matrix<T, 2, 1> PredictKnee(const HumanSample& human, const Lean& sin_lean, const Lean& cos_lean,
                                   const T& theta_rad, const T& placement_x_mm, const T& placement_y_mm) {
  using std::cos, std::sin, std::sqrt;
  const T along = cos(theta_rad) * human.thigh_mm + human.shank_mm, aside = sin(theta_rad) * human.thigh_mm;
  const T leg = sqrt(along * along + aside * aside);  // ankle to hip
  const T sin_omega = (along * sin_lean + aside * cos_lean) / leg;
  const T cos_omega = (along * cos_lean - aside * sin_lean) / leg;
  const T shank = placement_y_mm + (human.shank_mm + human.slip_mm.y());
  const T anterior = placement_x_mm + human.slip_mm.x();
  return {shank * sin_omega + anterior * cos_omega + human.ankle.x(),
          shank * cos_omega - anterior * sin_omega + human.ankle.y()};
}
template <typename T>
Eigen::Matrix<T, 2, 1> PredictKnee(const HumanSample& human, const T& theta_rad, const T& placement_x_mm,
                                   const T& placement_y_mm) {
  return PredictKnee(human, human.sin_lean, human.cos_lean, theta_rad, placement_x_mm, placement_y_mm);
}

// What of a joint is off the human's knee.
enum class MisalignmentOf {
  kPath,  // its path against that of the human's own trial, at equal percent: pace and lean are in it
  kJoint  // the joint against the knee that it is worn on, at the same instant: p + delta
};

// RMS over the motion.
struct MisalignmentRms {
  double relative = 0;  // of the shank's length
  double mm = 0;
};

// How much farther forward than in the human trial leg (ankle to hip) and trunk lean, one value per sample of the
// motion; empty: not at all.
struct Lean {
  std::vector<double> leg_rad, trunk_rad;
};

// At one percent from where the feet alone bear the body.
struct BalanceSample {
  double percent = 0;
  double pressure_mm = 0;  // centre of pressure on the ground, before the ankle
  double margin_mm = 0;    // how far that is inside the foot; negative outside: nobody keeps the balance
  double knee_nm = 0;      // of one leg, extension positive
};

struct BalanceCourse {
  std::vector<BalanceSample> samples;
  double duration_s = 0;  // of the rise
  double margin_mm = 0;   // the least …
  double at_percent = 0;  // … and where it is
  double peak_knee_nm = 0;
};

// The exoskeleton in the human's motion.
struct Prediction {
  std::vector<double> stroke_mm, theta_rad;   // per percent
  compare::StsCurve exo;                      // the joint, and the leg that goes along; the ankle is the human's
  MisalignmentRms path, joint;                // the path's by the comparison's own formula …
  MisalignmentOf of = MisalignmentOf::kPath;  // … and which of both is limited and weighed
  double cuff_force_n = 0;                    // the largest at a cuff, where cuffs and flesh are stiffest
  double angle_mismatch_deg = 0;              // the largest difference of its knee angle from the human's
  std::optional<BalanceCourse> balance{};     // where the person's body is known

  const MisalignmentRms& Rms() const { return of == MisalignmentOf::kJoint ? joint : path; }
};

// A linkage with its actuator: from d_min it is used until the first of d_max, standing, a turning point and the end of
// its assembly.
struct DrivenLinks {
  linkage::Links links;
  double d_min_mm = 242;
  double standing_deg = 0;
  std::optional<double> d_max_mm{};  // absent: no limit
};
DrivenLinks DrivenLinksOf(const linkage::Design& design, double standing_deg);

// What a linkage does when its stroke goes through these values (one per percent); nullopt where a stroke lies outside
// its used range.
std::optional<Prediction> Predict(const DrivenLinks& linkage, const Eigen::Vector2d& placement_mm,
                                  const std::vector<double>& stroke_mm, const HumanMotion& human);

// The strokes that give these knee angles, or the human's; those beyond the used range clamped to its ends. nullopt if
// the linkage cannot be assembled at d_min.
std::optional<std::vector<double>> StrokesForAngles(const DrivenLinks& linkage, const std::vector<double>& knee_rad);
std::optional<std::vector<double>> TrackingStrokes(const DrivenLinks& linkage, const HumanMotion& human);

// T* = 100 max |dd/ds| / max_speed: the time of a sit-to-stand that follows the human's knee exactly. Between samples
// the stroke is taken as linear; so the knots of a program need this time.
double TrackingTime(const std::vector<double>& tracking_stroke_mm, double max_speed_mm_s);

// The share of the motion, 0 to 1, in which that speed is enough where all of it takes `duration_s`.
double TrackedShare(const std::vector<double>& tracking_stroke_mm, double max_speed_mm_s, double duration_s);

// The strokes of a program, one per percent: of a constant one linear from the human's first knee angle (at least
// d_min) to the last; of a free one its knots over their own duration. nullopt as above.
std::optional<std::vector<double>> ProgramStrokes(const linkage::Design& design, double standing_deg,
                                                  const HumanMotion& human);

// Of what the exoskeleton trial's joint is off the human's knee. RMS in mm; the paths of mount, pace and lean add up to
// the measured difference.
struct MountSlip {
  double slip_mm = 0;   // delta
  double mount_mm = 0;  // the joint against the trial's own knee: placement and delta
  Eigen::Vector2d placement_mm = Eigen::Vector2d::Zero();  // its mean: where the joint sat, shank frame
  double pace_mm = 0;                                      // the leg's knee angle is another one at this percent …
  double lean_mm = 0;                                      // … and so are its ankle, lean and lengths
};

// Sets delta from the exoskeleton trial's own leg and the placement worn in it; where there is a spike, from the line
// between the samples around it. nullopt, and delta zero, if the trial shows no leg of its own. Throws Error where that
// leg has no length.
std::optional<MountSlip> SetSlip(const compare::StsCurve& exo, const std::vector<bool>& spike,
                                 const Eigen::Vector2d& worn_placement_mm, HumanMotion& human);

}  // namespace lake::redesign
