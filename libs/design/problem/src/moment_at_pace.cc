#include "lake/problem/moment_at_pace.h"

#include "lake/core/error.h"
#include "lake/core/json.h"

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

}  // namespace lake::problem
