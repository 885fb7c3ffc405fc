// A body of given height and mass from published segment ratios.
//
// Lengths: Drillis & Contini 1966, as fractions of height in Winter, Biomechanics and Motor Control of Human Movement,
// 4th ed. 2009, fig. 4.1. Masses, centres of mass and densities: ibid., table 4.1 (after Dempster). A limb segment is
// the straight circular frustum that has this length, volume and centre of mass.
#pragma once

#include <optional>

#include "lake/core/options.h"

namespace lake::person {

// Lengths as parts of the height: hip to knee, knee to ankle, hip to shoulder, the foot, the ankle above the ground.
inline constexpr double kThigh = 0.245, kShank = 0.246, kTrunk = 0.288, kFoot = 0.152, kAnkleHeight = 0.039;

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

// The height of a body with a leg of this length, and the mass that gives it another body's mass index.
double HeightOf_mm(const LegLengths& leg);
double MassAtHeight_kg(double height_mm, double other_height_mm, double other_mass_kg);

// The same body with these limbs: their masses and centres of mass stay, so shorter limbs are thicker. Throws Error
// unless both are within 100..1000 mm.
Body WithLeg(Body body, const LegLengths& leg);

// Known sizes of a person.
struct BodySize {
  std::optional<double> height_mm;  // else of a body with this leg, else the paper's average user's, 1800
  std::optional<double> mass_kg;    // else as heavy for its height as the paper's average user, 80 kg at 1800 mm
  std::optional<LegLengths> leg;
};
// Throws Error as the functions above.
Body BodyOf(const BodySize& size);

// The options of a person's size. A height does not change a leg whose lengths a file has: that is an error.
void Describe(BodySize& o, OptionList& options);

}  // namespace lake::person
