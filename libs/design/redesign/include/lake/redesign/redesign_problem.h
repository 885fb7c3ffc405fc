// A redesign as data: a synthesis problem, the human's motion, and how far the exoskeleton's knee may be off.
//
//   max  RoR - w RMS(|e - h|) - w_f F          X = links, p = placement, d(s) = stroke program, lean(s)
//   s.t. RMS(|e - h| / L) <= limit,  every requirement and bound of the synthesis problem,
//        |dd/dt| <= max_speed, total time <= duration, |p_x|, |p_y| <= reach about the knee,
//        largest force at a cuff F <= limit (cuffs/cuff_course.h: of the misfit, where cuffs and flesh are stiffest),
//        max |theta - theta_human| <= limit,  centre of pressure at least a margin inside the foot (balance.h)
//
// e(s) is predicted by human_motion.h, the error is the comparison's own (compare/pointwise_error.h); of the joint
// itself p + delta stands for e - h.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/core/numbers.h"
#include "lake/cuffs/cuff_model.h"
#include "lake/problem/problem.h"
#include "lake/redesign/balance.h"
#include "lake/redesign/human_motion.h"

namespace lake::redesign {

struct ProgramLimits {
  // constant: linear from the human's first knee angle (at least d_min) to the last; free: knots at equal steps of
  // time.
  linkage::StrokeProgram::Kind kind = linkage::StrokeProgram::Kind::kConstant;
  double max_speed_mm_s = 5;         // the paper's actuator
  std::optional<double> duration_s;  // of one sit-to-stand, at most; absent: no limit
  bool free_ends = false;            // constant: its ends are sought too; not: at the human's first and last knee angle
  bool monotone = false;             // free: the stroke may not turn back where the human's knee does
  bool cyclic = false;               // of walking: free, and it ends where it begins
  int knots = 21;                    // free: every 5 % of the motion
};
void Describe(ProgramLimits& o, OptionList& options);

// What is asked of a design in anybody's motion; each limit is on a quantity of kQuantities.
struct MotionLimits {
  ProgramLimits program;
  MisalignmentOf misalignment_of = MisalignmentOf::kPath;  // what limit and penalty are on
  std::optional<double> max_misalignment_percent;          // RMS, of the shank length
  double penalty_deg_per_mm = 0;                           // w
  bool fit_placement = false;
  double placement_reach_mm = 40;                // from the knee to either side, x and y, if it is fitted
  std::optional<double> max_angle_mismatch_deg;  // of the exoskeleton's knee angle, at every instant
  cuffs::CuffOptions cuffs;                      // that hold the exoskeleton to the leg
  std::optional<double> max_cuff_force_n;        // at the stiffest, over the motion
  double cuff_penalty_deg_per_n = 0;             // w_f; of one person
  std::optional<double> balance_mm;  // the centre of pressure at least so far inside the foot, once that bears the body
};

struct RedesignProblem : MotionLimits {
  problem::SynthesisProblem design;
  HumanMotion human;
  Eigen::Vector2d placement_mm = Eigen::Vector2d::Zero();  // where the joint sits; if it is fitted, a start
  std::shared_ptr<const loads::BodyPath> body;             // the person's, in the same motion; empty: not known
  LeanLimits lean_limits;                                  // where balance is asked for, which needs the body

  // What is sought. The other goals make Pareto fronts and explain what cannot be had.
  enum class Goal {
    kRange,         // RoR - w RMS
    kMisalignment,  // least RMS misalignment; no penalty
    kDuration,      // shortest sit-to-stand
    kNearest,       // least |p|: the joint nearest to the knee
    kBalance,       // largest margin of the centre of pressure inside the foot; needs `balance_mm`
    kCuffForce,     // least of the largest force at a cuff
    kAngle,         // least of the knee angle's largest difference from the human's
    kFarthest       // largest `farthest` . p
  } goal = Goal::kRange;
  std::optional<double> min_range_deg;
  Eigen::Vector2d farthest = Eigen::Vector2d::Zero();

  DrivenLinks Driven(const linkage::Links& links) const { return {links, design.d_min_mm, design.standing_deg}; }
  problem::Bounds PlacementBounds(int axis) const;  // both the same where it is not fitted

