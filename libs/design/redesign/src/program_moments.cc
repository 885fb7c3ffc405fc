#include "lake/redesign/program_moments.h"

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/numbers.h"
#include "lake/problem/moment_at_pace.h"

namespace lake::redesign {
namespace {

// Until the feet alone bear the body the moment is not known, and the knee bends as the person's does.
problem::LoadProfile ProfileInPoses(const HumanMotion& human, const Prediction& prediction) {
  const BalanceCourse& course = *prediction.balance;
  const std::size_t first = human.size() - course.samples.size();
  std::vector<double> percent, knee_deg, knee_nm;
  for (auto* list : {&percent, &knee_deg, &knee_nm}) list->reserve(human.size());
  for (std::size_t i = 0; i < human.size(); ++i) {
    percent.push_back(PercentOf(i, human));
    knee_deg.push_back(DegreesFromRadians(i < first ? human[i].knee_rad : prediction.theta_rad[i]));
    knee_nm.push_back(i < first ? kNaN : course.samples[i - first].knee_nm);
  }
  return problem::MakeLoadProfile(percent, knee_deg, knee_nm, course.duration_s);
}

}  // namespace

problem::LoadProfile ProfileOf(const RedesignProblem& problem, const problem::LoadProfile& measured,
                               const RedesignPoint& point) {
  const auto prediction = PredictPoint(problem, point);
  if (prediction && prediction->balance) return ProfileInPoses(problem.human, *prediction);
  return problem::AtPace(measured, DurationOf(problem, point)).value_or(measured);
}

double LargestDifference_nm(const problem::LoadProfile& a, const problem::LoadProfile& b) {
  double largest_nm = 0;
  for (std::size_t i = 0; i < a.samples.size(); ++i)
    if (const double difference_nm = std::abs(a.samples[i].knee_nm - b.samples[i].knee_nm);
        std::isfinite(difference_nm))
      largest_nm = std::max(largest_nm, difference_nm);
  return largest_nm;
}

MomentsOfProgram FindMoments(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                             const synthesis::OptimizeOptions& options) {
  constexpr int kMostRounds = 8;
  constexpr double kSame_nm = 0.1;
  const problem::LoadProfile& measured = *problem.design.profile;
  RedesignPoint point = StartPoint(problem, links.front());
  MomentsOfProgram found{
      .measured = measured, .profile = ProfileOf(problem, measured, point), .duration_s = DurationOf(problem, point)};
  RedesignProblem under = problem;
  do {
    under.design.profile = found.profile;
    const RedesignSolve solve = SolveFrom(under, point, options);
    if (!solve.IsUsable()) break;
    point = solve.point;
    ++found.rounds;
    found.profile = ProfileOf(problem, measured, point);
    found.off_nm = LargestDifference_nm(found.profile, *under.design.profile);
    found.duration_s = DurationOf(problem, point);
  } while (found.off_nm > kSame_nm && found.rounds < kMostRounds);
  return found;
}

}  // namespace lake::redesign
