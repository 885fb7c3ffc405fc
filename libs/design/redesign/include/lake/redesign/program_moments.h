// What the knee needs along a stroke program: a load profile is of a rise at the person's own pace and in their own
// poses, and an actuator has to bear that of the program's. The program is sought under the moments that it makes, so
// the two are found in turn until they stay.
#pragma once

#include <vector>

#include "lake/redesign/redesign.h"

namespace lake::redesign {

// The measured profile at the pace of a point's program: with a body (balance.h) in its poses, else in the person's
// own. As measured where neither the body nor the profile's file says what pace adds.
problem::LoadProfile ProfileOf(const RedesignProblem& problem, const problem::LoadProfile& measured,
                               const RedesignPoint& point);

// Of two profiles with as many samples: the largest difference of moments that both know, N m.
double LargestDifference_nm(const problem::LoadProfile& a, const problem::LoadProfile& b);

struct MomentsOfProgram {
  problem::LoadProfile measured, profile;  // of the person's own rise, of the program
  double duration_s = 0;                   // of the program's rise
  int rounds = 0;                          // of solving under the moments of the round before
  double off_nm = 0;                       // of the profile from the moments of the program that is found under it
};

// The moments of the optimum that is found under them, from these links; where no start is usable, those of the
// start's program. The problem has a load profile.
MomentsOfProgram FindMoments(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                             const synthesis::OptimizeOptions& options);

}  // namespace lake::redesign
