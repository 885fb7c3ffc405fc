// What a redesign adds to the nonlinear program of a synthesis problem (synthesis_program.h), for each person:
//
//   for s = 0..100 %, d(s) linear between the knots d_k:
//        |R - M|^2 = d(s)^2, |R - S|^2 = l1^2, alpha2 >= 0, beta2 >= 0     its own phi(s), theta(s) >= standing
//   -v T / (K - 1) <= d_k+1 - d_k <= v T / (K - 1),  0 <= T <= duration    speed
//   m := mean (100 |e - h| / L)^2 <= limit^2                               in (percent)^2
//   mean |e - h|^2 <= r^2,  r >= 1 um                                      if there is a penalty, cost + w r
//   +-(theta(s) - theta_human(s)) <= a,  a <= limit                        if the knee angle has a limit
//   |F(s)|^2 <= f^2 at each cuff,  f >= 1 mN,  f <= limit              if the cuffs' forces count, cost + w_f f
//   balance: lean(s) of leg and trunk within its limits, centre of pressure c(s) as a variable,
//     M(s) = c(s) F(s) of the ground,  -heel + b <= c(s) <= toe - b,  b >= margin       on the feet (balance.h)
//     |hip's height - the human's| <= 20 mm                                             on the seat
//   constant: K = 2, theta(0) = the human's and d_0 >= d_min, or d_0 = d_min and theta(0) <= the human's;
//             theta(100) = the human's, at least standing; with free ends neither is asked for
//
// People have nothing but the links in common: in blocks of their own the Jacobian and the Hessian are bordered block
// diagonal, and grow with the number of people. Of the worst there is one r; of the mean each has an r, and the limit
// is on the mean of such roots of m.
//
// Small costs decide where nothing else does: on misalignment (range is sought), on range (misalignment is sought), on
// placement, on time, and on leaning otherwise than the person did.
#pragma once

#include "lake/redesign/redesign_problem.h"
#include "lake/synthesis/optimize.h"

namespace lake::redesign {

// Where a constant program starts; max(d(theta_human(0)), d_min) has a corner, and each side of it is smooth.
enum class ConstantStart { kAtHumanAngle, kAtShortestStroke };

// Indices in the program, of one person.
struct RedesignVariables {
  synthesis::LinkVariables links{};
  std::vector<int> knots;
  std::array<int, 2> placement{};
  int duration = -1;
  std::vector<int> theta;                 // per percent
  int margin = -1;                        // with balance: how far the centre of pressure is inside the foot …
  std::vector<int> leg_lean, trunk_lean;  // … and per percent, against the human's
  int misalignment_row = -1;              // what bounds this person's misalignment; -1: nothing does
};

// Builds the program of a redesign for the poses of each exchange step, from the point where the last one ended.
class RedesignBuilder : public synthesis::ProgramBuilder {
 public:
  // One point and side for each person; all points have the same links.
  RedesignBuilder(const GroupProblem& problem, std::vector<RedesignPoint> start,
                  std::vector<ConstantStart> constant_start);
  RedesignBuilder(const RedesignProblem& problem, const RedesignPoint& start, ConstantStart constant_start)
      : RedesignBuilder(GroupProblem::OfOne(problem), {start}, {constant_start}) {}

  synthesis::SynthesisProgram Build(const synthesis::Collocation& poses) override;
  void MoveTo(const std::vector<double>& x) override;
  const linkage::Links& Links() const override { return points_.front().links; }
  const RedesignPoint& Point() const { return points_.front(); }
  const std::vector<RedesignPoint>& Points() const { return points_; }
  // Of the last program, per person.
  const std::vector<RedesignVariables>& Variables() const { return variables_; }

 private:
  const GroupProblem problem_;
  std::vector<RedesignProblem> people_;
  const std::vector<ConstantStart> constant_start_;
  std::vector<RedesignPoint> points_;
  std::vector<RedesignVariables> variables_;
};

}  // namespace lake::redesign
