#include "pairing.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/statistics.h"

namespace lake::sync {
namespace {

using Eigen::Index;

constexpr Index kStride = 3;             // y's step in x's
constexpr std::size_t kMostMarkers = 6;  // those that move most say what there is to say
constexpr Index kMostComponents = 3;
// What is not explained of a movement that both show: 0.1 % between cameras, 0.2 to 0.7 % of two people's thighs with a
// sensor, 1.3 % of a person on two plates; of movements that are only alike, as other rises of the same person, 6 %,
// 84 % and 18 % at least.
constexpr double kOfMarkers = 0.03, kOfSensor = 0.1, kOfForces = 0.08;

// A person's movement lies below 6 Hz; of slow recordings less can be told.
struct Band {
  double cutoff_hz, step_s;
};

Band BandOf(const Movement& a, const Movement& b) {
  constexpr double kPerson_hz = 6, kOfRate = 0.2;
  const double slowest_hz = 1 / std::max(MedianInterval(a.time_s), MedianInterval(b.time_s));
  const double cutoff_hz = std::min(kPerson_hz, kOfRate * slowest_hz);
  return {cutoff_hz, 1 / (10 * cutoff_hz)};
}

Eigen::MatrixXd ColumnsOf(const Movement& movement, std::size_t marker) {
  return movement.values.middleCols(static_cast<Index>(marker) * movement.dimensions, movement.dimensions);
}

Series MarkerSeries(const Movement& movement, std::size_t marker, const Band& band) {
  return Sample(movement.time_s, ColumnsOf(movement, marker), band.cutoff_hz, band.step_s);
}

double Energy(const Series& series) {
  return series.value.squaredNorm();
}

bool IsMostlyKnown(const Movement& movement, std::size_t marker) {
  constexpr double kShare = 0.7;
  const Eigen::MatrixXd columns = ColumnsOf(movement, marker);
  Index known = 0;
  for (Index i = 0; i < columns.rows(); ++i) known += columns.row(i).allFinite() ? 1 : 0;
  return static_cast<double>(known) > kShare * static_cast<double>(columns.rows());
}

// Those that move most, the most first.
std::vector<std::size_t> MovingMarkers(const Movement& movement, std::size_t most, const Band& band) {
  std::vector<std::pair<double, std::size_t>> energy;
  for (std::size_t m = 0; m < movement.names.size(); ++m)
    if (IsMostlyKnown(movement, m)) energy.emplace_back(-Energy(Derivative(MarkerSeries(movement, m, band))), m);
  std::ranges::sort(energy);
  std::vector<std::size_t> moving;
  for (const auto& [negative, marker] : energy)
    if (moving.size() < most && negative < 0) moving.push_back(marker);
  if (moving.empty())
    throw Fail("{}: no marker is seen in most of the frames and moves: there is nothing to align by",
               movement.file.string());
  return moving;
}

// What several series have in common: their principal components, at most three.
Series PrincipalComponents(const Series& all) {
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(all.value.cols(), all.value.cols());
  for (Index i = 0; i < all.Rows(); ++i)
    if (all.known[static_cast<std::size_t>(i)]) square += all.value.row(i).transpose() * all.value.row(i);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(square);
  const Index count = std::min(kMostComponents, all.value.cols());
  Series components = all;
  components.value = all.value * solver.eigenvectors().rightCols(count);
  return components;
}

Series AllMarkers(const Movement& movement, const std::vector<std::size_t>& markers, bool only_heights,
                  const Band& band) {
  const Index width = only_heights ? 1 : movement.dimensions;
  Eigen::MatrixXd values(movement.values.rows(), width * static_cast<Index>(markers.size()));
  for (std::size_t m = 0; m < markers.size(); ++m)
    values.middleCols(static_cast<Index>(m) * width, width) =
        only_heights ? ColumnsOf(movement, markers[m]).col(movement.up) : ColumnsOf(movement, markers[m]);
  return Sample(movement.time_s, values, band.cutoff_hz, band.step_s);
}

Part MakePart(std::string name, const Series& y, const Series& x) {
  return {std::move(name), Thinned(y, kStride), x};
}

// A marker seen by both, each by itself: a camera's scale, turn and view are the map's.
Pairing OfMarkers(const Movement& a, const Movement& b) {
  const Band band = BandOf(a, b);
  Pairing pairing{.y_is_a = a.dimensions < b.dimensions, .most_unexplained = kOfMarkers};
  const Movement &y = pairing.y_is_a ? a : b, &x = pairing.y_is_a ? b : a;
  for (const std::size_t marker : MovingMarkers(y, y.names.size(), band)) {
    const auto same = std::ranges::find(x.names, y.names[marker]);
    const auto index = static_cast<std::size_t>(same - x.names.begin());
    if (same == x.names.end() || pairing.parts.size() == kMostMarkers || !IsMostlyKnown(x, index)) continue;
    pairing.parts.push_back(
        MakePart(y.names[marker], Derivative(MarkerSeries(y, marker, band)), Derivative(MarkerSeries(x, index, band))));
  }
  if (!pairing.parts.empty()) return pairing;
  const auto components = [&](const Movement& movement) {
    return PrincipalComponents(
        Derivative(AllMarkers(movement, MovingMarkers(movement, kMostMarkers, band), false, band)));
  };
  pairing.parts.push_back(MakePart("all markers", components(y), components(x)));
  return pairing;
}

// Of the direction from one marker to another: how fast it turns in the plane; in space, in the vertical plane in which
// it turns most.
Series TurningRate(const Movement& movement, std::size_t from, std::size_t to, const Band& band) {
  const Series between =
      Sample(movement.time_s, ColumnsOf(movement, to) - ColumnsOf(movement, from), band.cutoff_hz, band.step_s);
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
  Series plane = between;
  plane.value = direction;
  Series rate = Derivative(plane);
  const Eigen::MatrixX2d slope = rate.value;
  rate.value.resize(slope.rows(), 1);
  for (Index i = 0; i < slope.rows(); ++i) {
    const double square = direction.row(i).squaredNorm();
    rate.value(i, 0) = square > 0 ? (direction(i, 0) * slope(i, 1) - direction(i, 1) * slope(i, 0)) / square : 0;
  }
  return rate;
}

// The segment that carries the sensor is not known: each pair of markers is tried.
std::vector<Pairing> OfSegments(const Movement& markers, const Movement& sensor, bool markers_are_a) {
  const Band band = BandOf(markers, sensor);
  const Series rates = Sample(sensor.time_s, sensor.values, band.cutoff_hz, band.step_s);
  std::vector<std::size_t> moving = MovingMarkers(markers, kMostMarkers, band);
  if (moving.size() < 2)
    throw Fail("{}: one marker shows no segment that turns, as a sensor of angular rates does: it takes two",
               markers.file.string());
  std::vector<Pairing> pairings;
  for (std::size_t i = 0; i < moving.size(); ++i)
    for (std::size_t k = i + 1; k < moving.size(); ++k) {
      Pairing& pairing = pairings.emplace_back(Pairing{.y_is_a = markers_are_a, .most_unexplained = kOfSensor});
      pairing.parts.push_back(MakePart(fmt::format("{} to {}", markers.names[moving[i]], markers.names[moving[k]]),
                                       TurningRate(markers, moving[i], moving[k], band), rates));
    }
  return pairings;
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
Pairing OfForces(const Movement& markers, const Movement& forces, bool markers_are_a) {
  const Band band = BandOf(markers, forces);
  Pairing pairing{.y_is_a = !markers_are_a, .most_unexplained = kOfForces};
  Series force = Sample(forces.time_s, forces.values, band.cutoff_hz, band.step_s);
  KeepOnTheFeet(forces.file, force);
  const std::vector<std::size_t> moving = MovingMarkers(markers, markers.names.size(), band);
  Series height = AllMarkers(markers, moving, true, band);
  height.value = height.value.rowwise().mean().eval();
  pairing.parts.push_back(MakePart("vertical force", force, Derivative(Derivative(height))));
  return pairing;
}

Pairing OfSameKind(const Movement& a, const Movement& b, bool of_changes, const char* name) {
  const Band band = BandOf(a, b);
  const auto series = [&](const Movement& movement) {
    const Series values = Sample(movement.time_s, movement.values, band.cutoff_hz, band.step_s);
    return of_changes ? Derivative(values) : values;
  };
  Pairing pairing{.most_unexplained = of_changes ? kOfMarkers : kOfSensor};
  pairing.parts.push_back(MakePart(name, series(b), series(a)));
  return pairing;
}

}  // namespace

std::vector<Pairing> PairingsOf(const Movement& a, const Movement& b) {
  using enum MovementKind;
  const auto are = [&](MovementKind first, MovementKind second) { return a.kind == first && b.kind == second; };
  if (are(kMarkers, kMarkers)) return {OfMarkers(a, b)};
  if (are(kMarkers, kInertial)) return OfSegments(a, b, true);
  if (are(kInertial, kMarkers)) return OfSegments(b, a, false);
  if (are(kMarkers, kForces)) return {OfForces(a, b, true)};
  if (are(kForces, kMarkers)) return {OfForces(b, a, false)};
  if (are(kForces, kForces)) return {OfSameKind(a, b, true, "vertical force")};
  if (are(kInertial, kInertial)) return {OfSameKind(a, b, false, "angular rates")};
  throw Fail(
      "{} and {}: ground forces and an inertial sensor show no common movement; align each with a recording of "
      "markers, or give a signal that both have (--signal-a, --signal-b)",
      a.file.string(), b.file.string());
}

}  // namespace lake::sync
