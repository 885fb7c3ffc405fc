// What a re-optimisation adds to the nonlinear program of a synthesis problem (synthesis_program.h):
//
//   for s = 0..100 %, d(s) linear between the knots d_k:
//        |R - M|^2 = d(s)^2, |R - S|^2 = l1^2, alpha2 >= 0, beta2 >= 0     its own phi(s), theta(s) >= standing
//   -v T / (K - 1) <= d_k+1 - d_k <= v T / (K - 1),  0 <= T <= duration    speed
//   m := mean (100 |e - h| / L)^2 <= limit^2                               in (percent)^2
//   mean |e - h|^2 <= r^2,  r >= 1 um                                      if there is a penalty, cost + w r
//   constant: K = 2, theta(0) = the human's and d_0 >= d_min, or d_0 = d_min and theta(0) <= the human's;
//             theta(100) = the human's, at least standing
//
// Small costs decide where nothing else does: on misalignment (range is sought), on range (misalignment is sought), on
// placement and on time.
#pragma once

#include "lake/redesign/reoptimize_problem.h"
#include "lake/synthesis/optimize.h"

namespace lake::redesign {

// Where a constant program starts; max(d(theta_human(0)), d_min) has a corner, and each side of it is smooth.
enum class ConstantStart { kAtHumanAngle, kAtShortestStroke };

// Indices in the program.
struct ReoptimizeVariables {
  synthesis::LinkVariables links{};
  std::vector<int> knots;
  std::array<int, 2> placement{};
  int duration = -1;
  std::vector<int> theta;  // per percent
};

// Builds the program of a re-optimisation for the poses of each exchange step, from the point where the last one ended.
class ReoptimizeBuilder : public synthesis::ProgramBuilder {
 public:
  ReoptimizeBuilder(const ReoptimizeProblem& problem, const ReoptimizePoint& start, ConstantStart constant_start)
      : problem_(problem), constant_start_(constant_start), point_(start) {}

  synthesis::SynthesisProgram Build(const synthesis::Collocation& poses) override;
  void MoveTo(const std::vector<double>& x) override;
  const linkage::Links& Links() const override { return point_.links; }
  const ReoptimizePoint& Point() const { return point_; }

 private:
  const ReoptimizeProblem& problem_;
  const ConstantStart constant_start_;
  ReoptimizePoint point_;
  ReoptimizeVariables variables_;  // of the last program
};

}  // namespace lake::redesign
