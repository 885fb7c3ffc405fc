#include "marker_curves.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "lake/core/cross.h"
#include "lake/core/statistics.h"
#include "lake/dynamics/path_smoother.h"
#include "sizes.h"

namespace lake::gait {
namespace {

using dynamics::SigmaTrust, dynamics::LearningOptions, dynamics::MotionPrior, dynamics::PathModel, dynamics::SeenPath,
    dynamics::DistancePrior, dynamics::PathPoint, dynamics::SmoothedPath;
using Curves = std::array<MarkerCurve, kLegMarkers>;

// Frames [begin, end).
struct Range {
  std::size_t begin, end;
};

// The frames in which a marker is hidden between frames in which it is seen, with as much to each side as the path
// needs to be known there.
std::vector<Range> HiddenRanges(const SeenPath& seen) {
  constexpr double kMargin_s = 0.5;
  constexpr std::size_t kMargin = 8;  // frames, at least
  std::vector<Range> ranges;
  const std::size_t n = seen.sigma.size();
  std::size_t last = n;
  for (std::size_t i = 0; i < n; ++i) {
    if (!seen.IsSeen(i)) continue;
    if (last < n && i > last + 1) {
      std::size_t begin = last - std::min(last, kMargin), end = std::min(n, i + kMargin + 1);
      while (begin > 0 && seen.time_s[begin] > seen.time_s[last] - kMargin_s) --begin;
      while (end < n && seen.time_s[end - 1] < seen.time_s[i] + kMargin_s) ++end;
      if (!ranges.empty() && begin < ranges.back().end)
        ranges.back().end = end;
      else
        ranges.push_back({begin, end});
    }
    last = i;
  }
  return ranges;
}

// The distance between two markers, where both are seen; nullopt in fewer frames than a curve needs.
std::optional<DistancePrior> DistanceBetween(const SeenPath& own_seen, const MarkerCurve& own,
                                             const SeenPath& other_seen, const MarkerCurve& other) {
  constexpr double kLeastVariation = 1e-3;  // of the length
  constexpr double kLeastMemory_s = 0.05, kMostMemory_s = 10;
  const std::size_t n = own.point.size();
  std::vector<double> lengths, rates;
  DistancePrior distance;
  distance.deviation.assign(n, NAN);
  distance.deviation_sigma.assign(n, NAN);
  for (std::size_t i = 0; i < n; ++i) {
    // A hidden neighbour errs alike for many frames, so it says little.
    distance.other.push_back(other_seen.IsSeen(i) ? other.point[i].position : Eigen::Vector3d::Constant(NAN));
    distance.other_covariance.push_back(other.point[i].position_covariance);
    if (!own_seen.IsSeen(i) || !other_seen.IsSeen(i)) continue;
    const Eigen::Vector3d apart = own.point[i].position - other.point[i].position,
                          speed = own.point[i].velocity - other.point[i].velocity;
    lengths.push_back(distance.deviation[i] = apart.norm());
    const Eigen::Vector3d along = apart.normalized();
    distance.deviation_sigma[i] =
        std::sqrt(along.dot((own.point[i].position_covariance + other.point[i].position_covariance) * along));
    rates.push_back(speed.dot(along));
  }
  if (lengths.size() < kLeastFrames) return std::nullopt;
  distance.length = Mean(lengths);
  for (double& deviation : distance.deviation) deviation -= distance.length;
  distance.sigma = std::max(StandardDeviation(lengths), kLeastVariation * distance.length);
  distance.memory_s = std::clamp(std::sqrt(3) * distance.sigma / RootMeanSquare(rates), kLeastMemory_s, kMostMemory_s);
  // Few changes of the length were seen: the hidden one may be larger.
  const double seen_s = static_cast<double>(lengths.size()) * MedianInterval(own_seen.time_s);
  distance.sigma *= std::sqrt(1 + 12 * distance.memory_s / seen_s);
  return distance;
}

// The two places with the given distances to two points are mirror images; that on the given side of the line from the
// first to the second.
Eigen::Vector3d BetweenTwo(const Eigen::Vector3d& first, const Eigen::Vector3d& second, double to_first,
                           double to_second, double side, double z) {
  const Eigen::Vector2d line = (second - first).head<2>();
  const double length = std::max(line.norm(), 1e-9),
               along = (to_first * to_first - to_second * to_second + length * length) / (2 * length),
               across = std::sqrt(std::max(0.0, to_first * to_first - along * along));
  const Eigen::Vector2d unit = line / length, normal(-unit.y(), unit.x());
  const Eigen::Vector2d place = first.head<2>() + along * unit - std::copysign(across, side) * normal;
  return {place.x(), place.y(), z};
}

class Bridge {
 public:
  Bridge(std::span<const SeenPath> seen, std::size_t marker, const Curves& curves)
      : seen_(seen), marker_(marker), curves_(curves) {
    for (const motion::Segment& segment : motion::kSegments) {
      if (segment.lower != marker && segment.upper != marker) continue;
      const std::size_t other = segment.lower == marker ? segment.upper : segment.lower;
      if (other >= seen.size()) continue;
      if (auto distance = DistanceBetween(seen[marker], curves[marker], seen[other], curves[other])) {
        distances_.push_back(*std::move(distance));
        others_.push_back(other);
      }
    }
    if (distances_.size() < 2) return;
    for (std::size_t i = 0; i < seen[marker].sigma.size(); ++i)
      if (seen[marker].IsSeen(i) && seen[others_[0]].IsSeen(i) && seen[others_[1]].IsSeen(i))
        side_ += Cross((curves[marker].point[i].position - distances_[0].other[i]).head<2>(),
                       (distances_[1].other[i] - distances_[0].other[i]).head<2>());
  }

