// The list of limits on a design. A row says what is limited and is all that a limit needs: options, problem files,
// evaluation, nonlinear program, certificate, yield and the explanation of infeasibility go through the list.
//
// A limit on the links alone is linear in them, but for the actuator's singularity. Any other is on the worst of one or
// several ratios over / under in a pose, under >= 0, so that
//   at least:  over - limit under >= 0        at most:  limit under - over >= 0
// are smooth where the ratio itself is infinite. They are functions of a pose's quantities (pose_quantities.h) in
// numbers of any kind: double, numbers with derivatives, slopes over a box of links.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <tuple>
#include <vector>

#include "lake/core/numbers.h"
#include "lake/parts/strength.h"
#include "lake/problem/linear_actuator.h"
#include "lake/problem/pose_quantities.h"

namespace lake::problem {

struct SynthesisProblem;

// Where a limit holds.
enum class Place {
  kLinks,      // on the links alone
  kShortest,   // at d_min
  kStanding,   // at standing_deg
  kSeated,     // at SynthesisProblem::SeatedAngle_rad(), which the range then must reach
  kUsedRange,  // from d_min to standing
  kLoaded,     // the same, or where there is a load profile at its samples
  kAtRest,     // as kLoaded, but of the profile the last sample alone, unless the actuator rests anywhere
  kProfile     // at the samples of the load profile
};

// What a part of the linkage is kept away from (linkage/wear.h).
enum class Obstacle { kNone, kSeat, kThigh, kShank };

struct LimitInfo {
  const char* name;  // in tables, unique: "force"
  const char* unit;  // "1": none
  bool is_lower = true;
  Place place = Place::kUsedRange;
  bool is_relative = false;  // a solver may move it by percents, not by millimetres or degrees
  bool is_sine = false;      // the ratio is the sine of a limit in degrees
  Obstacle obstacle = Obstacle::kNone;
  std::array<double, 6> coefficients{};  // of the links, where it is on those alone and linear
  // Of limits that a problem has in SynthesisProblem::limits: key of its file and the map that holds it there, option,
  // what the option's help says and its unit, an example, and what the limit must be below.
  const char* key = "";
  const char* section = "";
  const char* option = "";
  const char* help = "";
  const char* option_unit = "";
  double example = 0;
  double below = kInfinity;
};

// What a pose has to bear.
struct PoseLoad {
  double torque_nmm = 0;         // that the linkage balances, positive in extension
  double rad_per_rise = 0;       // of the knee at a sample of the load profile
  double closed_error_mm = 0;    // by which a build's actuator is longer than asked for
  parts::Capacity capacity{};    // of the parts
  std::vector<SpeedLine> speed;  // of the actuator
};

// `value`: nullptr, or from a problem the limit, where that is no entry of SynthesisProblem::limits. `parts(load, add)`
// calls add(name, ratio of a pose's quantities) for each of the ratios.
template <typename Value, typename Parts>
struct LimitRow {
  LimitInfo info;
  Value value;
  Parts parts;
};
template <typename Value, typename Parts>
LimitRow(LimitInfo, Value, Parts) -> LimitRow<Value, Parts>;

// Not judged by ratios.
inline constexpr auto kNoParts = [](const PoseLoad&, auto&&) {};

// |force of the actuator| = |torque| / moment arm.
inline constexpr auto kActuatorForce = [](const PoseLoad& load, auto&& add) {
  add("actuator",
      [torque = std::abs(load.torque_nmm)](const auto& pose) { return torque * Inverse(pose.MomentArm()); });
};

inline constexpr auto kRangeAngle = [](const PoseLoad&, auto&& add) {
  add("knee", [](const auto& pose) { return OverOne(pose.Theta_deg()); });
};

// One link is no longer than another.
constexpr auto OrderOf(const char* name, std::size_t smaller, std::size_t larger) {
  LimitInfo info{.name = name, .unit = "mm", .place = Place::kLinks};
  info.coefficients[smaller] = -1;
  info.coefficients[larger] = 1;
  return LimitRow{info, [](const auto&) { return std::optional(0.0); }, kNoParts};
}

inline constexpr std::tuple kLimits{
    LimitRow{{.name = "grashof", .unit = "mm", .place = Place::kLinks, .coefficients = {1, 1, -1, -1, 0, 0}},
             [](const auto& problem) { return std::optional(problem.grashof_margin_mm); },
             kNoParts},
    OrderOf("l3 ≤ l1", 2, 0),
    OrderOf("l3 ≤ l2", 2, 1),
    OrderOf("l3 ≤ l4", 2, 3),
    OrderOf("l2 ≤ l4", 1, 3),
    OrderOf("l1 ≤ l4", 0, 3),
    OrderOf("l5 ≤ l6", 4, 5),
    OrderOf("l4 ≤ l6", 3, 5),
    LimitRow{{.name = "singularity", .unit = "mm", .place = Place::kLinks},  // l2 + d_min - l7
             [](const auto& problem) { return std::optional(problem.singularity_margin_mm); },
             kNoParts},
    LimitRow{{.name = "moment arm",
              .unit = "mm",
              .key = "min_moment_arm_mm",
              .option = "min-moment-arm",
              .help = "Smallest moment arm over the used range",
              .option_unit = "mm per rad",
              .example = 5},
             nullptr,
             [](const PoseLoad&, auto&& add) { add("knee", [](const auto& pose) { return pose.MomentArm(); }); }},
    LimitRow{{.name = "force",
              .unit = "N",
              .is_lower = false,
              .place = Place::kLoaded,
              .is_relative = true,
              .key = "max_force_n",
              .section = "load",
              .option = "max-force",
              .help = "Largest actuator force over the used range",
              .option_unit = "N",
              .example = 2000},
             nullptr,
             kActuatorForce},
    LimitRow{{.name = "pin force",
              .unit = "N",
              .is_lower = false,
              .place = Place::kLoaded,
              .is_relative = true,
              .key = "max_pin_force_n",
              .section = "load",
              .option = "max-pin-force",
              .help = "Largest force in a pin, at K, P, R and S",
              .option_unit = "N",
              .example = 4000},
             nullptr,
             [](const PoseLoad& load, auto&& add) {  // at the tip R, where the three members meet
               const double torque = std::abs(load.torque_nmm);
               add("coupler", [torque](const auto& pose) { return torque * pose.CouplerForce(); });
               for (const double side : {torque, -torque})
                 add("slewing bar", [side](const auto& pose) { return side * pose.BarForce(); });
               kActuatorForce(load, add);
             }},
    LimitRow{{.name = "mount force",
              .unit = "N",
              .is_lower = false,
              .place = Place::kLoaded,
              .is_relative = true,
              .key = "max_mount_force_n",
              .section = "load",
              .option = "max-mount-force",
              .help = "Largest force of the mount on the thigh, at M",
              .option_unit = "N",
              .example = 3000},
             nullptr,
             kActuatorForce},
    LimitRow{{.name = "safety factor",
              .unit = "1",
              .place = Place::kLoaded,
              .is_relative = true,
              .key = "safety_factor",
              .section = "load",
              .option = "safety-factor",
              .help = "Least safety factor of plates, pins and the actuator's rod, as strength.csv",
              .example = 1.5},
             nullptr,
             [](const PoseLoad& load, auto&& add) {  // what is borne over what is there, as parts::CheckStrength
               const parts::Capacity& bears = load.capacity;
               const double torque = std::abs(load.torque_nmm);
               if (torque == 0) return;
               const double coupler = torque / bears.coupler_n, bar = torque / bears.bar_n;
               add("coupler", [coupler](const auto& pose) { return Inverse(coupler * pose.CouplerForce()); });
               for (const double side : {bar, -bar})
                 add("slewing bar", [side](const auto& pose) { return Inverse(side * pose.BarForce()); });
               const double actuator = torque / bears.actuator_n, rod = torque / bears.rod_nmm2;
               add("actuator", [actuator](const auto& pose) { return Under(pose.MomentArm(), actuator); });
               if (load.torque_nmm > 0)  // then the rod pushes, and may buckle
                 add("rod", [rod](const auto& pose) {
                   return Under(pose.MomentArm(), rod * (pose.Stroke_mm() * pose.Stroke_mm()));
                 });
               // Whatever the links: without a solution it is what has to give way.
               const double shank = bears.knee_torque_nm * kMillimetresPerMetre / torque;
               add("shank link", [shank](const auto& pose) { return OverOne(pose.Constant(shank)); });
             }},
    LimitRow{
        {.name = "transmission angle",
         .unit = "deg",
         .is_sine = true,
         .key = "min_transmission_deg",
         .option = "min-transmission",
         .help = "Smallest transmission angle between coupler and shank link over the used range",
         .option_unit = "degrees",
         .example = 10,
         .below = 90},
        nullptr,
        [](const PoseLoad&, auto&& add) { add("coupler", [](const auto& pose) { return pose.TransmissionSine(); }); }},
    LimitRow{{.name = "stroke when standing",
              .unit = "mm",
              .is_lower = false,
              .place = Place::kStanding,
              .key = "d_max_mm",
              .option = "max-length",
              .help = "Longest stroke of the actuator; the knee must be straight by then",
              .option_unit = "mm",
              .example = 400},
             nullptr,
             [](const PoseLoad& load, auto&& add) {  // an actuator that is longer at its shortest is so at its longest
               add("actuator",
                   [off = load.closed_error_mm](const auto& pose) { return OverOne(pose.Stroke_mm() - off); });
             }},
    LimitRow{{.name = "length when sitting",
              .unit = "mm",
              .is_lower = false,
              .place = Place::kSeated,
              .key = "max_seated_length_mm",
              .option = "max-seated-length",
              .help = "Largest length of the actuator, the knee bent by 90 degrees",
              .option_unit = "mm",
              .example = 300},
             nullptr,
             [](const PoseLoad&, auto&& add) {
               add("actuator", [](const auto& pose) { return OverOne(pose.Stroke_mm()); });
             }},
    LimitRow{{.name = "holding force", .unit = "N", .is_lower = false, .place = Place::kAtRest, .is_relative = true},
             [](const auto& problem) {
               return problem.actuator ? problem.actuator->holding_force_n : std::optional<double>();
             },
             kActuatorForce},
    LimitRow{{.name = "duration", .unit = "s", .is_lower = false, .place = Place::kProfile, .is_relative = true},
             [](const auto& problem) { return problem.DurationLimit_s(); },
             [](const PoseLoad& load, auto&& add) {
               // With r the moment arm: r |rad_per_rise| / (at_rest - per_newton torque / r), by each line of the
               // speed.
               const double rad = std::abs(load.rad_per_rise), torque = std::abs(load.torque_nmm);
               for (const SpeedLine& line : load.speed)
                 add("actuator", [line, rad, torque](const auto& pose) {
                   constexpr double kArm_mm = 50;  // usual
                   const auto arm = pose.MomentArm();
                   const double scale = 1 / (kArm_mm * line.at_rest_mm_s);
                   return Ratio{(rad * scale) * (arm.over * arm.over),
                                arm.under * ((line.at_rest_mm_s * scale) * arm.over -
                                             (line.per_newton_mm_s * torque * scale) * arm.under)};
                 });
             }},
    LimitRow{{.name = "range", .unit = "deg", .place = Place::kShortest},
             [](const auto& problem) { return problem.LeastRange_deg(); },
             kRangeAngle},
    LimitRow{{.name = "seat clearance", .unit = "mm", .place = Place::kSeated, .obstacle = Obstacle::kSeat},
             [](const auto& problem) { return problem.clearances.seat_mm; },
             kNoParts},
    LimitRow{{.name = "thigh clearance", .unit = "mm", .obstacle = Obstacle::kThigh},
             [](const auto& problem) { return problem.clearances.thigh_mm; },
             kNoParts},
    LimitRow{{.name = "shank clearance", .unit = "mm", .obstacle = Obstacle::kShank},
             [](const auto& problem) { return problem.clearances.shank_mm; },
             kNoParts},
    LimitRow{{.name = "angle",
              .unit = "deg",
              .is_lower = false,
              .place = Place::kShortest,
              .key = "max_angle_deg",
              .option = "max-angle",
              .help = "Anatomical cap on the knee angle",
              .option_unit = "degrees",
              .example = 140},
             nullptr,
             kRangeAngle}};

inline constexpr std::size_t kLimitCount = std::tuple_size_v<decltype(kLimits)>;
inline constexpr std::array<LimitInfo, kLimitCount> kLimitInfos =
    std::apply([](const auto&... rows) { return std::array{rows.info...}; }, kLimits);

// The row of the limit of this name.
consteval std::size_t RowOf(std::string_view name) {
  std::size_t row = 0;
  while (name != kLimitInfos[row].name) ++row;
  return row;
}

// Calls visit(row) for the row with this index.
template <typename Visit>
void VisitLimit(std::size_t index, const Visit& visit) {
  std::apply(
      [&](const auto&... rows) {
        std::size_t i = 0;
        ((i++ == index ? visit(rows) : void()), ...);
      },
      kLimits);
}

// The limits that a problem asks for by a number of its own, by the key of its file; absent: not asked for.
class LimitValues {
 public:
  // Throws std::logic_error for a key that no row has.
  std::optional<double>& operator[](std::string_view key) { return values_[IndexOf(key)]; }
  const std::optional<double>& operator[](std::string_view key) const { return values_[IndexOf(key)]; }
  bool operator==(const LimitValues&) const = default;

 private:
  static std::size_t IndexOf(std::string_view key);
  std::array<std::optional<double>, kLimitCount> values_{};
};

}  // namespace lake::problem
