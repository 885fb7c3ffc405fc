#include "lake/problem/load_profile.h"

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/plausible.h"

namespace lake::problem {
namespace {

namespace fs = std::filesystem;

// A list of numbers; null is NaN.
std::vector<double> ReadColumn(const Json& json, const char* key, const fs::path& file) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array())
    throw Fail("{}: '{}' is missing: give the loads.json of lake-loads", file.string(), key);
  for (const Json& value : *found)
    if (!value.is_number() && !value.is_null())
      throw Fail("{}: '{}' has an entry that is no number: {}", file.string(), key, value.dump().substr(0, 40));
  return NumbersOrNaN(*found);
}

void CheckPercents(const std::vector<double>& percent) {
  constexpr double kRounding = 1e-9;
  const bool ends = std::abs(percent.front()) < kRounding && std::abs(percent.back() - 100) < kRounding;
  const auto does_not_ascend = [](double a, double b) { return !(a < b); };  // NaN neither
  if (!ends || std::ranges::adjacent_find(percent, does_not_ascend) != percent.end())
    throw Fail("the percents of a load profile must ascend from 0 to 100");
}

void CheckSample(double percent, double knee_deg, double knee_nm) {
  if (!(knee_deg > -60 && knee_deg < 180))
    throw Fail("the load profile has a knee angle of {}° at {} %: it must lie between -60 and 180", knee_deg, percent);
  if (!std::isnan(knee_nm) && !kPlausibleKneeTorque.Holds(knee_nm))
    throw Fail("the load profile has a moment of {} N m at {} %: no knee bears that", knee_nm, percent);
}

void TakeSlowMoments(const std::vector<double>& slow_nm, LoadProfile& profile) {
  if (slow_nm.size() != profile.samples.size())
    throw Fail("'knee_slow_nm' has {} values, and 'knee_nm' {}", slow_nm.size(), profile.samples.size());
  for (std::size_t i = 0; i < slow_nm.size(); ++i) profile.samples[i].slow_nm = slow_nm[i];
}

}  // namespace

std::optional<LoadProfile> AtPace(const LoadProfile& profile, double duration_s) {
  if (!profile.HasPace()) return std::nullopt;
  LoadProfile at_pace = profile;
  at_pace.moments_s = duration_s;
  const double faster = profile.moments_s / duration_s;
  for (LoadSample& sample : at_pace.samples)
    sample.knee_nm = sample.slow_nm + faster * faster * (sample.knee_nm - sample.slow_nm);
  return at_pace;
}

bool LoadProfile::HasPace() const {
  return std::ranges::any_of(samples, [](const LoadSample& sample) { return !std::isnan(sample.slow_nm); });
}

double LoadProfile::LargestAngle() const {
  return std::ranges::max(samples, {}, &LoadSample::knee_rad).knee_rad;
}

LoadProfile MakeLoadProfile(const std::vector<double>& percent, const std::vector<double>& knee_deg,
                            const std::vector<double>& knee_nm, double duration_s) {
  const std::size_t n = percent.size();
  if (knee_deg.size() != n || knee_nm.size() != n)
    throw Fail("a load profile needs lists of equal length, not {} percents, {} angles and {} moments", n,
               knee_deg.size(), knee_nm.size());
  if (n < 3) throw Fail("a load profile needs at least three samples, not {}", n);
  CheckPercents(percent);
  if (!(duration_s > 0 && duration_s < 600)) throw Fail("a rise cannot take {} s", duration_s);
  LoadProfile profile;
  profile.duration_s = profile.moments_s = duration_s;
  for (std::size_t i = 0; i < n; ++i) {
    CheckSample(percent[i], knee_deg[i], knee_nm[i]);
    const std::size_t before = i == 0 ? 0 : i - 1, after = std::min(i + 1, n - 1);
    const double rate_deg = 100 * (knee_deg[after] - knee_deg[before]) / (percent[after] - percent[before]);
    profile.samples.push_back({.percent = percent[i],
                               .knee_rad = RadiansFromDegrees(knee_deg[i]),
                               .rad_per_rise = RadiansFromDegrees(rate_deg),
                               .knee_nm = knee_nm[i]});
  }
  if (std::ranges::all_of(knee_nm, [](double moment) { return std::isnan(moment); }))
    throw Fail("the load profile has no known moment");
  return profile;
}

LoadProfile ReadLoadProfile(const fs::path& path) {
  const fs::path file = fs::is_directory(path) ? path / "loads.json" : path;
  const Json json = ReadJsonFile(file);
  if (!json.is_object()) throw Fail("{}: not a profile of lake-loads", file.string());
  const std::vector<double> time_s = ReadColumn(json, "time_s", file), percent = ReadColumn(json, "percent", file),
                            knee_deg = ReadColumn(json, "knee_deg", file), knee_nm = ReadColumn(json, "knee_nm", file);
  try {
    if (time_s.empty()) throw Fail("the load profile has no samples");
    LoadProfile profile = MakeLoadProfile(percent, knee_deg, knee_nm, time_s.back() - time_s.front());
    profile.file = file;
    if (json.contains("knee_slow_nm")) TakeSlowMoments(ReadColumn(json, "knee_slow_nm", file), profile);
    return profile;
  } catch (const Error& error) {
    throw Fail("{}: {}", file.string(), error.what());
  }
}

}  // namespace lake::problem
