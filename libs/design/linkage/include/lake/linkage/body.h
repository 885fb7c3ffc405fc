// A body of given height and mass from published segment ratios, and whether a linkage can be worn on it: the paper's
// feasibility check on a mannequin, in numbers.
//
// Lengths: Drillis & Contini 1966, as fractions of height in Winter, Biomechanics and Motor Control of Human Movement,
// 4th ed. 2009, fig. 4.1. Masses, centres of mass and densities: ibid., table 4.1 (after Dempster). A limb segment is
// the straight circular frustum that has this length, volume and centre of mass.
#pragma once

#include "lake/linkage/linkage.h"

namespace lake::linkage {

// A frustum of a cone along a limb.
struct LimbSegment {
  double length_mm = 0;
  double proximal_radius_mm = 0, distal_radius_mm = 0;

  double RadiusAt(double from_distal_mm) const;  // constant beyond the ends
};

struct Body {
  double height_mm = 0, mass_kg = 0;
  LimbSegment thigh, shank;  // hip to knee, knee to ankle
  double foot_length_mm = 0, ankle_height_mm = 0;
  double trunk_length_mm = 0;  // hip to shoulder
  double trunk_depth_mm = 0;   // of an elliptic cylinder as broad as the shoulders
  double head_height_mm = 0, neck_length_mm = 0;
};

// Throws Error unless the height is within 500..2500 mm and the mass within 10..400 kg.
Body BodyOf(double height_mm, double mass_kg);

// A person's own leg: hip to knee and knee to ankle, mm.
struct LegLengths {
  double thigh_mm = 0, shank_mm = 0;
};

// The height of a body whose leg is as long as this one, and the mass that gives it the body mass index of another.
double HeightOf_mm(const LegLengths& leg);
double MassAtHeight_kg(double height_mm, double other_height_mm, double other_mass_kg);

// The same body with these limbs: their masses and centres of mass stay, so shorter limbs are thicker. Throws Error
// unless both are within 100..1000 mm.
Body WithLeg(Body body, const LegLengths& leg);

struct WearOptions {
  double bar_width_mm = 24;          // of the link plates, rounded about their pins
  double actuator_diameter_mm = 40;  // of a small linear actuator's body
  double seat_edge_mm = 0;           // knee to the front edge of the seat; 0: a seat that carries half the thigh
};

// Distances in the sagittal plane, mm. A negative clearance is an overlap: parts can share that place only side by
// side.
struct WearCheck {
  // The two poses looked at: 90 degrees or the nearest there is, thigh level; and the straightest.
  double seated_stroke_mm = 0, seated_deg = 0;
  double standing_stroke_mm = 0, standing_deg = 0;
  double mount_below_hip_mm = 0;     // free thigh between the mount's plate and the hip joint
  double mount_behind_thigh_mm = 0;  // from the thigh's back surface to the mount pin; the bracket bridges it
  double seat_clearance_mm = 0;      // least distance of mount, links and actuator to the seat, thigh level on it
  double seat_edge_needed_mm = 0;  // knee to front edge of a seat as wide as the legs that would just clear the linkage
  double thigh_clearance_mm = 0;   // least distance of the actuator to the thigh over the used range …
  double thigh_clearance_deg = 0;  // … and the knee angle where it is
  double shank_clearance_mm = 0;   // the same for actuator and shank
  double shank_clearance_deg = 0;
  double reach_behind_standing_mm = 0;  // how far the linkage stands out behind the thigh's back surface, standing

  bool FitsAlongThigh() const { return mount_below_hip_mm >= 0; }
  bool ClearsSeat() const { return seat_clearance_mm >= 0; }
  bool ClearsLimb() const { return thigh_clearance_mm >= 0 && shank_clearance_mm >= 0; }
};
WearCheck CheckWear(const Links& links, const UsedRange& range, const Body& body, const WearOptions& options);

}  // namespace lake::linkage
