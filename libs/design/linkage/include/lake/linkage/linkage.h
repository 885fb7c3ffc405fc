// The knee linkage: a planar four-bar driven by a linear actuator, in closed form.
//
// Thigh frame: origin at the knee K, y from knee to hip, x posterior. Lengths mm, angles rad.
//   P = (0, l3)   thigh pin of the slewing bar      R = P + l2 (sin phi, cos phi)   its tip
//   M = (l5, l3 + l6)   actuator mount              S = l4 (sin kappa, cos kappa)   shank pin, kappa = pi - theta
// Loops: |R - M| = d and |R - S| = l1. The knee angle theta is 0 standing, positive in flexion.
// The room's README has a drawing and the table of symbols; equation numbers are those of Gautam, Singla & Singla:
// SolvePose has Eqs. (1) to (6), line by line.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lake::linkage {

// Where the linkage is worn: beside the leg, where it passes thigh and shank, or behind it, where it must clear them.
enum class Mount : std::uint8_t { kBeside, kBehind };
const char* NameOf(Mount mount);  // "beside", "behind"
// Throws UsageError for another name.
Mount MountOf(const std::string& name);

// The six independent link lengths, mm.
struct Links {
  double l1 = 0;  // coupler RS
  double l2 = 0;  // slewing bar PR
  double l3 = 0;  // thigh link KP
  double l4 = 0;  // shank link KS
  double l5 = 0;  // mount M behind the thigh axis
  double l6 = 0;  // mount M above the thigh pin P

  std::array<double, 6> Values() const { return {l1, l2, l3, l4, l5, l6}; }
  static Links FromValues(const std::array<double, 6>& v) { return {v[0], v[1], v[2], v[3], v[4], v[5]}; }

  double L7() const;  // PM = hypot(l5, l6)
};

// Throws Error naming `where`, the link and its value if a length is not within 1 mm (less: metres) and 10 m.
void CheckLinks(const Links& links, std::string_view where);

// The branch: one of the four ways to close the two loops. The paper's mechanism is always kAssembled: alpha2 >= 0 and
// beta2 >= 0.
enum class Branch { kAssembled = 0, kBarFlipped = 1, kShankFlipped = 2, kBothFlipped = 3 };

// The linkage at one stroke.
struct Pose {
  double stroke_mm = 0;  // d, pin to pin
  double theta_rad = 0;  // knee angle, continuous along the branch: negative past standing (hyperextension)
  double phi_rad = 0;    // slewing bar from +y, alpha1 + alpha2
  double alpha1_rad = 0, alpha2_rad = 0;                   // at P, Eqs. (5), (6)
  double beta1_rad = 0, beta2_rad = 0;                     // at K, Eqs. (2), (3); beta1 signed and unwrapped
  double l8_mm = 0;                                        // KR, Eq. (4)
  Eigen::Vector2d knee, thigh_pin, tip, shank_pin, mount;  // K, P, R, S, M in the thigh frame, mm
  Branch branch = Branch::kAssembled;
};

// Why a linkage cannot be assembled: one of its triangles does not close.
struct AssemblyGap {
  enum class Triangle { kActuator /* l7, l2, d */, kShank /* l8, l4, l1 */ };
  Triangle triangle;
  double gap_mm;     // how much the longest side exceeds the sum of the other two
  std::string text;  // one sentence with the three sides
};

// nullopt if the linkage can be assembled at this stroke.
std::optional<AssemblyGap> FindAssemblyGap(const Links& links, double stroke_mm);

// The pose at a stroke, Eqs. (1)-(6) with the signed beta1; nullopt where it cannot be assembled.
std::optional<Pose> SolvePose(const Links& links, double stroke_mm, Branch branch = Branch::kAssembled);

// As SolvePose, but throws Error that names the stroke, the triangle and the gap.
Pose RequirePose(const Links& links, double stroke_mm);

// Transmission of motion and force in one pose.
struct Transmission {
  double radians_per_mm =
      0;  // d theta / d d; infinite where the shank is at a dead point or the actuator in line with the bar
  double moment_arm_mm = 0;          // |d d / d theta|, mm per rad: knee torque = actuator force x moment arm
  double transmission_rad = 0;       // angle RSK between coupler and shank link, 0..pi; dead points at 0 and pi
  double actuator_rad = 0;           // angle PRM between slewing bar and actuator, 0..pi; dead points at 0 and pi
  double shank_pressure_rad = 0;     // |pi/2 - transmission|: between the coupler's force and the motion of S
  double actuator_pressure_rad = 0;  // |pi/2 - actuator|: between the actuator's force and the motion of R
};
Transmission TransmissionOf(const Links& links, const Pose& pose);

