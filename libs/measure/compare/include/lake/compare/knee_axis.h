// The human knee is no hinge: the gap that a fixed pivot leaves.
#pragma once

#include <Eigen/Core>

namespace lake::compare {

// Origin of the tibia in the femur frame (x anterior, y up the femur), mm, at a knee angle of 0 (straight) to 120°:
// planar splines of Yamaguchi & Zajac (J. Biomech. 22, 1989) as in the gait2392 model (Delp et al., IEEE Trans. Biomed.
// Eng. 37, 1990). Throws UsageError beyond.
Eigen::Vector2d TibiaOriginInFemur(double knee_deg);

// A hinge that joins a point of the femur and one of the tibia; its gap is how far the knee's motion tears these points
// apart.
struct FixedPivot {
  Eigen::Vector2d in_femur_mm, in_tibia_mm;  // the same axes, each body's own origin
  double gap_rms_mm = 0, gap_max_mm = 0;     // over the range of angles
  double most_gap_deg = 0;                   // the angle of the largest gap
};

// The hinge with the least RMS gap over a range of knee angles, every angle counting alike (linear least squares).
FixedPivot BestFixedPivot(double from_deg, double to_deg);

// What a hinge placed δ off the best one adds: 2 δ sin(θ/2) after the knee has turned by θ.
double OffsetGap(double offset_mm, double knee_deg);

}  // namespace lake::compare
