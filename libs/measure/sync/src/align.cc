#include "lake/sync/align.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/sync/lag.h"
#include "lake/sync/movement.h"

namespace lake::sync {
namespace {

struct Pairing {
  std::string name = {};  // "speeds of knee, hip"
  Series y = {}, x = {};  // y is predicted from x
  bool y_is_a = false;    // else y is B's
  double model_sd_s = 0;  // of a time: the part that a linear map of x does not have; see README
};

using Eigen::Index, Eigen::MatrixXd;

// 1 SD of a time, of the movement that a linear map leaves out. Markers: of three legs seen from 45° aside, of which
// one camera does not see the depth, 0.9 ms. Forces: the markers' mean height is not the centre of mass, 4 ms on a
// person's plates whose clock is the markers'. A sensor: strap and skin, 2 to 4 ms between halves of two people's
// recordings.
constexpr double kOfMarkers_s = 0.001, kOfForces_s = 0.004, kOfSensor_s = 0.002;

MatrixXd ColumnsOf(const Movement& movement, std::size_t marker) {
  return movement.values.middleCols(static_cast<Index>(marker) * movement.dimensions, movement.dimensions);
}

Series Speeds(const Movement& movement, const MatrixXd& values, const Band& band) {
  return Derivative(Sample(movement.time_s, values, band));
}

// What several columns have in common: their principal components, the largest first, at most six.
Series PrincipalComponents(const Series& all) {
  constexpr Index kMost = 6;
  constexpr double kLeast = 1e-4;  // of the largest one's variance
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(all.value.transpose() * all.value);
  const Eigen::VectorXd& variance = solver.eigenvalues();
  const Index count = std::min<Index>(kMost, (variance.array() > kLeast * variance.maxCoeff()).count());
  Series components = all;
  components.value = all.value * solver.eigenvectors().rightCols(count).rowwise().reverse();
  return components;
}

// At most six markers, those that move most first, that are known together in most of the frames.
std::vector<std::size_t> MovingMarkers(const Movement& movement, const Band& band,
                                       const std::vector<std::string>* among = nullptr) {
  constexpr std::size_t kMost = 6;
  constexpr double kShare = 0.7;  // of the frames
  std::vector<std::pair<double, std::size_t>> energy;
  for (std::size_t m = 0; m < movement.names.size(); ++m)
    if (!among || std::ranges::count(*among, movement.names[m]) > 0)
      energy.emplace_back(-Speeds(movement, ColumnsOf(movement, m), band).value.squaredNorm(), m);
  std::ranges::sort(energy);
  std::vector<std::size_t> moving;
  Eigen::ArrayXd known = Eigen::ArrayXd::Ones(movement.values.rows());
  for (const auto& [negative, marker] : energy) {
    const Eigen::ArrayXd sums = ColumnsOf(movement, marker).rowwise().sum();
    const Eigen::ArrayXd together = known * sums.isFinite().cast<double>();
    if (!(negative < 0) || together.mean() < kShare || moving.size() == kMost) continue;
    moving.push_back(marker);
    known = together;
  }
  return moving;
}

MatrixXd ColumnsOf(const Movement& movement, const std::vector<std::size_t>& markers) {
  MatrixXd values(movement.values.rows(), movement.dimensions * static_cast<Index>(markers.size()));
  for (std::size_t m = 0; m < markers.size(); ++m)
    values.middleCols(static_cast<Index>(m) * movement.dimensions, movement.dimensions) =
        ColumnsOf(movement, markers[m]);
  return values;
}

std::string NamesOf(const Movement& movement, const std::vector<std::size_t>& markers) {
  std::vector<std::string> names;
  names.reserve(markers.size());
  for (const std::size_t marker : markers) names.push_back(movement.names[marker]);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<std::size_t> SomeMovingMarkers(const Movement& movement, const Band& band,
                                           const std::vector<std::string>* among = nullptr) {
  std::vector<std::size_t> moving = MovingMarkers(movement, band, among);
  if (moving.empty())
    throw Fail("{}: no marker is seen in most of the frames and moves: there is nothing to align by",
               movement.file.string());
  return moving;
}

// The markers that both name, else any.
Pairing OfMarkers(const Movement& a, const Movement& b, const Band& band) {
  std::vector<std::string> common;
  std::ranges::copy_if(a.names, std::back_inserter(common),
                       [&](const std::string& name) { return std::ranges::count(b.names, name) > 0; });
  const std::vector<std::string>* among = common.empty() ? nullptr : &common;
  const auto series = [&](const Movement& movement, const std::vector<std::size_t>& markers) {
    return PrincipalComponents(Speeds(movement, ColumnsOf(movement, markers), band));
  };
  const bool y_is_a = a.dimensions < b.dimensions;
  const Movement &y = y_is_a ? a : b, &x = y_is_a ? b : a;
  const std::vector<std::size_t> markers = SomeMovingMarkers(y, band, among);
  return {.name = fmt::format("speeds of {}", NamesOf(y, markers)),
          .y = series(y, markers),
          .x = series(x, SomeMovingMarkers(x, band, among)),
          .y_is_a = y_is_a,
          .model_sd_s = kOfMarkers_s};
}

// Of the direction from one marker to another: how fast it turns in the plane; in space, in the vertical plane in which
// it turns most.
Series TurningRate(const Movement& movement, std::size_t from, std::size_t to, const Band& band) {
  const Series between = Sample(movement.time_s, ColumnsOf(movement, to) - ColumnsOf(movement, from), band);
  Eigen::MatrixX2d direction(between.Rows(), 2);
  if (movement.dimensions == 2) {
    direction = between.value;
  } else {
    Eigen::MatrixX2d level(between.Rows(), 2);
    level << between.value.col((movement.up + 1) % 3), between.value.col((movement.up + 2) % 3);
    const Eigen::MatrixX2d about = level.rowwise() - level.colwise().mean();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(about.transpose() * about);
    direction << level * solver.eigenvectors().col(1), between.value.col(movement.up);
  }
  Series rate = between;
  rate.value = direction;
  rate = Derivative(rate);
  const Eigen::ArrayXd turning =
      direction.col(0).cwiseProduct(rate.value.col(1)) - direction.col(1).cwiseProduct(rate.value.col(0));
  rate.value = (turning / direction.rowwise().squaredNorm().array().max(1e-12)).matrix();
  return rate;
}

// The segment that carries the sensor is not known: the lines between any two markers.
Pairing OfSegments(const Movement& markers, const Movement& sensor, bool markers_are_a, const Band& band) {
  const std::vector<std::size_t> moving = SomeMovingMarkers(markers, band);
  if (moving.size() < 2)
    throw Fail("{}: one marker shows no segment that turns, as a sensor of angular rates does: it takes two",
               markers.file.string());
  Series turning;
  for (std::size_t i = 0; i < moving.size(); ++i)
    for (std::size_t k = i + 1; k < moving.size(); ++k) {
      const Series rate = TurningRate(markers, moving[i], moving[k], band);
      if (turning.Rows() == 0) turning = {rate.start_s, rate.step_s, MatrixXd(rate.Rows(), 0), rate.known};
      turning.value.conservativeResize(Eigen::NoChange, turning.value.cols() + 1);
      turning.value.rightCols(1) = rate.value;
      for (std::size_t row = 0; row < rate.known.size(); ++row) turning.known[row] &= rate.known[row];
    }
  for (Index row = 0; row < turning.Rows(); ++row)
    if (turning.known[static_cast<std::size_t>(row)] == 0) turning.value.row(row).setZero();
  return {.name = "angular rates",
          .y = PrincipalComponents(Sample(sensor.time_s, sensor.values, band)),
          .x = PrincipalComponents(turning),
          .y_is_a = !markers_are_a,
          .model_sd_s = kOfSensor_s};
}

// Where the feet bear the body, and no seat: from when the force reaches the weight until it last has it.
void KeepOnTheFeet(const std::filesystem::path& file, Series& force) {
  std::vector<double> known;
  for (Index i = 0; i < force.Rows(); ++i)
    if (force.known[static_cast<std::size_t>(i)]) known.push_back(force.value(i, 0));
  const double most_n = Quantile(known, 0.95);
  std::erase_if(known, [&](double value) { return value < most_n / 2; });
  if (known.empty() || !(most_n > 0)) throw Fail("{}: the plates bear no force", file.string());
  const double weight_n = Median(known);
  constexpr double kBorne = 0.95, kLeft = 0.3;  // of the weight; a quick rise ends with 0.4
  std::vector<unsigned char> bears(force.known.size(), 0);
  std::optional<std::size_t> first, last;
  for (std::size_t i = 0; i <= bears.size(); ++i) {
    const bool ends = i == bears.size() || !force.known[i] || force.value(static_cast<Index>(i), 0) < kLeft * weight_n;
    if (ends && first) {
      std::fill(&bears[*first], &bears[*last] + 1, 1);
      first.reset();
    }
    if (ends || force.value(static_cast<Index>(i), 0) < kBorne * weight_n) continue;
    if (!first) first = i;
    last = i;
  }
  force.known = bears;
}

// The ground's vertical force is the weight and the mass times its mean vertical acceleration: nearly that of the
// markers' mean height, which markers that change names do not change.
Pairing OfForces(const Movement& markers, const Movement& forces, bool markers_are_a, const Band& band) {
  Series force = Sample(forces.time_s, forces.values, band);
  KeepOnTheFeet(forces.file, force);
  Eigen::VectorXd height = Eigen::VectorXd::Zero(markers.values.rows());
  int count = 0;
  for (std::size_t m = 0; m < markers.names.size(); ++m) {
    const Eigen::VectorXd own = ColumnsOf(markers, m).col(markers.up);
    if (!own.allFinite()) continue;
    height += own;
    ++count;
  }
  if (count == 0) throw Fail("{}: no marker is seen throughout", markers.file.string());
  return {.name = "vertical force",
          .y = force,
          .x = Derivative(Derivative(Sample(markers.time_s, height / count, band))),
          .y_is_a = !markers_are_a,
          .model_sd_s = kOfForces_s};
}

// Throws Error where the two show nothing in common, or nothing moves.
Pairing PairingOf(const Movement& a, const Movement& b) {
  using enum MovementKind;
  const auto are = [&](MovementKind first, MovementKind second) { return a.kind == first && b.kind == second; };
  if (are(kForces, kInertial) || are(kInertial, kForces))
    throw Fail(
        "{} and {}: ground forces and an inertial sensor show no common movement; align each with a recording of "
        "markers, or give a signal that both have (--signal-a, --signal-b)",
        a.file.string(), b.file.string());
  const Band band = BandOf(a.time_s, b.time_s);
  if (are(kMarkers, kMarkers)) return OfMarkers(a, b, band);
  if (are(kMarkers, kInertial)) return OfSegments(a, b, true, band);
  if (are(kInertial, kMarkers)) return OfSegments(b, a, false, band);
  if (are(kMarkers, kForces)) return OfForces(a, b, true, band);
  if (are(kForces, kMarkers)) return OfForces(b, a, false, band);
  if (are(kForces, kForces))
    return {.name = "vertical force", .y = Speeds(b, b.values, band), .x = Speeds(a, a.values, band)};
  return {.name = "angular rates", .y = Sample(b.time_s, b.values, band), .x = Sample(a.time_s, a.values, band)};
}

// Why there is no offset; `sign`: of an offset to add to B's times in the lag's.
std::string ReasonOf(const Lag& lag, double sign, double drift_sd_ppm, const std::string& compared) {
  switch (lag.refusal) {
    case LagRefusal::kUnexplained:
      return fmt::format(
          "at the best offset {:.0f} % of the movement of one ({}) is not predicted by that of the other; are these "
          "recordings of one movement?",
          100 * lag.unexplained, compared);
    case LagRefusal::kTooShort:
      return "at no offset do both show a common movement for long enough; it takes some 4 s of movement in both";
    case LagRefusal::kAnother:
      return fmt::format(
          "offsets of {:.2f} and {:.2f} s are about as likely; are these recordings of one movement? If so, record one "
          "that does not repeat itself, or give a signal that both have (--signal-a, --signal-b)",
          sign * lag.offset_s, sign * lag.second_s);
    case LagRefusal::kDrift:
      return fmt::format(
          "their clocks would run {:+.0f} ppm apart, where {:.0f} ppm is one standard deviation; are these recordings "
          "of one movement? If a rate is that wrong, say so: --drift-sd",
          1e6 * sign * lag.free_drift, drift_sd_ppm);
    case LagRefusal::kUncertain:
      return fmt::format(
          "the offset of {:.2f} s would be uncertain by {:.0f} ms (1 SD); are these recordings of one movement? If so, "
          "record more of it, or give a signal that both have (--signal-a, --signal-b)",
          sign * lag.offset_s, 1000 * lag.LargestSdS());
    default: {
      std::string departures;
      for (const BlockLag& block : lag.blocks)
        departures += fmt::format("{}{:+.3f}", departures.empty() ? "" : ", ", sign * block.departure_s);
      return fmt::format(
          "parts of the overlap contradict one another, by {} s from the best offset; are these recordings of one "
          "movement?",
          departures);
    }
  }
}

// Of A's times from B's, at B's first.
Clock ClockOf(const Lag& lag, bool y_is_a, double from_s) {
  const double a_s = y_is_a ? lag.from_s + (from_s - lag.offset_s - lag.from_s) / (1 + lag.drift) : lag.At(from_s);
  return {.offset_s = a_s - from_s,
          .drift_ppm = 1e6 * (y_is_a ? 1 / (1 + lag.drift) - 1 : lag.drift),
          .from_s = from_s,
          .method = "motion"};
}

}  // namespace

Alignment AlignByMotion(const Movement& a, const Movement& b, const AlignOptions& options) {
  const Pairing pairing = PairingOf(a, b);
  const Lag lag = FindLag(pairing.y, pairing.x, {.drift_sd = 1e-6 * options.drift_sd_ppm});
  const double sign = pairing.y_is_a ? -1 : 1;
  if (lag.refusal != LagRefusal::kNone)
    throw Fail("{} and {}: cannot be aligned: {}", a.file.string(), b.file.string(),
               ReasonOf(lag, sign, options.drift_sd_ppm, pairing.name));
  Alignment alignment{.clock = ClockOf(lag, pairing.y_is_a, b.time_s.front()),
                      .drift_sd_ppm = 1e6 * std::sqrt(lag.covariance(1, 1)),
                      .unexplained = lag.unexplained,
                      .overlap_s = lag.overlap_s,
                      .offset_s = lag.search_s,
                      .log_likelihood = lag.log_likelihood,
                      .comparison = {pairing.name, lag.time_s, lag.measured, lag.predicted}};
  alignment.clock.sd_s = std::hypot(pairing.model_sd_s, lag.LargestSdS());
  const auto on_a = [&](double y_time_s) { return pairing.y_is_a ? y_time_s : lag.At(y_time_s); };
  for (const BlockLag& block : lag.blocks)
    alignment.parts.push_back({on_a(block.time_s), sign * block.departure_s, block.sd_s});
  for (double& time_s : alignment.comparison.time_s) time_s = on_a(time_s);
  for (double& offset_s : alignment.offset_s) offset_s *= sign;
  return alignment;
}

}  // namespace lake::sync
