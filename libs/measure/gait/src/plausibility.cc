#include "lake/gait/plausibility.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/frames_where.h"
#include "lake/core/statistics.h"

namespace lake::gait {
namespace {

constexpr int kShown = 6;  // runs of frames in a message

// The value farthest beyond the limits decides the message; NaN is never beyond.
void CheckColumn(const std::vector<double>& values, double least, double most, const std::string& what,
                 const std::string& unit, const std::vector<std::int64_t>& frame, const std::string& ways_out) {
  double worst = 0, beyond = 0;
  for (const double value : values) {
    const double over = std::max(value - most, least - value);
    if (over > beyond) beyond = over, worst = value;
  }
  if (beyond > 0)
    throw Fail(
        "{} is {:.4g} {} at worst, a person's is between {:.4g} and {:.4g} (frames {}): the markers are not where they "
        "were taken to be there, or the frames not when; look at these frames, {}",
        what, worst, unit, least, most,
        FramesWhere(
            frame, [&](std::size_t i) { return values[i] > most || values[i] < least; }, kShown),
        ways_out);
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

double MedianOfKnown(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return Median(std::move(values));
}

void CheckSegment(const motion::LegMotion& motion, Eigen::Vector2d motion::LegSample::*segment, const char* what,
                  const PlausibilityLimits& limits) {
  std::vector<double> lengths = Lengths(motion, segment);
  const double usual = MedianOfKnown(lengths);
  for (double& length : lengths) length /= usual;
  CheckColumn(lengths, limits.shortest, limits.longest, fmt::format("the length of the {} over its median", what), "",
              motion.frame, limits.ways_out);
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

void CheckPlausible(const motion::LegMotion& motion, const motion::MarkerRecording& trajectory,
                    const PlausibilityLimits& limits) {
  CheckColumn(Column(motion, &motion::LegSample::knee_deg), limits.least_knee_deg, limits.most_knee_deg,
              "the knee angle", "deg", motion.frame, limits.ways_out);
  CheckSegment(motion, &motion::LegSample::ak, "shank", limits);
  CheckSegment(motion, &motion::LegSample::kh, "thigh", limits);
  CheckColumn(Column(motion, &motion::LegSample::knee_deg_s), -limits.most_knee_deg_s, limits.most_knee_deg_s,
              "the knee's angular velocity", "deg/s", motion.frame, limits.ways_out);
  std::vector<double> sigmas = Column(motion, &motion::LegSample::knee_sigma_deg);
  const std::vector<double> all = sigmas;
  std::erase_if(sigmas, [](double v) { return !std::isfinite(v); });
  if (RootMeanSquare(sigmas) > limits.most_knee_sigma_deg)
    throw Fail(
        "the knee angle's standard deviation is {:.3g} deg (root mean square), where {} are the most that say anything "
        "(frames {}): the markers' paths fit no moving leg; look at these frames, {}",
        RootMeanSquare(sigmas), limits.most_knee_sigma_deg,
        FramesWhere(
            motion.frame, [&](std::size_t i) { return all[i] > limits.most_knee_sigma_deg; }, kShown),
        limits.ways_out);
  const double leg =
      MedianOfKnown(Lengths(motion, &motion::LegSample::ak)) + MedianOfKnown(Lengths(motion, &motion::LegSample::kh));
  const double mm_per_unit = trajectory.unit == motion::LengthUnit::kMm ? 1 : limits.leg_mm / leg;
  for (const motion::MarkerTrack& marker : trajectory.markers) {
    MarkerRates rates = RatesOf(marker, trajectory.time_s);
    for (auto* column : {&rates.speed, &rates.acceleration})
      for (double& value : *column) value *= mm_per_unit;
    CheckColumn(rates.speed, 0, limits.most_speed_mm_s, fmt::format("the speed of marker '{}'", marker.name), "mm/s",
                trajectory.frame, limits.ways_out);
    CheckColumn(rates.acceleration, 0, limits.most_acceleration_mm_s2,
                fmt::format("the acceleration of marker '{}'", marker.name), "mm/s²", trajectory.frame,
                limits.ways_out);
  }
}

void CheckPlausible(const LegFitResult& result, const PlausibilityLimits& limits) {
  CheckPlausible(result.motion, result.trajectory, limits);
  for (const MarkerReport& marker : result.markers) {
    if (marker.outliers <= limits.most_outliers * marker.detected) continue;
    throw Fail(
        "{} of the {} detections of marker '{}' are outliers of the fit, at most {:.0f} % may be (frames {}): what was "
        "seen there is no leg's motion; look at these frames, {}",
        marker.outliers, marker.detected, marker.name, 100 * limits.most_outliers,
        FramesWhere(
            result.motion.frame,
            [&](std::size_t i) {
              return std::any_of(result.outliers.begin(), result.outliers.end(), [&](const OutlierReport& outlier) {
                return outlier.marker == marker.name && outlier.frame == result.motion.frame[i];
              });
            },
            kShown),
        limits.ways_out);
  }
}

}  // namespace lake::gait
