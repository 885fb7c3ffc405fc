// The clearances of a linkage worn on a body: the paper's feasibility check on a mannequin, in numbers.
#pragma once

#include <array>
#include <numbers>

#include "lake/linkage/linkage.h"
#include "lake/person/body.h"

namespace lake::linkage {

using person::Body;

struct WearOptions {
  double bar_width_mm = 24;          // of the link plates, rounded about their pins
  double actuator_diameter_mm = 40;  // of a small linear actuator's body
  double seat_edge_mm = 0;           // knee to the front edge of the seat; 0: a seat that carries half the thigh
  std::array<double, 2> placement_mm{0, 0};  // of the exoskeleton's knee, as in Design
  Mount mount = Mount::kBeside;
  bool has_wide_seat = false;  // one that lies under a linkage beside the leg, too

  bool MeetsLimbs() const { return mount == Mount::kBehind; }
  // Beside the leg a seat is as wide as the linkage's place only where that, or its edge, is said.
  bool MeetsSeat() const { return mount == Mount::kBehind || has_wide_seat || seat_edge_mm > 0; }
};

// A pose with its pins where a placement puts them: in the thigh frame of the leg, whose origin is the human's knee.
Pose PutOnBody(Pose pose, const std::array<double, 2>& placement_mm);

// Clearances of a pose on the body are signed distances of convex outlines in the sagittal plane: the distance of two
// outlines that are apart, or the negative of the shortest translation that separates two that overlap. It equals the
// largest separation over all directions u = (cos, sin), so a solver that varies the separating direction finds the
// same value.
struct Separation {
  double distance_mm = 0;
  double direction_rad = 0;  // that separates them
};

// The pins K, P, R, S and M by these indices, and the straight parts between them, each with rounded ends; the actuator
// is the first.
enum Pin : int { kPinK, kPinP, kPinR, kPinS, kPinM };
struct WornPart {
  Pin from, to;
  double radius_mm;
};
std::array<WornPart, 6> WornPartsOf(const WearOptions& options);
Eigen::Vector2d PlaceOf(Pin pin, const Pose& pose);  // thigh frame

// A seat under a level thigh: the region below its surface and behind its front edge. Thigh frame.
struct Seat {
  double surface_mm = 0, edge_mm = 0;
};
Seat SeatOf(const Body& body, const WearOptions& options);
inline constexpr double kSeated_rad = std::numbers::pi / 2;

// Of one part; direction within [pi, 3 pi / 2], upwards and forwards.
Separation SeparationFrom(const Seat& seat, const WornPart& part, const Pose& pose);
// The least of mount, links and actuator in a pose with the thigh level, mm.
double SeatClearance(const Pose& pose, const Body& body, const WearOptions& options);

enum class Limb { kThigh, kShank };
// A limb's outline from the side, in axes of its own: x posterior, y from the knee along the limb.
std::array<Eigen::Vector2d, 4> OutlineOf(Limb limb, const Body& body);
// A point of the thigh frame in the axes of a limb.
Eigen::Vector2d InLimb(Limb limb, const Eigen::Vector2d& point, double theta_rad);
// Of the actuator; the direction is in the limb's axes.
Separation LimbSeparation(Limb limb, const Pose& pose, const Body& body, const WearOptions& options);

// Distances in the sagittal plane, mm. A negative clearance is an overlap: parts can share that place only side by
// side. Those to seat and limbs are judged only where the linkage meets them (WearOptions).
struct WearCheck {
  Mount mount = Mount::kBeside;
  bool meets_seat = false, meets_limbs = false;
  // The two poses checked: seated, at 90 degrees or the nearest angle, thigh level; and the straightest.
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
  double reach_behind_standing_mm = 0;  // how far the linkage protrudes behind the thigh's back surface, standing

  bool FitsAlongThigh() const { return mount_below_hip_mm >= 0; }
  bool ClearsSeat() const { return !meets_seat || seat_clearance_mm >= 0; }
  bool ClearsLimb() const { return !meets_limbs || (thigh_clearance_mm >= 0 && shank_clearance_mm >= 0); }
};
WearCheck CheckWear(const Links& links, const UsedRange& range, const Body& body, const WearOptions& options);

}  // namespace lake::linkage
