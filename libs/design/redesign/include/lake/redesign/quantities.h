// The list of quantities that a redesign limits, weighs or seeks in the motion. A row says what the quantity is and is
// all that it needs: options, the nonlinear program, checks of a solution, goals, tables and the explanation of what
// cannot be held go through the list.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "lake/core/numbers.h"
#include "lake/redesign/redesign_problem.h"

namespace lake::redesign {

struct Quantity {
  // Where the limit of a quantity is in a problem: among its own, or its program's.
  class LimitPlace {
   public:
    constexpr LimitPlace(std::optional<double> MotionLimits::*limit) : own_(limit) {}
    constexpr LimitPlace(std::optional<double> ProgramLimits::*limit) : of_program_(limit) {}

    template <typename Limits>
    auto& operator()(Limits& limits) const {
      return own_ ? limits.*own_ : limits.program.*of_program_;
    }

   private:
    std::optional<double> MotionLimits::*own_ = nullptr;
    std::optional<double> ProgramLimits::*of_program_ = nullptr;
  };

  std::string_view name;    // of its limit, unique: "cuff force"
  std::string_view column;  // in before_after.csv: "cuff_force_max"
  const char* unit;
  RedesignProblem::Goal goal;  // that seeks its best value
  bool is_lower = false;       // its limit is the least that is allowed
  LimitPlace limit;
  double (*value)(const Prediction&);  // NaN where it is not known
  // In the objective of the range: deg per unit of `weighed`.
  double MotionLimits::*weight = nullptr;
  double (*weighed)(const Prediction&) = nullptr;
  const char* weight_option = "";
  const char* option;  // "max-cuff-force"; of the duration it is the stroke program's
  const char* help = "";
  const char* option_unit = "";
  const char* otherwise = "no limit";
  const char* key = "";       // of the limit in summary.json; empty: it stands with the program or the balance
  const char* best_key = "";  // there, of the best that was found where the limit cannot be held
  const char* none = "";      // what is said then, of the limit

  // Within what a solver leaves of a limit.
  bool Holds(double value, double limit_value) const {
    constexpr double kRelative = 1e-5, kMargin = 0.01;  // of a margin, which may be 0
    return is_lower ? value >= limit_value - kMargin : value <= limit_value * (1 + kRelative);
  }
  // Larger is better.
  double Merit(double of_value) const { return is_lower ? of_value : -of_value; }
  // Limited or weighed.
  bool Counts(const MotionLimits& limits) const { return limit(limits) || (weight && limits.*weight > 0); }
};

inline constexpr std::array kQuantities = {
    Quantity{.name = "misalignment",
             .column = "misalignment",
             .unit = "%",
             .goal = RedesignProblem::Goal::kMisalignment,
             .limit = &MotionLimits::max_misalignment_percent,
             .value = [](const Prediction& of) { return 100 * of.Rms().relative; },
             .weight = &MotionLimits::penalty_deg_per_mm,
             .weighed = [](const Prediction& of) { return of.Rms().mm; },
             .weight_option = "penalty",
             .option = "max-misalignment",
             .help = "Largest misalignment allowed, RMS relative to the shank length",
             .option_unit = "percent",
             .key = "max_misalignment_percent",
             .best_key = "smallest_misalignment_percent",
             .none = "no design has a misalignment of at most {} %"},
    Quantity{.name = "angle mismatch",
             .column = "angle_mismatch_max",
             .unit = "deg",
             .goal = RedesignProblem::Goal::kAngle,
             .limit = &MotionLimits::max_angle_mismatch_deg,
             .value = [](const Prediction& of) { return of.angle_mismatch_deg; },
             .option = "max-angle-mismatch",
             .help = "Largest difference of the exoskeleton's knee angle from the human's at any instant",
             .option_unit = "degrees",
             .otherwise = "5 with --misalignment joint and of walking, else no limit",
             .key = "max_angle_mismatch_deg",
             .best_key = "least_angle_mismatch_deg",
             .none = "no design keeps its knee angle within {}° of the human's at every instant"},
    Quantity{.name = "cuff force",
             .column = "cuff_force_max",
             .unit = "N",
             .goal = RedesignProblem::Goal::kCuffForce,
             .limit = &MotionLimits::max_cuff_force_n,
             .value = [](const Prediction& of) { return of.cuff_force_n; },
             .weight = &MotionLimits::cuff_penalty_deg_per_n,
             .weighed = [](const Prediction& of) { return of.cuff_force_n; },
             .weight_option = "cuff-penalty",
             .option = "max-cuff-force",
             .help = "Largest force at a cuff over the rise, of the joint's misfit, where cuffs and flesh are stiffest",
             .option_unit = "N",
             .key = "max_cuff_force_n",
             .best_key = "least_cuff_force_n",
             .none = "no design keeps the force at each cuff within {} N where cuffs and flesh are stiffest"},
    Quantity{.name = "balance margin",
             .column = "balance_margin",
             .unit = "mm",
             .goal = RedesignProblem::Goal::kBalance,
             .is_lower = true,
             .limit = &MotionLimits::balance_mm,
             .value = [](const Prediction& of) { return of.balance ? of.balance->margin_mm : kNaN; },
             .option = "balance",
             .help = "Centre of pressure at least so far inside the foot once the seat is left; the person may lean "
                     "otherwise; needs --body",
             .option_unit = "mm",
             .otherwise = "balance is not asked for",
             .best_key = "largest_balance_margin_mm",
             .none = "no program keeps the centre of pressure {} mm inside the foot"},
    Quantity{.name = "duration",
             .column = "program_duration",
             .unit = "s",
             .goal = RedesignProblem::Goal::kDuration,
             .limit = &ProgramLimits::duration_s,
             .value = [](const Prediction& of) { return of.exo.duration_s; },
             .option = "duration",
             .option_unit = "s",
             .none = "no design stands up within {} s"}};

inline constexpr const Quantity &kMisalignment = kQuantities[0], &kAngleMismatch = kQuantities[1],
                                &kCuffForce = kQuantities[2], &kBalanceMargin = kQuantities[3],
                                &kDuration = kQuantities[4];

}  // namespace lake::redesign
