// What the knee needs along a stroke program.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "lake/core/angles.h"
#include "lake/core/numbers.h"
#include "lake/redesign/redesign.h"

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

// Between two samples; of one alone where it is there. std::lerp takes the other where the first is NaN.
double Between(double a, double b, double weight) {
  constexpr double kRounding = 1e-9;
  if (weight < kRounding) return a;
  if (weight > 1 - kRounding) return b;
  return a + weight * (b - a);
}

// Linear between the profile's samples; not known where one of the two is not.
problem::LoadProfile AtPercentsOf(const HumanMotion& human, const problem::LoadProfile& profile) {
  const std::vector<problem::LoadSample>& samples = profile.samples;
  std::vector<double> percents, knee_deg, knee_nm;
  for (auto* list : {&percents, &knee_deg, &knee_nm}) list->reserve(human.size());
  for (std::size_t i = 0; i < human.size(); ++i) {
    const double percent = PercentOf(i, human);
    const auto after =
        std::ranges::lower_bound(samples.begin() + 1, samples.end() - 1, percent, {}, &problem::LoadSample::percent);
    const problem::LoadSample &b = *after, &a = *(after - 1);
    const double weight = (percent - a.percent) / (b.percent - a.percent);
    percents.push_back(percent);
    knee_deg.push_back(DegreesFromRadians(Between(a.knee_rad, b.knee_rad, weight)));
    knee_nm.push_back(Between(a.knee_nm, b.knee_nm, weight));
  }
  return problem::MakeLoadProfile(percents, knee_deg, knee_nm, profile.duration_s);
}

}  // namespace

problem::LoadProfile ProfileAlong(const HumanMotion& human, const problem::LoadProfile& measured,
                                  const std::optional<Prediction>& prediction, double duration_s) {
  if (prediction && prediction->balance) return ProfileInPoses(human, *prediction);
  const auto at_pace = duration_s > 0 ? problem::AtPace(measured, duration_s) : std::nullopt;
  return AtPercentsOf(human, at_pace.value_or(measured));
}

problem::LoadProfile ProfileOf(const RedesignProblem& problem, const problem::LoadProfile& measured,
                               const RedesignPoint& point) {
  return ProfileAlong(problem.human, measured, PredictPoint(problem, point), DurationOf(problem, point));
}

double LargestDifferenceNm(const problem::LoadProfile& a, const problem::LoadProfile& b) {
  if (a.samples.size() != b.samples.size())
    throw std::logic_error(
        fmt::format("moments at {} and at {} percents cannot be compared", a.samples.size(), b.samples.size()));
  double largest_nm = 0;
  for (std::size_t i = 0; i < a.samples.size(); ++i)
    if (const double difference_nm = std::abs(a.samples[i].knee_nm - b.samples[i].knee_nm);
        std::isfinite(difference_nm))
      largest_nm = std::max(largest_nm, difference_nm);
  return largest_nm;
}

MomentsOfProgram FindMoments(const RedesignProblem& problem, const std::vector<linkage::Links>& links,
                             const synthesis::OptimizeOptions& options, const std::optional<RedesignPoint>& start) {
  constexpr int kMostRounds = 8;
  constexpr double kSame_nm = 0.1;
  const problem::LoadProfile& measured = *problem.design.profile;
  std::vector<RedesignPoint> starts;
  if (start) starts.push_back(*start);
  for (const linkage::Links& one : links) starts.push_back(StartPoint(problem, one));
  MomentsOfProgram found{.measured = measured,
                         .profile = ProfileOf(problem, measured, starts.front()),
                         .duration_s = DurationOf(problem, starts.front())};
  RedesignProblem under = problem;
  do {
    under.design.profile = found.profile;
    RedesignResult search;
    for (const RedesignPoint& start : starts) search.Add(SolveFrom(under, start, options));
    if (!search.IsSolved()) break;
    const RedesignPoint point = search.Best().Point();
    ++found.rounds;
    found.profile = ProfileOf(problem, measured, point);
    found.off_nm = LargestDifferenceNm(found.profile, *under.design.profile);
    found.duration_s = DurationOf(problem, point);
    starts = {point};
  } while (found.off_nm > kSame_nm && found.rounds < kMostRounds);
  return found;
}

}  // namespace lake::redesign
