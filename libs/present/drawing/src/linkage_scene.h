// The leg and the linkage on it, drawn into a scene.
//
// Picture frame: origin at the knee, x anterior (to the right, the way the subject faces), y up, mm.
#pragma once

#include <vector>

#include "lake/linkage/linkage.h"
#include "lake/linkage/wear.h"
#include "scene.h"

namespace lake::drawing {

// A pose as it stands in the picture.
class PosedLeg {
 public:
  // `shank_tilt_rad`: 0 shank upright, positive when its upper end leans back (counter-clockwise).
  PosedLeg(const linkage::Pose& pose, double shank_tilt_rad = 0) : pose_(pose), shank_tilt_rad_(shank_tilt_rad) {}

  const linkage::Pose& ThePose() const { return pose_; }
  double ThighTilt() const { return shank_tilt_rad_ + pose_.theta_rad; }
  Eigen::Vector2d FromThigh(const Eigen::Vector2d& point_in_thigh_mm) const;
  Eigen::Vector2d FromShank(const Eigen::Vector2d& point_in_shank_mm) const;  // shank frame with its origin at the knee

 private:
  linkage::Pose pose_;
  double shank_tilt_rad_;
};

namespace link_colour {
inline constexpr const char* kThigh = "#0072B2";    // l3, l5, l6: one plate
inline constexpr const char* kBar = "#009E73";      // l2
inline constexpr const char* kCoupler = "#C17F00";  // l1
inline constexpr const char* kShank = "#CC79A7";    // l4
inline constexpr const char* kCylinder = "#CC0000";
inline constexpr const char* kPiston = "#000000";
}  // namespace link_colour

// The same for text on white, with a contrast of at least 4.5.
namespace link_text {
inline constexpr const char* kThigh = link_colour::kThigh;
inline constexpr const char* kBar = "#007052";
inline constexpr const char* kCoupler = "#8A5A00";
inline constexpr const char* kShank = "#9C3F70";
inline constexpr const char* kCylinder = link_colour::kCylinder;
}  // namespace link_text

// Foot, shank and thigh.
std::vector<PlanePath> LegOutlines(const PosedLeg& leg, const person::Body& body);

void DrawLeg(Scene& scene, const PosedLeg& leg, const person::Body& body);

// The outline of the thigh plate, in the thigh frame, as it is cut: round about its pins K, M and P.
PlanePath ThighPlate(const linkage::Pose& pose, double radius_mm);

inline constexpr double kCylinderWidth = 1.6;  // in widths of the links

// `d_min_mm` decides how long the cylinder is: what the shortest stroke leaves for it. Widths are for looks, not to
// scale.
void DrawLinkage(Scene& scene, const PosedLeg& leg, double d_min_mm, double link_half_width_mm, double pin_size);

}  // namespace lake::drawing
