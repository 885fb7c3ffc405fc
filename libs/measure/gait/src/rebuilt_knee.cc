#include "rebuilt_knee.h"

#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/gait/plausibility.h"
#include "segment_knee.h"

namespace lake::gait {
namespace {

using Eigen::Matrix3Xd, Eigen::Vector2d, Eigen::Vector3d;

// Where markers carry the knee in one frame, in the leg's axes.
struct Carried {
  Vector3d place = Vector3d::Constant(kNaN);
  Eigen::Matrix3d turn;         // leg from segment
  double sd = kNaN, noise = 0;  // what lasts, and what the markers' noise makes; per axis
  double flexion_deg = kNaN;

  bool IsKnown() const { return place.allFinite(); }
};

// How far markers may move against each other in one frame, root mean square along each axis.
double MostStrain(const SegmentKnee& segment) {
  constexpr double kLeast_mm = 6, kDeviations = 4;
  return std::max(kLeast_mm, kDeviations * segment.strain_mm);
}

// Poses the segment, one by one without the marker that is farthest off its place, until the rest keep theirs; the
// places that are left out become unknown.
dynamics::Pose PoseInFrame(const SegmentKnee& segment, Matrix3Xd& places) {
  for (;;) {
    dynamics::Pose pose = dynamics::PoseOf(segment.shape_mm, places, NormalOf(segment.in_space));
    if (!pose.IsSeen() || StrainOf(segment, pose, places) <= MostStrain(segment)) return pose;
    double least = kInfinity;
    Eigen::Index farthest = -1;
    for (Eigen::Index m = 0; m < places.cols(); ++m) {
      Matrix3Xd rest = places;
      rest.col(m).setConstant(kNaN);
      const dynamics::Pose without = dynamics::PoseOf(segment.shape_mm, rest, NormalOf(segment.in_space));
      const double strain =
          without.IsSeen() && places.col(m).allFinite() ? StrainOf(segment, without, rest) : kInfinity;
      if (strain < least) {
        least = strain;
        farthest = m;
      }
    }
    if (farthest < 0) return {};
    places.col(farthest).setConstant(kNaN);
  }
}

// A segment over all frames.
struct SegmentCourse {
  std::vector<Carried> carried;
  std::vector<std::vector<char>> left_out;  // by marker, by frame: the others keep their places
  std::vector<char> lost;                   // frames that show enough markers, and which of them moved is not told
  std::vector<double> seen;                 // frames, by marker
  double strain_mm = 0;                     // root mean square over the frames
  std::ptrdiff_t shown = 0, posed = 0;      // frames that show enough markers, and those that have them in their places
};

// What an error of each marker makes of a point of the segment, per axis in the plane.
double PointShare(const Matrix3Xd& shape, const Matrix3Xd& places, const Vector3d& point) {
  std::vector<Eigen::Index> seen;
  for (Eigen::Index m = 0; m < places.cols(); ++m)
    if (places.col(m).allFinite()) seen.push_back(m);
  Matrix3Xd of = shape(Eigen::all, seen);
  const Vector3d mean = of.rowwise().mean();
  of.colwise() -= mean;
  return std::sqrt(1 / static_cast<double>(seen.size()) +
                   (point - mean).head<2>().squaredNorm() / (2 * of.topRows<2>().squaredNorm()));
}

SegmentCourse Follow(const LearntKnee& learnt, const SegmentKnee& segment, const LegPlaces& places,
                     const LegMarkers& names, std::size_t frames) {
  constexpr int kIterations = 12;  // knee and flexion together; a degree moves the knee by a hundredth of the thigh's
  const KneeSegment& row = KneeSegmentOf(segment.segment);
  const auto other = places.find(names.*row.other);
  SegmentCourse course;
  course.carried.resize(frames);
  course.left_out.assign(segment.markers.size(), std::vector<char>(frames, 0));
  course.lost.assign(frames, 0);
  course.seen.assign(segment.markers.size(), 0);
  double square = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    Matrix3Xd now = PlacesAt(places, segment.markers, i);
    const Matrix3Xd all = now;
    const bool is_shown = dynamics::PoseOf(segment.shape_mm, now, NormalOf(segment.in_space)).IsSeen();
    const dynamics::Pose pose = PoseInFrame(segment, now);
    course.shown += is_shown;
    course.lost[i] = is_shown && !pose.IsSeen();
    double noise = 0, used = 0;
    for (std::size_t m = 0; m < segment.markers.size(); ++m) {
      const auto column = static_cast<Eigen::Index>(m);
      if (!all.col(column).allFinite()) continue;
      ++course.seen[m];
      course.left_out[m][i] = pose.IsSeen() && !now.col(column).allFinite();
      if (course.left_out[m][i]) continue;
      noise += std::pow(places.at(segment.markers[m]).noise[i], 2);
      ++used;
    }
    if (!pose.IsSeen()) continue;
    ++course.posed;
    square += std::pow(StrainOf(segment, pose, now), 2);
    const Vector3d far_end = pose.turn.transpose() * (other->second.place[i] - pose.origin);
    if (!far_end.allFinite()) continue;
    Carried& carried = course.carried[i];
    carried.flexion_deg = (learnt.from_deg + learnt.to_deg) / 2;
    KneeAt knee;
    for (int k = 0; k < kIterations; ++k) {
      knee = KneeAtFlexion(learnt, segment, carried.flexion_deg);
      carried.flexion_deg = FlexionDeg(row, knee.place, far_end);
    }
    carried.place = pose.origin + pose.turn * knee.place;
    carried.turn = pose.turn;
    carried.sd = knee.sd;
    carried.noise = std::sqrt(noise / used) * PointShare(segment.shape_mm, now, knee.place);
  }
  course.strain_mm = std::sqrt(square / static_cast<double>(std::max<std::ptrdiff_t>(1, course.posed)));
  // Markers that keep their places clearly less well than when they were learnt may have been put on again beside them.
  constexpr double kUsual = 1.5;  // from one repetition to another
  const double more = std::sqrt(std::max(0.0, std::pow(course.strain_mm, 2) - std::pow(kUsual * segment.strain_mm, 2)));
  for (Carried& carried : course.carried)
    if (carried.IsKnown())
      carried.sd =
          std::hypot(carried.sd, more * PointShare(segment.shape_mm, segment.shape_mm, segment.knee_mm.col(0)));
  return course;
}

// The mean of both by what is known of each, with correlated errors.
Carried Combined(const Carried& a, const Carried& b, double correlation) {
  if (!a.IsKnown() || !b.IsKnown()) return a.IsKnown() ? a : b;
  const double common = correlation * a.sd * b.sd, variance_a = a.sd * a.sd, variance_b = b.sd * b.sd;
  const double weight = std::clamp((variance_b - common) / (variance_a + variance_b - 2 * common), 0.0, 1.0);
  Carried mean = a;
  mean.place = weight * a.place + (1 - weight) * b.place;
  mean.sd = std::sqrt(weight * weight * variance_a + (1 - weight) * (1 - weight) * variance_b +
                      2 * weight * (1 - weight) * common);
  mean.noise = std::hypot(weight * a.noise, (1 - weight) * b.noise);
  return mean;
}

std::string DistanceText(const SegmentKnee& segment, const LegPlaces& places, std::size_t frames) {
  double most = 0;
  std::string text;
  for (std::size_t a = 0; a < segment.markers.size(); ++a)
    for (std::size_t b = a + 1; b < segment.markers.size(); ++b) {
      std::vector<double> distances;
      for (std::size_t i = 0; i < frames; ++i) {
        const Matrix3Xd at = PlacesAt(places, {segment.markers[a], segment.markers[b]}, i);
        const Vector3d apart = at.col(1) - at.col(0);
        if (apart.allFinite()) distances.push_back(segment.in_space ? apart.norm() : apart.head<2>().norm());
      }
      const Vector3d then =
          segment.shape_mm.col(static_cast<Eigen::Index>(b)) - segment.shape_mm.col(static_cast<Eigen::Index>(a));
      const double then_mm = segment.in_space ? then.norm() : then.head<2>().norm();
      if (distances.empty()) continue;
      const double now_mm = Median(std::move(distances));
      if (std::abs(now_mm - then_mm) < most) continue;
      most = std::abs(now_mm - then_mm);
      text = fmt::format("'{}' and '{}' are {:.0f} mm apart, {:.0f} mm there", segment.markers[a], segment.markers[b],
                         now_mm, then_mm);
    }
  return text;
}

// Two names whose exchange puts the markers in their places.
std::optional<std::string> ExchangeOf(const LearntKnee& learnt, const SegmentKnee& segment, const LegPlaces& places,
                                      const LegMarkers& names, std::size_t frames) {
  for (std::size_t a = 0; a < segment.markers.size(); ++a)
    for (std::size_t b = a + 1; b < segment.markers.size(); ++b) {
      LegPlaces exchanged = places;
      std::swap(exchanged[segment.markers[a]], exchanged[segment.markers[b]]);
      const SegmentCourse course = Follow(learnt, segment, exchanged, names, frames);
      const auto out = std::ranges::count(course.left_out[a], 1) + std::ranges::count(course.left_out[b], 1);
      if (10 * course.posed > 9 * course.shown && out < course.posed / 10)
        return fmt::format("'{}' and '{}'", segment.markers[a], segment.markers[b]);
    }
  return {};
}

void SayWhereMarkersAre(const LearntKnee& learnt, const SegmentKnee& segment, const SegmentCourse& course,
                        const LegPlaces& places, const LegFitOptions& options, const std::vector<std::int64_t>& frame,
                        std::vector<std::string>& warnings) {
  constexpr double kFew = 0.05;  // of a marker's frames
  bool some_are_out = 2 * course.posed < course.shown;
  for (std::size_t m = 0; m < segment.markers.size(); ++m)
    some_are_out |= static_cast<double>(std::ranges::count(course.left_out[m], 1)) > 0.5 * course.seen[m];
  if (some_are_out)
    if (const auto exchanged = ExchangeOf(learnt, segment, places, options.markers, frame.size()))
      throw Fail(
          "the technical markers {} of the {} are exchanged: their distances are those of {} the other way round; "
          "put their names right, {}",
          *exchanged, segment.segment, learnt.trial, options.ways_out);
  if (2 * course.posed < course.shown)
    throw Fail(
        "the technical markers of the {} are not where they were in {}: {}; are both trials of the same leg, and "
        "were the markers left on?",
        segment.segment, learnt.trial, DistanceText(segment, places, frame.size()));
  for (std::size_t m = 0; m < segment.markers.size(); ++m)
    if (static_cast<double>(std::ranges::count(course.left_out[m], 1)) > kFew * course.seen[m])
      warnings.push_back(fmt::format(
          "frames {}: '{}' is not where it was on the {} in {}: has it come off, or was it put on again? It "
          "is left out there",
          FramesOf(frame, course.left_out[m]), segment.markers[m], segment.segment, learnt.trial));
  if (static_cast<double>(std::ranges::count(course.lost, 1)) > kFew * static_cast<double>(course.shown))
    warnings.push_back(
        fmt::format("frames {}: the technical markers of the {} are not where they were in {}, and too few are left to "
                    "tell which: has one come off? The knee is not rebuilt there",
                    FramesOf(frame, course.lost), segment.segment, learnt.trial));
  constexpr double kChanged_mm = 2;
  if (course.strain_mm > kChanged_mm + segment.strain_mm)
    warnings.push_back(fmt::format(
        "the technical markers of the {} have moved against each other since {} ({}): the rebuilt knee's standard "
        "deviation holds that",
        segment.segment, learnt.trial, DistanceText(segment, places, frame.size())));
}

// What the seen frames say of the rebuilt ones' errors, in the segment's axes.
class SeenErrors {
 public:
  SeenErrors(const std::vector<double>& time_s, const std::vector<Carried>& carried, const Detections& knee,
             const std::vector<Vector3d>& seen, double memory_s)
      : time_s_(time_s), memory_s_(memory_s), error_(time_s.size(), Vector3d::Constant(kNaN)) {
    std::vector<double> variances, xs, ys;
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      if (!knee.trusted[i] || !carried[i].IsKnown()) continue;
      error_[i] = carried[i].turn.transpose() * (seen[i] - carried[i].place);
      frames_.push_back(i);
      mean_ += error_[i];
      square_ += error_[i].head<2>().squaredNorm();
      variances.push_back(carried[i].sd * carried[i].sd);
    }
    if (frames_.empty()) return;
    const double count = static_cast<double>(frames_.size());
    mean_ /= count;
    square_ /= count;
    // Errors stay alike for the memory's time: so many of them are independent.
    const double independent = 1 + count * MedianInterval(time_s) / (2 * memory_s);
    const double expected = 2 * lake::Mean(variances) / independent;  // of the mean's square, over both axes
    shift_share_ = std::max(0.0, 1 - expected / std::max(1e-12, mean_.head<2>().squaredNorm()));
    shift_ = shift_share_ * mean_;
    constexpr double kDiffers = 0.25;  // of the shift, where the flexion is another
    shift_variance_ = (shift_share_ * expected + kDiffers * kDiffers * shift_.head<2>().squaredNorm()) / 2;
  }

