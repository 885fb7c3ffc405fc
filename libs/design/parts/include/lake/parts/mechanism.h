// A linkage as parts that can be made: plates in layers that pass each other over the whole range, pins, spacers.
//
// Layers are stacked along z, which with the thigh frame's x (posterior) and y (up) makes a right-handed frame: flexion
// turns anticlockwise about z. The thigh plate's side is the leg's. The actuator stands in a layer of its own
// thickness.
//
// The stacking order is the one with the shortest pins among all orders in which, in every pose of the used range,
// parts of one layer, and a pin and the plates beside it, keep the required clearance. Between the sampled poses no
// corner moves more than half a millimetre, which is added to the clearance. A pin ends in the gap beyond its outermost
// plates, where a retaining ring fits; plates have no protruding parts.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/core/options.h"
#include "lake/linkage/linkage.h"
#include "lake/parts/plate.h"

namespace lake::parts {

// Of plates.
struct Material {
  std::string_view name;
  double density_kg_m3;
  double yield_mpa;  // in tension, least direction
  std::string_view source;
};

// Throws UsageError that lists the known ones.
const Material& MaterialOf(std::string_view name);

// Of pins and the actuator's rod: structural steel, EN 10025-2 and EN 1993-1-1, 3.2.6.
inline constexpr double kSteelDensity_kg_m3 = 7850;
inline constexpr double kSteelModulus_mpa = 210'000;

struct PartOptions {
  double bar_width_mm = 24;          // of all plates, rounded about their pins (the paper: all links of one width)
  double thickness_mm = 4;           // of all plates
  std::string material = "6061-T6";  // of all plates
  double pin_diameter_mm = 8;
  double bore_clearance_mm = 0.1;      // a hole is wider than its pin by this
  double gap_mm = 2;                   // between neighbouring layers: a washer, or a pin's retaining ring
  double actuator_diameter_mm = 40;    // of its body
  double actuator_eye_mm = 16;         // width of its eyes or clevises along the pins
  double actuator_mass_kg = 0.8;       // body and motor, without the rod
  double rod_diameter_mm = 10;         // of the actuator, steel
  double cuff_hole_diameter_mm = 5.5;  // two on the thigh plate, two on the shank link: M5
  double cuff_hole_spacing_mm = 30;
  double clearance_mm = 1;  // in the plane, between parts that pass each other in a layer

  void Check() const;  // throws Error
};
void Describe(PartOptions& o, OptionList& options);

enum class Body : std::uint8_t { kThigh, kShank, kCoupler, kBar, kActuator };
inline constexpr std::size_t kBodies = 5, kPlates = 4;  // the actuator is bought
enum class Joint : std::uint8_t { kKnee, kThighPin, kTip, kShankPin, kMount };
inline constexpr std::size_t kJoints = 5;

std::string_view NameOf(Body body);      // "thigh plate", …
std::string_view LetterOf(Joint joint);  // "K", …

// thigh_from_part: a part's frame in the thigh frame. The thigh plate's frame is the thigh's; of a link it is at its
// first pin with x towards its second (shank K to S, coupler R to S, bar P to R), of the actuator at M with x towards
// R.
struct Placement {
  Eigen::Vector2d at_mm{0, 0};
  double turn_rad = 0;

  Eigen::Vector2d operator*(const Eigen::Vector2d& in_part_mm) const;
};
Placement PlacementOf(Body body, const linkage::Pose& pose);
Eigen::Vector2d PlaceOf(Joint joint, const linkage::Pose& pose);

// Along z, mm.
struct Span {
  double from_mm = 0, to_mm = 0;
  double Length() const { return to_mm - from_mm; }
  double Middle() const { return (from_mm + to_mm) / 2; }
};

// By Body. The thigh plate joins K, P and M and so holds l3, l5 and l6; the shank link reaches beyond S for its cuff.
// Throws Error: links that CheckLinks refuses, options that cannot be made.
std::array<Plate, kPlates> PlatesOf(const linkage::Links& links, const PartOptions& options);

struct Pin {
  Joint joint;
  std::vector<Body> bodies;  // it joins, upwards
  Span span;                 // of the pin, a gap beyond its outermost parts
};

// A tube, or a washer, on a pin between two of its parts.
struct Spacer {
  Joint joint;
  Span span;
  double inner_diameter_mm = 0, outer_diameter_mm = 0;
};

struct Stack {
  std::array<int, kBodies> layer{};  // from 0 up
  std::array<Span, kBodies> span{};  // the actuator's: of its eyes
  std::vector<Pin> pins;             // by joint
  std::vector<Spacer> spacers;
  // Collisions of the order that has the fewest, a sentence each; empty if there is none.
  std::vector<std::string> conflicts;
};

struct Mechanism {
  linkage::Links links;
  linkage::UsedRange range;
  PartOptions options;
  std::array<Plate, kPlates> plates;  // by Body
  Stack stack;

  // False where P and M are too close to each other.
  bool HasThighCuffHoles() const { return plates[0].holes.size() > 3; }
};

Mechanism MakeMechanism(const linkage::Links& links, const linkage::UsedRange& range, const PartOptions& options);

// Strokes of the range, ascending, between which no corner of a part moves more than kSweepStep_mm.
inline constexpr double kSweepStep_mm = 0.5;
std::vector<double> SweepStrokes(const Mechanism& mechanism);

// In the plane, mm, negative where they overlap: between two bodies' outlines, and from a pin with its spacers to a
// body.
double DistanceBetween(const Mechanism& mechanism, Body a, Body b, const linkage::Pose& pose);
double DistanceBetween(const Mechanism& mechanism, Joint joint, Body body, const linkage::Pose& pose);

// A row of the bill of materials. Absent numbers do not apply.
struct PartRow {
  std::string part, material;
  int quantity = 1;
  std::optional<double> length_mm = {}, width_mm = {}, thickness_mm = {}, diameter_mm = {}, bore_mm = {}, mass_g = {};
  std::optional<Span> span = {};
};
std::vector<PartRow> PartList(const Mechanism& mechanism);

}  // namespace lake::parts