  std::span<const DistancePrior> Distances() const { return distances_; }

  // Where the marker's place is looked for first. Its own bridge may lead over a gap of seconds to either side.
  PathPoint NearPlace(std::size_t frame) const {
    constexpr double kCertain = 0.05;  // of a segment's length
    const PathPoint& point = curves_[marker_].point[frame];
    if (distances_.size() < 2 || seen_[marker_].IsSeen(frame) || !seen_[others_[0]].IsSeen(frame) ||
        !seen_[others_[1]].IsSeen(frame) ||
        curves_[marker_].plane_sigma[frame] < kCertain * std::min(distances_[0].length, distances_[1].length))
      return point;
    PathPoint between;
    between.position = BetweenTwo(distances_[0].other[frame], distances_[1].other[frame], distances_[0].length,
                                  distances_[1].length, side_, point.position.z());
    return between;
  }

 private:
  std::span<const SeenPath> seen_;
  std::size_t marker_;
  const Curves& curves_;
  std::vector<DistancePrior> distances_;
  std::vector<std::size_t> others_;
  double side_ = 0;
};

// Where a marker is not seen between frames in which it is, its path keeps the distances to its neighbours in the leg:
// a distance is the segment's mean length and a slow change whose size and speed are those of the frames in which both
// ends are seen. A joint between two seen neighbours lies on the side to which it bends in the other frames.
void BridgeHiddenMarkers(std::span<const SeenPath> seen, std::span<const dynamics::PathModel> models,
                         const dynamics::MotionPrior& prior, Curves& curves) {
  constexpr int kIterations = 4;  // of the linearised distances
  for (std::size_t m = 0; m < seen.size(); ++m) {
    const std::vector<Range> ranges = HiddenRanges(seen[m]);
    if (ranges.empty()) continue;
    const Bridge bridge(seen, m, curves);
    if (bridge.Distances().empty()) continue;
    for (const Range& range : ranges) {
      std::vector<PathPoint> near;
      for (std::size_t i = range.begin; i < range.end; ++i) near.push_back(bridge.NearPlace(i));
      dynamics::SmoothedPath path;
      for (int iteration = 0; iteration < kIterations; ++iteration) {
        path = dynamics::BridgePath(seen[m], models[m], prior, bridge.Distances(), near, range.begin, range.end);
        for (std::size_t k = 0; k < near.size(); ++k) near[k] = path.point[k];
      }
      for (std::size_t i = range.begin; i < range.end; ++i)
        if (!seen[m].IsSeen(i)) {
          curves[m].point[i] = path.point[i - range.begin];
          curves[m].plane_sigma[i] = PlaneSigma(curves[m].point[i]);
        }
    }
  }
}

SeenPath MakeSeen(const std::vector<double>& time_s, const Detections& d) {
  SeenPath seen = dynamics::UnseenPath(d.lateral.empty() ? 2 : 3, time_s);
  for (std::size_t i = 0; i < time_s.size(); ++i)
    if (const double z = d.lateral.empty() ? 0 : d.lateral[i]; d.trusted[i] && std::isfinite(z))
      seen.See(i, d.in_plane[i], d.plane_sigma[i], z);
  return seen;
}

double PlaneUnitsPerPixel(const Detections& d, std::size_t i) {
  return d.plane_sigma[i] / d.sigma[i];
}

LearningOptions LearningFor(std::span<const Detections> markers, double unit_mm, const LegFitOptions& options) {
  LearningOptions learning{.unit_mm = unit_mm};
  const bool are_stated = std::ranges::all_of(markers, &Detections::has_sigmas);
  learning.trust = options.known_sigmas ? SigmaTrust::kFull : are_stated ? SigmaTrust::kScale : SigmaTrust::kNone;
  learning.lasting_share = options.lasting_share;
  return learning;
}

double ScatterAt(const SeenPath& seen, const PathModel& model, std::size_t i) {
  return seen.IsSeen(i)
             ? std::sqrt(model.WhiteVariance(i, seen.sigma[i]) / (seen.sigma[i] * seen.sigma[i]) + model.lasting)
             : std::sqrt(model.white + model.jitter + model.lasting);
}

// Mistrusts detections that are far from what all others predict, and farther than those beside them; returns whether
// there are any.
bool MistrustSuspects(const SmoothedPath& path, Detections& d) {
  constexpr double kSuspicious = 5;  // standard deviations
  constexpr double kJump = 0.5;      // of what skin and a foot that strikes may do, as neighbours share it
  constexpr std::size_t kReach = 1;  // frames to each side; a false suspect is let in again
  const std::size_t n = d.seen.size();
  std::vector<double> excess(n, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    if (d.trusted[i] && path.surprise_variance[i] > 0)
      excess[i] = path.surprise[i].norm() - kJump * d.jump[i] * PlaneUnitsPerPixel(d, i) -
                  kSuspicious * std::sqrt(path.surprise_variance[i]);
  bool found = false;
  for (std::size_t i = 0; i < n; ++i) {
    const auto begin = excess.begin() + static_cast<std::ptrdiff_t>(i - std::min(i, kReach)),
               end = excess.begin() + static_cast<std::ptrdiff_t>(std::min(n, i + kReach + 1));
    if (excess[i] <= 0 || excess[i] < *std::max_element(begin, end)) continue;
    d.trusted[i] = 0;
    found = true;
  }
  return found;
}

// How likely a detection that is not trusted is of its marker nonetheless: by how the others predict it, but for what
// skin and a foot that strikes may do at once, against something else anywhere in `area`.
double ChanceOfMarker(const Detections& d, std::size_t i, const dynamics::PathPoint& predicted, double scatter,
                      double area) {
  const Eigen::Vector2d residual = d.in_plane[i] - predicted.position.head<2>();
  const double jump = d.jump[i] * PlaneUnitsPerPixel(d, i);
  const Eigen::Vector2d surprise = std::max(0.0, 1 - jump / residual.norm()) * residual;
  const Eigen::Matrix2d variance = predicted.position_covariance.topLeftCorner<2, 2>() +
                                   std::pow(scatter * d.plane_sigma[i], 2) * Eigen::Matrix2d::Identity();
  const double density = std::exp(-surprise.dot(variance.inverse() * surprise) / 2) /
                         (2 * std::numbers::pi * std::sqrt(variance.determinant()));
  return (1 - kOfSomethingElse) * density / ((1 - kOfSomethingElse) * density + kOfSomethingElse / area);
}

double AreaOf(std::span<Detections> markers) {
  Eigen::AlignedBox2d box;
  for (const Detections& d : markers)
    for (std::size_t i = 0; i < d.trusted.size(); ++i)
      if (d.trusted[i]) box.extend(d.in_plane[i]);
  return std::max(box.volume(), 1e-9);
}

// Trusts detections that the curves without them make likely; that they may be something else widens their sigmas.
// Returns whether there are any.
bool LetIn(std::span<const MarkerCurve> curves, std::span<Detections> markers) {
  const double area = AreaOf(markers);
  bool found = false;
  for (std::size_t m = 0; m < markers.size(); ++m) {
    Detections& d = markers[m];
    for (std::size_t i = 0; i < d.seen.size(); ++i) {
      if (!d.seen[i] || d.trusted[i]) continue;
      const double chance = ChanceOfMarker(d, i, curves[m].point[i], curves[m].scatter[i], area);
      if (chance <= 0.5) continue;
      const double doubt = std::sqrt(1 - chance) * (d.in_plane[i] - curves[m].InPlane(i)).norm();
      const double scale = PlaneUnitsPerPixel(d, i);
      d.plane_sigma[i] = std::hypot(d.plane_sigma[i], doubt);
      d.sigma[i] = d.plane_sigma[i] / scale;
      d.trusted[i] = 1;
      found = true;
    }
  }
  return found;
}

// A model without what is quicker than nine tenths of the movement: that may be outliers.
PathModel Usual(const SeenPath& seen, PathModel model) {
  std::vector<double> densities;
  for (std::size_t i = 0; i < seen.sigma.size(); ++i)
    if (seen.IsSeen(i)) densities.push_back(model.density[i]);
  const double most = Quantile(std::move(densities), 0.9);
  for (double& density : model.density) density = std::min(density, most);
  return model;
}

// Markers whose noise is alike.
class Smoothing {
 public:
  Smoothing(const std::vector<double>& time_s, std::span<Detections> markers, double unit_mm,
            const LegFitOptions& options)
      : time_s_(time_s),
        markers_(markers),
        prior_(dynamics::PersonPrior(unit_mm)),
        learning_(LearningFor(markers, unit_mm, options)) {}

  // Learns from what is left without the suspects.
  void Run() {
    constexpr int kMostRounds = 8;
    for (int round = 0;; ++round) {
      Learn();
      bool found = false;
      for (std::size_t m = 0; m < markers_.size() && round < kMostRounds; ++m)
        found |= MistrustSuspects(dynamics::SmoothPath(seen_[m], Usual(seen_[m], models_[m]), prior_), markers_[m]);
      if (!found) return;
    }
  }

  void Learn() {
    seen_.clear();
    for (const Detections& d : markers_) seen_.push_back(MakeSeen(time_s_, d));
    models_ = dynamics::LearnPaths(seen_, prior_, learning_);
  }

  MarkerCurve Curve(std::size_t m) const {
    MarkerCurve curve;
    curve.point = dynamics::SmoothPath(seen_[m], models_[m], prior_).point;
    for (std::size_t i = 0; i < time_s_.size(); ++i) curve.scatter.push_back(ScatterAt(seen_[m], models_[m], i));
    for (const dynamics::PathPoint& point : curve.point) curve.plane_sigma.push_back(PlaneSigma(point));
    return curve;
  }

  const std::vector<SeenPath>& Seen() const { return seen_; }
  const std::vector<PathModel>& Models() const { return models_; }
  const MotionPrior& Prior() const { return prior_; }

 private:
  const std::vector<double>& time_s_;
  std::span<Detections> markers_;
  MotionPrior prior_;
  LearningOptions learning_;
  std::vector<SeenPath> seen_;
  std::vector<PathModel> models_;
};

// What the smoothing takes for the marker's own movement; what lasts of the noise is part of a rebuilt place's error.
void AddRebuiltErrors(const Detections& d, const PathModel& model, MarkerCurve& curve) {
  for (std::size_t i = 0; i < curve.point.size(); ++i) {
    if (!d.IsRebuilt(i)) continue;
    const double lasting = model.lasting * d.plane_sigma[i] * d.plane_sigma[i],
                 variance = std::max(0.0, d.rebuilt_sd[i] * d.rebuilt_sd[i] - lasting);
    curve.point[i].position_covariance += variance * Eigen::Matrix3d::Identity();
    curve.point[i].velocity_variance += variance / (kRebuiltMemory_s * kRebuiltMemory_s);
    curve.plane_sigma[i] = PlaneSigma(curve.point[i]);
  }
}

void Project(const LegView& view, double depth_mm, MarkerCurve& curve) {
  for (std::size_t i = 0; i < curve.point.size(); ++i) {
    const Eigen::Vector2d in_plane = curve.InPlane(i);
    curve.recorded.push_back(RecordedFromPlane<double>(view, in_plane, depth_mm));
    curve.recorded_sigma.push_back(curve.plane_sigma[i] / PlaneUnitsPerRecorded(view, in_plane, depth_mm));
  }
}

double ShankOf(const std::array<Detections, kLegMarkers>& leg) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < leg[kAnkle].trusted.size(); ++i)
    if (leg[kAnkle].trusted[i] && leg[kKnee].trusted[i])
      lengths.push_back((leg[kKnee].in_plane[i] - leg[kAnkle].in_plane[i]).norm());
  return Median(std::move(lengths));
}

double MedianCutoffHz(const SeenPath& seen, const PathModel& model) {
  std::vector<double> cutoffs_hz;
  for (std::size_t i = 1; i < seen.time_s.size(); ++i)
    if (seen.IsSeen(i))
      cutoffs_hz.push_back(dynamics::CutoffOfDensity(model.density[i], ScatterAt(seen, model, i) * seen.sigma[i],
                                                     seen.time_s[i] - seen.time_s[i - 1]));
  return Median(std::move(cutoffs_hz));
}

}  // namespace