  std::size_t Frames() const { return frames_.size(); }
  Vector2d Mean() const { return mean_.head<2>(); }
  double Rms() const { return std::sqrt(square_); }

  // An error that decays from the seen frames before and after (Ornstein–Uhlenbeck bridge) to the mean shift.
  void Correct(std::size_t i, Carried& carried) const {
    const auto after = std::ranges::upper_bound(frames_, i);
    const double a = after == frames_.begin() ? 0 : Alike(*std::prev(after), i),
                 b = after == frames_.end() ? 0 : Alike(*after, i), both = a * b;
    const double before_weight = (a - b * both) / (1 - both * both), after_weight = (b - a * both) / (1 - both * both);
    Vector3d correction = shift_;
    if (a > 0) correction += before_weight * (error_[*std::prev(after)] - shift_);
    if (b > 0) correction += after_weight * (error_[*after] - shift_);
    const double unseen = std::max(0.0, 1 - (before_weight * a + after_weight * b));
    carried.place += carried.turn * correction;
    carried.sd = std::sqrt(carried.sd * carried.sd * unseen + shift_variance_ * unseen);
  }

 private:
  double Alike(std::size_t one, std::size_t other) const {
    return std::exp(-std::abs(time_s_[one] - time_s_[other]) / memory_s_);
  }

