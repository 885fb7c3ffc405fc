// What comes of a redesign: its optimum, what that costs, before and after, Pareto fronts, or why there is none.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lake/certificate/certificate.h"
#include "lake/compare/misalignment.h"
#include "lake/core/run.h"
#include "lake/cuffs/cuff_course.h"
#include "lake/problem/robustness.h"
#include "lake/redesign/redesign.h"
#include "lake/synthesis/synthesis_outcome.h"

namespace lake::redesign {

// What the redesign starts from.
struct MeasuredMotion {
  compare::StsCurve human;
  gait::MovementKind movement = gait::MovementKind::kSitToStand;  // or kWalking
  std::optional<compare::StsCurve> exo{};                         // of the trial with an exoskeleton
  std::vector<bool> spike{};                                      // per percent of both; empty: none
  double noise_floor_percent = 0;                                 // of their comparison, RMS; 0: not known
  double joint_sd_mm = 0;                                         // of the joint's place against the knee
  std::optional<linkage::Design> worn{};  // in that trial; without a program it was moved by the leg
  std::string worn_file{};                // for messages
};

// As a synthesis, but for the rounding: rounded links would have another misalignment.
struct RedesignOptions : synthesis::SynthesisOptions {
  std::optional<int> pareto_points;  // absent: no fronts
  double short_program_s = 20;       // of the free program whose front stands beside the others: too short for exact
                                     // tracking by nearly every linkage at 5 mm/s

  void Check() const;  // throws UsageError
};

// A design in the human's motion.
struct DesignInMotion {
  linkage::Design design;
  problem::DesignEvaluation evaluation;
  std::optional<Prediction> prediction;               // absent: it cannot make the motion
  std::optional<compare::Misalignment> misalignment;  // of the predicted path, by the code of lake-compare
  std::optional<double> tracking_time_s;              // T*
  std::optional<double> tracked_share;                // of the human's motion in its own time, by the greatest speed
  double duration_s = 0;                              // of its program
};

// NaN if the design cannot make the motion.
double ValueOf(const Quantity& quantity, const DesignInMotion& design);

// The person leaning otherwise than in their trial by `lean`.
DesignInMotion PutInMotion(const RedesignProblem& problem, const compare::StsCurve& human,
                           const linkage::Design& design, const Lean& lean = {});

// What the cuffs do to the leg in this motion, which bends as the exoskeleton does; absent if it cannot be made.
std::optional<cuffs::CuffCourse> CuffsOf(const RedesignProblem& problem, const DesignInMotion& design,
                                         double joint_sd_mm);

// Where the joint of a design has the least misalignment, its links and program kept: within the reach of the knee.
// Absent if it cannot make the motion. In each sample a move adds the same vector, turned, to the difference of both
// knees, so that their mean square is that at the optimum and the square of the way there, weighted alike.
std::optional<Eigen::Vector2d> BestPlacement(const RedesignProblem& problem, const DesignInMotion& design);

// A change of the problem that was tried where a limit cannot be held.
struct WayOut {
  std::string text;                    // "a free program of at least 24 s at 5 mm/s"
  bool enough = false;                 // holds the limit
  std::optional<double> best{};        // value of the quantity that it reaches, if that is what was sought
  std::optional<double> duration_s{};  // rounded up, with which the problem was solved, likewise
};

// Why there is no solution: the first quantity whose limit no design holds, under those limits that can be held.
struct Infeasibility {
  bool within_reach = false;           // the limits can be held after all; the solver did not get there
  const Quantity* quantity = nullptr;  // nullptr: the linkage cannot make the motion, or not in the time
  std::optional<double> best;          // its best value found under the given program
  std::optional<double> working;       // a rounded limit a little beyond, with which the problem was solved
  // Limits that hold it there; multiplier: by how much the quantity gets better per unit that the limit is raised; NaN
  // where multipliers are not unique.
  std::vector<synthesis::ActiveSet::Entry> blocking;
  std::vector<WayOut> ways;
  RedesignPoint nearest;
  std::string sentence;
};

struct NamedFront {
  std::string name;  // "constant", "free 25 s"
  ProgramLimits program;
  std::vector<ParetoPoint> points;
  // With a load profile, that its points were sought under: of the design where the program is the same, else of the
  // front's largest range. Off by the most along the program of a point.
  std::optional<MomentsOfProgram> moments{};
};

struct RedesignOutcome {
  RedesignProblem problem;
  RedesignOptions options;
  MeasuredMotion measured;
  std::optional<MountSlip> slip;             // absent: delta is zero
  std::optional<double> measured_percent;    // RMS misalignment of the exo trial itself
  std::optional<double> worn_angle_off_deg;  // RMS, the worn design's program against its trial's own knee angles
  std::optional<MomentsOfProgram> moments;   // with a load profile; the problem above has those, and the worn and the
                                             // repaired designs are evaluated under their own programs'
  RedesignResult result;
  std::optional<PlacementRange> placement_range;  // of the design, if its placement is fitted
  std::optional<double> range_at_knee_deg;        // likewise: the range with the joint at the knee; absent: none found
  std::optional<Infeasibility> infeasible;        // if no start is usable
  DesignInMotion before;                          // the worn design, or the problem's start under a constant program
  DesignInMotion after;  // the optimum, of equals that with the joint nearest to the knee, or the design of the
                         // smallest misalignment found
  Lean lean;             // of the person in `after`
  std::optional<DesignInMotion> without_balance;            // the optimum without that requirement: what balance costs
  std::optional<MomentsOfProgram> moments_without_balance;  // that it was sought under, with a load profile
  // Cheaper repairs of the worn design; absent without one.
  std::optional<DesignInMotion> joint_moved;    // same links and program: the joint on the knee, as its trial shows it
  std::optional<DesignInMotion> other_program;  // same links and joint: the program with the least misalignment, its
                                                // kind, speed and time as for the new design
  synthesis::ActiveSet active;
  std::optional<double> widest_deg;                     // the largest range found without the human
  std::optional<certificate::Certificate> certificate;  // of that range
  std::optional<problem::Yield> yield;
  std::vector<NamedFront> fronts;

  bool IsSolved() const { return result.IsSolved(); }
};

// The problem with the measured motion, delta if a worn design is known, and how the exoskeleton trial agrees with it;
// nothing is solved. Throws as RunRedesign.
RedesignOutcome PutMotionInto(RedesignProblem problem, const MeasuredMotion& measured);

// The human's motion of the problem is set here: from the measured curves, with delta if a worn design is known. Throws
// Error for input that cannot be used, which a worn design is that leaves most of its trial's joint unexplained,
// UsageError for options, Interrupted on a signal.
RedesignOutcome RunRedesign(RedesignProblem problem, const MeasuredMotion& measured, const RedesignOptions& options);

// Why no start was usable. `links` to start from.
Infeasibility ExplainInfeasible(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                                const synthesis::OptimizeOptions& options);

}  // namespace lake::redesign