double PlaneSigma(const dynamics::PathPoint& point) {
  return std::sqrt(point.position_covariance.topLeftCorner<2, 2>().trace() / 2);
}

double UnitMm(const LegView& view, double shank) {
  constexpr double kUsualShank_mm = 400;
  return PlaneUnit(view) == motion::LengthUnit::kMm ? 1 : kUsualShank_mm / shank;
}

LegMarkerCurves SmoothLeg(const std::vector<double>& time_s, int markers, const LegView& view,
                          const LegFitOptions& options, std::array<Detections, kLegMarkers>& leg) {
  const std::span<Detections> used(leg.data(), static_cast<std::size_t>(markers));
  Smoothing smoothing(time_s, used, UnitMm(view, ShankOf(leg)), options);
  LegMarkerCurves curves;
  const auto set = [&] {
    for (std::size_t m = 0; m < used.size(); ++m) curves.marker[m] = smoothing.Curve(m);
    BridgeHiddenMarkers(smoothing.Seen(), smoothing.Models(), smoothing.Prior(), curves.marker);
  };
  smoothing.Run();
  set();
  if (LetIn(std::span(curves.marker).first(used.size()), used)) {
    smoothing.Learn();
    set();
  }
  for (std::size_t m = 0; m < used.size(); ++m) {
    AddRebuiltErrors(used[m], smoothing.Models()[m], curves.marker[m]);
    Project(view, used[m].depth_mm, curves.marker[m]);
  }
  const PathModel& knee = smoothing.Models()[kKnee];
  curves.lasting_share = knee.lasting / (knee.white + knee.lasting);
  curves.noise_memory_s = knee.memory_s;
  curves.cutoff_hz = MedianCutoffHz(smoothing.Seen()[kKnee], knee);
  return curves;
}

MarkerCurve SmoothMarker(const std::vector<double>& time_s, const LegView& view, const LegFitOptions& options,
                         double unit_mm, Detections& detections) {
  const std::span<Detections> used(&detections, 1);
  Smoothing smoothing(time_s, used, unit_mm, options);
  smoothing.Run();
  MarkerCurve curve = smoothing.Curve(0);
  if (LetIn({&curve, 1}, used)) {
    smoothing.Learn();
    curve = smoothing.Curve(0);
  }
  Project(view, detections.depth_mm, curve);
  return curve;
}

}  // namespace lake::gait
