#include "oblique_walk.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/statistics.h"

namespace lake::gait {
namespace {

constexpr double kOblique_deg = 15, kLongWay = 1.5;  // the way of the hip that is needed, in shanks and thighs together
constexpr double kChange = 0.1;                      // of the lengths, where the camera's distance is not known

// The most that the projection takes from the knee's angle. A segment that leans forward also leans towards the
// camera, which sees it from where the hip is.
double LargestKneeError(const LegFitResult& leg, const motion::MarkerTrack& hip, double middle, double askance_rad) {
  double largest_deg = 0;
  for (std::size_t i = 0; i < leg.motion.samples.size(); ++i) {
    const motion::LegSample& sample = leg.motion.samples[i];
    if (!std::isfinite(sample.knee_deg) || !hip.samples[i].IsKnown()) continue;
    const double place = LegFromPlane(hip.samples[i].position, leg.motion.facing, leg.up).x() - middle,
                 seen = std::cos(askance_rad) + place / leg.sight->camera_mm.z() * std::sin(askance_rad);
    const auto error_deg = [&](double lean_deg) {
      const double lean_rad = RadiansFromDegrees(lean_deg);
      return DegreesFromRadians(std::atan2(std::sin(lean_rad) / seen, std::cos(lean_rad))) - lean_deg;
    };
    largest_deg = std::max(largest_deg, std::abs(error_deg(sample.shank_deg) - error_deg(sample.thigh_deg)));
  }
  return largest_deg;
}

}  // namespace

std::optional<std::string> ObliqueWalk(const LegFitResult& leg) {
  const motion::MarkerTrack* hip = leg.trajectory.Find(leg.leg_markers.hip);
  if (!hip || leg.lateral) return std::nullopt;
  // Lengths over the place on the way, in which they are linear whatever the angle, and over the lean, which changes
  // them too.
  std::vector<double> places, lengths, leans;
  for (std::size_t i = 0; i < leg.motion.samples.size(); ++i) {
    const motion::LegSample& sample = leg.motion.samples[i];
    if (!std::isfinite(sample.knee_deg) || !hip->samples[i].IsKnown()) continue;
    places.push_back(LegFromPlane(hip->samples[i].position, leg.motion.facing, leg.up).x());
    lengths.push_back(sample.ak.norm() + sample.kh.norm());
    leans.push_back(std::pow(std::sin(RadiansFromDegrees(sample.shank_deg)), 2));
  }
  constexpr std::size_t kFewest = 8;
  if (places.size() < kFewest) return std::nullopt;
  const auto [first, last] = std::ranges::minmax(places);
  const double way = last - first, middle = (first + last) / 2;
  if (way < kLongWay * Median(lengths)) return std::nullopt;
  Eigen::MatrixX3d rows(places.size(), 3);
  for (std::size_t i = 0; i < places.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) << 1, places[i] - middle, leans[i];
  const Eigen::Vector3d fit = rows.colPivHouseholderQr().solve(
      Eigen::Map<const Eigen::VectorXd>(lengths.data(), static_cast<Eigen::Index>(lengths.size())));
  const double slope = fit.y() / fit.x(), change = std::abs(slope) * way;
  const std::string seen =
      fmt::format("the person {} while walking through: shank and thigh become {:.0f} % {} over the way",
                  slope > 0 ? "comes nearer" : "goes away", 100 * change, slope > 0 ? "longer" : "shorter");
  if (!leg.sight) {
    if (change < kChange) return std::nullopt;
    return seen +
           "; stride lengths and leans are too small; how much that takes from the knee's angle only a camera with a "
           "calibrated plane tells (--camera)";
  }
  const double askance_rad = std::atan(slope * leg.sight->camera_mm.z());
  if (std::abs(askance_rad) < RadiansFromDegrees(kOblique_deg)) return std::nullopt;
  return fmt::format(
      "{}, as {:.0f}° from the plane; stride lengths and speed are {:.0f} % too small, and the knee's angle is off by "
      "up "
      "to {:.0f}°; walk along the plane",
      seen, DegreesFromRadians(std::abs(askance_rad)), 100 * (1 - std::cos(askance_rad)),
      LargestKneeError(leg, *hip, middle, askance_rad));
}

}  // namespace lake::gait
