#include "lake/gait/plausibility.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "known_values.h"
#include "lake/core/error.h"
#include "lake/core/frames_where.h"
#include "lake/core/uncertain_text.h"

namespace lake::gait {
namespace {

// Values beyond the limits, if there are any; NaN is never beyond.
void FindBeyond(const std::vector<double>& values, double least, double most, const std::string& what,
                const std::string& unit, const std::vector<std::string>& markers, std::vector<Implausible>& found) {
  double worst = 0, beyond = 0;
  Implausible implausible{"", std::vector<char>(values.size(), 0), markers};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double over = std::max(values[i] - most, least - values[i]);
    implausible.at[i] = over > 0;
    if (over > beyond) {
      beyond = over;
      worst = values[i];
    }
  }
  if (beyond == 0) return;
  implausible.what = fmt::format("{} is {}{} at worst, a person's is between {} and {}", what,
                                 SignificantText(worst, 4), unit, SignificantText(least, 4), SignificantText(most, 4));
  found.push_back(std::move(implausible));
}

std::vector<double> Column(const motion::LegMotion& motion, double motion::LegSample::*value) {
  std::vector<double> values;
  for (const motion::LegSample& sample : motion.samples) values.push_back(sample.*value);
  return values;
}

std::vector<double> Lengths(const motion::LegMotion& motion, Eigen::Vector2d motion::LegSample::*segment) {
  std::vector<double> lengths;
  for (const motion::LegSample& sample : motion.samples) lengths.push_back((sample.*segment).norm());
  return lengths;
}

std::vector<double> OverMedian(std::vector<double> lengths) {
  const double usual = MedianOfKnown(lengths);
  for (double& length : lengths) length /= usual;
  return lengths;
}

// Speed and acceleration of each sample from its own place and those a moment before and after; NaN where not known.
struct MarkerRates {
  std::vector<double> speed, acceleration;
};

MarkerRates RatesOf(const motion::MarkerTrack& marker, const std::vector<double>& time_s) {
  constexpr double kReach_s = 0.05, kFarthest_s = 0.15;
  const std::size_t n = time_s.size();
  MarkerRates rates{std::vector<double>(n, NAN), std::vector<double>(n, NAN)};
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < n; ++i)
    if (marker.samples[i].IsKnown()) known.push_back(i);
  std::size_t before = 0, after = 0;
  for (std::size_t k = 0; k < known.size(); ++k) {
    const double now_s = time_s[known[k]];
    while (before + 1 < k && now_s - time_s[known[before + 1]] >= kReach_s) ++before;
    while (after + 1 < known.size() && time_s[known[after]] - now_s < kReach_s) ++after;
    const double back_s = now_s - time_s[known[before]], ahead_s = time_s[known[after]] - now_s;
    if (back_s < kReach_s || ahead_s < kReach_s || back_s > kFarthest_s || ahead_s > kFarthest_s) continue;
    const auto place = [&](std::size_t i) { return marker.samples[known[i]].position; };
    const Eigen::Vector2d from = (place(k) - place(before)) / back_s, to = (place(after) - place(k)) / ahead_s;
    rates.speed[known[k]] = std::max(from.norm(), to.norm());
    rates.acceleration[known[k]] = 2 * (to - from).norm() / (back_s + ahead_s);
  }
  return rates;
}

}  // namespace

std::vector<Implausible> FindImplausible(const motion::LegMotion& motion, const motion::MarkerRecording& trajectory,
                                         const LegMarkers& names, const PlausibilityLimits& limits) {
  const std::vector<std::string> leg = {names.ankle, names.knee, names.hip};
  std::vector<Implausible> found;
  FindBeyond(Column(motion, &motion::LegSample::knee_deg), limits.least_knee_deg, limits.most_knee_deg,
             "the knee angle", " deg", leg, found);
  for (const auto& [segment, name, ends] :
       {std::tuple{&motion::LegSample::ak, "shank", std::vector{names.ankle, names.knee}},
        {&motion::LegSample::kh, "thigh", std::vector{names.knee, names.hip}}})
    FindBeyond(OverMedian(Lengths(motion, segment)), limits.shortest, limits.longest,
               fmt::format("the length of the {} over its median", name), "", ends, found);
  FindBeyond(Column(motion, &motion::LegSample::knee_deg_s), -limits.most_knee_deg_s, limits.most_knee_deg_s,
             "the knee's angular velocity", " deg/s", leg, found);
  FindBeyond(Column(motion, &motion::LegSample::knee_sigma_deg), 0, limits.most_knee_sigma_deg,
             "the knee angle's standard deviation", " deg", {}, found);
  const double length =
      MedianOfKnown(Lengths(motion, &motion::LegSample::ak)) + MedianOfKnown(Lengths(motion, &motion::LegSample::kh));
  const double mm_per_unit = trajectory.unit == motion::LengthUnit::kMm ? 1 : limits.leg_mm / length;
  for (const motion::MarkerTrack& marker : trajectory.markers) {
    MarkerRates rates = RatesOf(marker, trajectory.time_s);
    for (auto* column : {&rates.speed, &rates.acceleration})
      for (double& value : *column) value *= mm_per_unit;
    FindBeyond(rates.speed, 0, limits.most_speed_mm_s, fmt::format("the speed of marker '{}'", marker.name), " mm/s",
               {marker.name}, found);
    FindBeyond(rates.acceleration, 0, limits.most_acceleration_mm_s2,
               fmt::format("the acceleration of marker '{}'", marker.name), " mm/s²", {marker.name}, found);
  }
  return found;
}

std::vector<Implausible> FindImplausibleTrunk(const motion::LegMotion& motion, const LegMarkers& names,
                                              const PlausibilityLimits& limits) {
  std::vector<Implausible> found;
  FindBeyond(OverMedian(Lengths(motion, &motion::LegSample::hw)), limits.shortest, limits.longest,
             "the length of the trunk over its median", "", {names.waist}, found);
  return found;
}

std::string FramesOf(const std::vector<std::int64_t>& frame, const std::vector<char>& at) {
  constexpr int kShown = 6;  // runs of frames in a message
  return FramesWhere(
      frame, [&](std::size_t i) { return at[i] != 0; }, kShown);
}

void CheckPlausible(const motion::LegMotion& motion, const motion::MarkerRecording& trajectory,
                    const PlausibilityLimits& limits) {
  const std::vector<Implausible> found = FindImplausible(motion, trajectory, {}, limits);
  if (!found.empty())
    throw Fail(
        "{} (frames {}): the markers are not where they were taken to be there, or the frames not when; look at these "
        "frames, {}",
        found.front().what, FramesOf(motion.frame, found.front().at), limits.ways_out);
}

}  // namespace lake::gait
