#include "lake/problem/moment_at_pace.h"

#include <cmath>
#include <utility>

#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/problem/assistance.h"

namespace lake::problem {

std::optional<LoadProfile> AtPace(const LoadProfile& profile, double duration_s) {
  if (profile.file.empty()) return std::nullopt;
  const Json json = ReadJsonFile(profile.file);
  if (!json.contains("knee_slow_nm")) return std::nullopt;
  const std::vector<double> slow_nm = NumbersOrNaN(json.at("knee_slow_nm"));
  if (slow_nm.size() != profile.samples.size())
    throw Fail("{}: 'knee_slow_nm' has {} values, and 'knee_nm' {}", profile.file.string(), slow_nm.size(),
               profile.samples.size());
  LoadProfile at_pace = profile;
  const double faster = profile.duration_s / duration_s;
  for (std::size_t i = 0; i < slow_nm.size(); ++i)
    at_pace.samples[i].knee_nm = slow_nm[i] + faster * faster * (profile.samples[i].knee_nm - slow_nm[i]);
  return at_pace;
}

ProblemAtPace AtItsPace(
    SynthesisProblem problem,
    const std::function<std::optional<linkage::Links>(const SynthesisProblem& problem)>& links_for) {
  constexpr int kTries = 6;
  constexpr double kSame = 0.005;
  const LoadProfile measured = *problem.profile;
  ProblemAtPace found{.problem = std::move(problem), .moments_s = measured.duration_s};
  if (!AtPace(measured, measured.duration_s)) return found;
  const auto take = [&](double duration_s) {
    found.problem.profile = AtPace(measured, duration_s);
    found.moments_s = duration_s;
  };
  if (found.problem.duration_s) take(*found.problem.duration_s);
  if (found.problem.duration_s || !found.problem.actuator || !found.problem.actuator->HasSpeed()) return found;
  for (int i = 0; i < kTries; ++i) {
    const std::optional<linkage::Links> links = links_for(found.problem);
    if (!links) break;
    const double shortest_s = FindAssistance(*links, found.problem).shortest_s;
    const bool is_known = std::isfinite(shortest_s) && shortest_s > 0;
    // What the actuator cannot lift at the profile's own pace it may still lift in the slowest rise.
    const bool may_be_slower = std::isinf(shortest_s) && i == 0;
    const bool is_last = i + 1 == kTries || std::abs(shortest_s / found.moments_s - 1) < kSame;
    if (is_last || !(is_known || may_be_slower)) break;
    take(is_known ? shortest_s : SynthesisProblem::kLongestDuration_s);
  }
  return found;
}

}  // namespace lake::problem