  const std::vector<double>& time_s_;
  double memory_s_;
  std::vector<Vector3d> error_;
  std::vector<std::size_t> frames_;
  Vector3d mean_ = Vector3d::Zero(), shift_ = Vector3d::Zero();
  double square_ = 0, shift_share_ = 0, shift_variance_ = 0;
};

// The markers that are needed, in the leg's axes of one facing.
class Places {
 public:
  Places(const LearntKnee& learnt, const motion::MarkerRecording& recording, const LegView& view,
         const LateralPlaces& lateral, const LegMarkers& names, const std::array<Detections, kLegMarkers>& leg) {
    detections_ = {{names.ankle, leg[kAnkle]}, {names.hip, leg[kHip]}, {names.knee, leg[kKnee]}};
    for (const SegmentKnee& segment : learnt.segments) {
      std::vector<std::string> absent;
      for (const std::string& marker : segment.markers) {
        const motion::MarkerTrack* track = recording.Find(marker);
        if (!track)
          absent.push_back(marker);
        else if (!detections_.contains(marker))
          detections_[marker] = CollectDetections(recording, *track, view, 0);
        if (const auto across = lateral.find(marker); track && across != lateral.end())
          detections_[marker].lateral = across->second;
      }
      if (segment.markers.size() - absent.size() < (segment.in_space ? 3u : 2u))
        throw Fail("the knee was learnt in {} from {} on the {}, and this trial has no '{}': mark and name {}",
                   learnt.trial, fmt::join(segment.markers, ", "), segment.segment, fmt::join(absent, "', '"),
                   absent.size() == 1 ? "it" : "them");
    }
  }