// Actuator force in N, positive when it pushes, that balances a knee torque in N m, positive in extension (virtual
// work).
double ActuatorForce(const Transmission& transmission, double knee_torque_nm);

struct StrokeRange {
  double lower_mm = 0, upper_mm = 0;
  double Travel() const { return upper_mm - lower_mm; }
  bool Contains(double stroke_mm, double tolerance_mm = 1e-9) const {
    return stroke_mm >= lower_mm - tolerance_mm && stroke_mm <= upper_mm + tolerance_mm;
  }
};

// The strokes at which the assembled branch exists: none, one interval, or two with a gap that the linkage cannot
// cross.
std::vector<StrokeRange> AssemblyRanges(const Links& links);

// The strokes at which d theta / d d changes sign (P, R and S in line), on the assembled branch, ascending.
std::vector<double> TurningStrokes(const Links& links);

// All strokes (at most two) at which the assembled branch has this knee angle, ascending. Closed form: R is where the
// circles of l2 about P and of l1 about S meet.
std::vector<double> StrokesForAngle(const Links& links, double theta_rad);

// The part of the assembled branch that a design uses: from d_min until the first of d_max (if given), the knee angle
// `least_theta_rad` (standing), a turning point of theta, and the end of the assembly range. Within it theta(d) is one
// to one.
struct UsedRange {
  StrokeRange stroke;
  double theta_at_lower_rad = 0, theta_at_upper_rad = 0;
  enum class End { kDMax, kStanding, kTurning, kAssembly } end = End::kStanding;  // what ended it
};
// Throws Error if it cannot be assembled at d_min, or if d_max <= d_min.
UsedRange FindUsedRange(const Links& links, double d_min_mm, std::optional<double> d_max_mm,
                        double least_theta_rad = 0);

// The stroke within a used range that gives this knee angle; nullopt if none does.
std::optional<double> StrokeForAngle(const Links& links, const UsedRange& range, double theta_rad);

// Grashof's law for the four-bar l1..l4 with the shank link l4 as the frame, as the paper has it.
enum class GrashofClass { kCrankRocker, kDoubleCrank, kDoubleRocker, kChangePoint, kTripleRocker };
struct Grashof {
  GrashofClass type;
  double slack_mm;  // (sum of the two middle links) - (shortest + longest); negative: no link can turn fully
};
Grashof GrashofOf(const Links& links);
std::string_view NameOf(GrashofClass type);

// Distances to the singular poses, mm; all positive in a pose that is clear of them.
struct SingularityDistances {
  double actuator_folded_mm;    // l2 + d - l7: actuator and slewing bar in line, the paper's constraint
  double actuator_extended_mm;  // l7 + l2 - d
  double shank_folded_mm;       // l8 - |l4 - l1|: coupler and shank link in line, folded
  double shank_extended_mm;     // l4 + l1 - l8
};
SingularityDistances DistancesToSingularities(const Links& links, const Pose& pose);

// The forces in every member and pin of the linkage at rest, by the balance of each body: a check independent of the
// virtual work that gives the actuator's force (ActuatorForce in linkage.h).
//
// The mechanism bears a couple between shank and thigh, the knee torque; its own weight is left out, as is what the
// knee joint itself carries. Then actuator, coupler and slewing bar are loaded at their two pins alone, along the line
// between them, and shank and thigh plate each pass the couple on to the leg: the three forces on the thigh plate, at
// K, P and M, have no sum and a moment equal to the torque.

// Forces in N. Along a member they are positive when it pushes its pins apart, as the actuator's is; infinite at a dead
// point.
struct MemberForces {
  double actuator_n = 0;  // M to R
  double coupler_n = 0;   // R to S
  double bar_n = 0;       // P to R

  // The force on each pin, never negative: the coupler's at K and S, the bar's at P, the actuator's at M (the mount on
  // the thigh); at the tip R, where three members meet, the largest of their forces.
  double KneePin() const { return std::abs(coupler_n); }
  double ThighPin() const { return std::abs(bar_n); }
  double TipPin() const { return std::max({std::abs(actuator_n), std::abs(coupler_n), std::abs(bar_n)}); }
  double ShankPin() const { return std::abs(coupler_n); }
  double Mount() const { return std::abs(actuator_n); }
};

// At a knee torque in N m, positive in extension.
MemberForces MemberForcesOf(const Pose& pose, double knee_torque_nm);

}  // namespace lake::linkage
