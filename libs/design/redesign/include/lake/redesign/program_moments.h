// What the knee needs along a stroke program: a load profile is of a rise at the person's own pace and in their own
// poses, and an actuator has to bear that of the program's. The program is sought under the moments that it makes, so
// the two are found in turn until they stay.
#pragma once

#include <optional>
#include <vector>

#include "lake/redesign/redesign.h"

namespace lake::redesign {

// The measured profile at the pace of a program, at the percents of the motion: with a body (balance.h) in the poses of
// the prediction, else in the person's own. As measured where neither the body nor the profile's file says what pace
// adds, and where there is no program: its duration is 0.
problem::LoadProfile ProfileAlong(const HumanMotion& human, const problem::LoadProfile& measured,
                                  const std::optional<Prediction>& prediction, double duration_s);
// Of a point's program.
problem::LoadProfile ProfileOf(const RedesignProblem& problem, const problem::LoadProfile& measured,
                               const RedesignPoint& point);

// Of two profiles at the same percents: the largest difference of moments that both know, N m. Throws std::logic_error
// where they have not as many samples, a mistake of the caller's.
double LargestDifferenceNm(const problem::LoadProfile& a, const problem::LoadProfile& b);

// Moments that are off by more are those of another program.
inline constexpr double kOtherMoments_nm = 1;

struct MomentsOfProgram {
  problem::LoadProfile measured, profile;  // of the person's own rise, of the program
  double duration_s = 0;                   // of the program's rise
  int rounds = 0;                          // of solving under the moments of the round before
  double off_nm = 0;                       // of the profile from the moments of the program that is found under it
};

// The moments of the optimum that is found under them, from the best of `start` and these links on; where none is
// usable, those of the first one's program, after no round. The problem has the measured profile.
MomentsOfProgram FindMoments(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                             const synthesis::OptimizeOptions& options, const std::optional<RedesignPoint>& start = {});

}  // namespace lake::redesign