  LegPlaces InLeg(motion::Facing facing, const Eigen::Vector2d& up) const {
    const double right = facing == motion::Facing::kRight ? 1 : -1;
    LegPlaces places;
    for (const auto& [name, d] : detections_) {
      MarkerPlaces& of = places[name];
      of.noise = d.plane_sigma;
      of.place.assign(d.seen.size(), Vector3d::Constant(kNaN));
      for (std::size_t i = 0; i < d.seen.size(); ++i)
        if (d.trusted[i])
          of.place[i] << LegFromPlane(d.in_plane[i], facing, up), d.lateral.empty() ? 0 : right * d.lateral[i];
    }
    return places;
  }

 private:
  std::map<std::string, Detections> detections_;
};

struct Found {
  motion::Facing facing = motion::Facing::kRight;
  LegPlaces places;
  std::vector<SegmentCourse> courses;
  std::vector<Carried> carried;
  std::ptrdiff_t in_range = 0, known = 0;
};

Found Find(const LearntKnee& learnt, const Places& places, motion::Facing facing, const LegFitOptions& options,
           std::size_t frames) {
  constexpr double kMargin_deg = 10;
  Found found{facing, places.InLeg(facing, options.up), {}, std::vector<Carried>(frames), 0, 0};
  for (const SegmentKnee& segment : learnt.segments) {
    found.courses.push_back(Follow(learnt, segment, found.places, options.markers, frames));
    for (std::size_t i = 0; i < frames; ++i)
      found.carried[i] = Combined(found.carried[i], found.courses.back().carried[i], learnt.correlation);
  }
  for (const Carried& carried : found.carried) {
    found.known += carried.IsKnown();
    found.in_range +=
        carried.flexion_deg > learnt.from_deg - kMargin_deg && carried.flexion_deg < learnt.to_deg + kMargin_deg;
  }
  return found;
}