  // The synthesis problem with its clearances at a placement, free where it is fitted.
  problem::SynthesisProblem DesignAt(const Eigen::Vector2d& placement) const;

  // Throws UsageError naming the option; the motion is not looked at.
  void CheckOptions() const;
  // Throws also Error for the synthesis problem and the motion.
  void Check() const;
};

// The list of quantities that a redesign limits, weighs or seeks in the motion. A row says what the quantity is and is
// all that it needs: options, the nonlinear program, checks of a solution, goals, tables and the explanation of what
// cannot be held go through the list.

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

// One linkage for several people: the links are common, placement and stroke program are each person's own.
//
//   max  RoR - w M(|e_i - h_i|)                X = links; p_i, d_i(s) of each person i
//   s.t. M(|e_i - h_i| / L_i) <= limit,  and for each person what a redesign asks
//
// M is the largest RMS of those who count, or the mean RMS of all. With one person it is the redesign.

// Of people's misalignments, which one limit, penalty and goal are on. Of the quantile it is the worst of those who
// count, and who counts is sought (group.h).
enum class Across { kWorst, kMean, kQuantile };

struct Subject {
  std::string name;  // empty: one person alone
  HumanMotion human;
  Eigen::Vector2d placement_mm = Eigen::Vector2d::Zero();  // where the joint sits; if it is fitted, a start
  bool counts = true;                                      // not: the quantile leaves this person out
};

struct GroupProblem {
  RedesignProblem shared;  // all but the motion and the placement
  std::vector<Subject> people;
  Across across = Across::kWorst;
  double quantile = 0.9;  // part of the people whose misalignment counts

  static GroupProblem OfOne(const RedesignProblem& problem);
  RedesignProblem Of(std::size_t person) const;

  // How many of the people the quantile holds for; all where it is not asked for.
  std::size_t Counting() const;
  // Of one figure of each person: the mean, or the largest of those who count.
  double Combine(const std::vector<double>& of_people) const;

  // Throw as RedesignProblem's; UsageError also for a quantile that is not within 0 .. 1.
  void CheckOptions() const;
  void Check() const;
};

// The same problem with these links, within what a machinist holds: wide enough for an interior point to move in.
RedesignProblem WithLinks(RedesignProblem problem, const linkage::Links& links);

// "placement_x", "placement_y"; "constant", "free".
const char* PlacementName(int axis);
std::string ProgramName(linkage::StrokeProgram::Kind kind);

// What a solve varies.
struct RedesignPoint {
  linkage::Links links;
  std::vector<double> knots_mm;  // at equal steps of percent; two for a constant program
  Eigen::Vector2d placement_mm = Eigen::Vector2d::Zero();
  double duration_s = 0;
  Lean lean;  // with balance only

  // The stroke at a percent: linear between knots.
  double StrokeAt(double percent) const;
};

// From one process to another.
void to_json(nlohmann::json& json, const RedesignPoint& point);
void from_json(const nlohmann::json& json, RedesignPoint& point);

// Between which knots a percent lies, and where: 0 at the first, 1 at the second.
struct KnotSpan {
  std::size_t from = 0;
  double weight = 0;
};
KnotSpan SpanOf(std::size_t knots, double percent);

// Links with the program that follows the human as well as its kind can, and the problem's placement; a plausible
// program for links that cannot be assembled.
RedesignPoint StartPoint(const RedesignProblem& problem, const linkage::Links& links);

// What a rise takes: what the knots need at the greatest speed, or longer where balance asks for that. A stride takes
// the problem's duration, if that is enough.
double DurationOf(const RedesignProblem& problem, const RedesignPoint& point);

// A point as other programs read it; a constant program with ends of its own as two knots. The lean is the person's,
// and not in it.
linkage::Design DesignOf(const RedesignProblem& problem, const RedesignPoint& point);

// What a prediction has besides its path: forces at the cuffs and, of a known body that rises in a time, balance.
void Complete(const RedesignProblem& problem, const Eigen::Vector2d& placement_mm, const Lean& lean, double duration_s,
              Prediction& prediction);

// The point's path by the closed form; nullopt if it cannot make the motion.
std::optional<Prediction> PredictPoint(const RedesignProblem& problem, const RedesignPoint& point);

}  // namespace lake::redesign