// Where it is not given, as more of the flexions are in the learnt range.
Found FindFacing(const LearntKnee& learnt, const Places& places, const LegFitOptions& options, std::size_t frames) {
  using motion::Facing;
  Found found = Find(learnt, places, options.facing.value_or(Facing::kRight), options, frames);
  if (options.facing) return found;
  Found left = Find(learnt, places, Facing::kLeft, options, frames);
  return left.in_range > found.in_range ? left : found;
}

}  // namespace

std::optional<CarriedKnee> CarriedKneeIn(const motion::MarkerRecording& frame, const LegView& view,
                                         const LearntKnee& learnt, const std::optional<motion::Facing>& facing) {
  LegFitOptions options;
  options.facing = facing;
  std::array<Detections, kLegMarkers> leg;
  for (const motion::LegMarker m : {kAnkle, kHip}) {
    const motion::MarkerTrack* track = frame.Find(options.markers.Of(m));
    if (!track) return std::nullopt;
    leg[m] = CollectDetections(frame, *track, view, 0);
  }
  const Found found = FindFacing(learnt, Places(learnt, frame, view, {}, options.markers, leg), options, 1);
  if (found.in_range == 0) return std::nullopt;
  return CarriedKnee{PlaneFromLeg(found.carried[0].place.head<2>(), found.facing, options.up), found.facing};
}

RebuiltKnee RebuildKnee(const LearntKnee& learnt, const motion::MarkerRecording& recording, const LegView& view,
                        const LateralPlaces& lateral, const LegFitOptions& options,
                        std::array<Detections, kLegMarkers>& leg, std::vector<std::string>& warnings) {
  if (PlaneUnit(view) != motion::LengthUnit::kMm)
    throw UsageError("--knee-from: lengths are in px; give --scale, or a --camera with the sagittal plane");
  const std::size_t n = recording.Frames();
  const Places places(learnt, recording, view, lateral, options.markers, leg);
  Found found = FindFacing(learnt, places, options, n);
  for (std::size_t s = 0; s < learnt.segments.size(); ++s)
    SayWhereMarkersAre(learnt, learnt.segments[s], found.courses[s], found.places, options, recording.frame, warnings);
  if (found.known > 0 && found.in_range == 0)
    throw Fail(
        "the knee was learnt in {} at flexions of {:.0f}° to {:.0f}°, and here none is within them: learn it in a "
        "trial of the same movement",
        learnt.trial, learnt.from_deg, learnt.to_deg);
  Detections& knee = leg[kKnee];
  const std::vector<Vector3d>& seen = found.places.at(options.markers.knee).place;
  const SeenErrors errors(recording.time_s, found.carried, knee, seen, learnt.memory_s);
  RebuiltKnee rebuilt;
  rebuilt.trial = learnt.trial;
  rebuilt.frames.assign(n, 0);
  rebuilt.seen_frames = errors.Frames();
  rebuilt.difference_mm = errors.Mean();
  rebuilt.difference_rms_mm = errors.Rms();
  knee.rebuilt_sd.assign(n, kNaN);
  knee.rebuilt_memory_s = learnt.memory_s;
  for (std::size_t i = 0; i < n; ++i) {
    Carried& carried = found.carried[i];
    if (knee.trusted[i] || !carried.IsKnown()) continue;
    errors.Correct(i, carried);
    knee.in_plane[i] = PlaneFromLeg(carried.place.head<2>(), found.facing, options.up);
    knee.plane_sigma[i] = std::max(carried.noise, 1e-3);
    knee.sigma[i] = knee.plane_sigma[i] / PlaneUnitsPerRecorded(view, knee.in_plane[i], knee.depth_mm);
    if (!knee.lateral.empty())
      knee.lateral[i] = found.facing == motion::Facing::kRight ? carried.place.z() : -carried.place.z();
    knee.rebuilt_sd[i] = carried.sd;
    knee.seen[i] = 0;
    knee.trusted[i] = 1;
    rebuilt.frames[i] = 1;
  }
  return rebuilt;
}

}  // namespace lake::gait
