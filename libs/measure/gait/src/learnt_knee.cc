#include "lake/gait/learnt_knee.h"

#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "known_values.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/dynamics/rigid_segment.h"
#include "lake/gait/marker_measures.h"
#include "lake/gait/plausibility.h"
#include "noise_from_differences.h"
#include "rebuilt_knee.h"
#include "sizes.h"

// As a list of its columns. NOLINTBEGIN(readability-identifier-naming): the library's names
template <>
struct nlohmann::adl_serializer<Eigen::Matrix3Xd> {
  static void to_json(lake::Json& json, const Eigen::Matrix3Xd& matrix) {
    for (const auto& column : matrix.colwise()) json.push_back({column[0], column[1], column[2]});
  }
  static void from_json(const lake::Json& json, Eigen::Matrix3Xd& matrix) {
    matrix.resize(3, static_cast<Eigen::Index>(json.size()));
    for (Eigen::Index i = 0; i < matrix.size(); ++i)
      matrix(i) = json.at(static_cast<std::size_t>(i / 3)).at(static_cast<std::size_t>(i % 3));
  }
};
// NOLINTEND(readability-identifier-naming)

namespace lake::gait {
namespace {

using dynamics::Pose;
using Eigen::Matrix3Xd, Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d, Eigen::VectorXd;
using motion::Facing;

// The segments of the leg that end at the knee.
struct KneeSegment {
  const char* name;
  std::string LegMarkers::*end;      // its other end
  std::string LegMarkers::*far_end;  // of the other segment
  double upward;                     // 1 where the knee is its upper end, −1 where it is its lower one

  // Positive in flexion; places in the segment's frame.
  double FlexionDeg(const Vector3d& knee, const Vector3d& far_place) const {
    const Vector3d along = upward * (far_place - knee);
    return -upward * DegreesFromRadians(std::atan2(along.x(), along.y()));
  }
};
constexpr KneeSegment kKneeSegments[] = {{"shank", &LegMarkers::ankle, &LegMarkers::hip, 1},
                                         {"thigh", &LegMarkers::hip, &LegMarkers::ankle, -1}};

const KneeSegment& SegmentOf(const std::string& name) {
  return name == kKneeSegments[0].name ? kKneeSegments[0] : kKneeSegments[1];
}

// ---- where the markers are

// Detections in the leg's axes (x anterior, y up, z to the right), mm.
struct LegPlaces {
  const motion::MarkerRecording* in_plane;
  const LateralPlaces* lateral;
  Facing facing;
  Vector2d up;

  // By frame, a column for each of these markers; NaN where not seen.
  std::vector<Matrix3Xd> Of(const std::vector<std::string>& markers) const {
    std::vector<Matrix3Xd> places(in_plane->Frames(), Matrix3Xd::Constant(3, std::ssize(markers), kNaN));
    for (std::size_t m = 0; m < markers.size(); ++m) {
      const motion::MarkerTrack* track = in_plane->Find(markers[m]);
      const auto across = lateral->find(markers[m]);
      const double right = across == lateral->end() ? 0 : facing == Facing::kRight ? 1 : -1;
      for (std::size_t i = 0; i < places.size() && track; ++i)
        if (track->samples[i].status == motion::SampleStatus::kDetected)
          places[i].col(static_cast<Eigen::Index>(m)) << LegFromPlane(track->samples[i].position, facing, up),
              right == 0 ? 0 : right * across->second[i];
    }
    return places;
  }
};

// ---- the segment's pose

dynamics::TurnNormal NormalOf(const LearntKnee& knee) {
  return knee.in_space ? dynamics::TurnNormal() : dynamics::TurnNormal(Vector3d::UnitZ());
}

Vector3d ToSegment(const Pose& pose, const Vector3d& place) {
  return pose.turn.transpose() * (place - pose.origin);
}

// How far the seen markers are from those of the posed shape, per axis, root mean square.
double StrainOf(const LearntKnee& knee, const Pose& pose, const Matrix3Xd& places) {
  const Eigen::Index axes = knee.in_space ? 3 : 2;
  std::vector<double> off;
  for (Eigen::Index m = 0; m < places.cols(); ++m)
    if (places.col(m).allFinite())
      off.push_back((ToSegment(pose, places.col(m)) - knee.shape_mm.col(m)).head(axes).norm());
  return RootMeanSquare(off) / std::sqrt(axes);
}

// A segment over the frames: its pose, and which of its markers is left out, as the others keep their places without.
struct Course {
  static constexpr std::ptrdiff_t kNone = -1, kLost = -2, kUnseen = -3;  // kLost: which of them is not known
  std::vector<Pose> poses;
  std::vector<std::ptrdiff_t> out;
  double strain_mm = kNaN, whole_strain_mm = kNaN;  // of those that are not left out, RMS; of all, median

  std::vector<char> Where(std::ptrdiff_t left_out) const {
    std::vector<char> at;
    for (const std::ptrdiff_t now : out) at.push_back(now == left_out);
    return at;
  }
  double Share(std::ptrdiff_t left_out) const {
    return static_cast<double>(std::ranges::count(out, left_out)) /
           std::max(1.0, static_cast<double>(std::ssize(out) - std::ranges::count(out, kUnseen)));
  }
};

Course Follow(const LearntKnee& knee, const std::vector<Matrix3Xd>& seen) {
  constexpr double kLeast_mm = 6, kDeviations = 4;
  const double most_mm = std::max(kLeast_mm, kDeviations * knee.strain_mm);
  Course course;
  std::vector<double> strains, whole_strains;
  for (const Matrix3Xd& places : seen) {
    Pose best;
    double least_mm = kInfinity;
    std::ptrdiff_t out = Course::kUnseen;
    for (std::ptrdiff_t m = Course::kNone; m < places.cols(); ++m) {
      Matrix3Xd rest = places;
      if (m >= 0) rest.col(m).setConstant(kNaN);
      const Pose pose = dynamics::PoseOf(knee.shape_mm, rest, NormalOf(knee));
      const double strain_mm = pose.IsSeen() ? StrainOf(knee, pose, rest) : kInfinity;
      if (strain_mm < least_mm) {
        best = pose;
        least_mm = strain_mm;
        out = m;
      }
      if (m == Course::kNone) whole_strains.push_back(pose.IsSeen() ? strain_mm : kNaN);
      if (m == Course::kNone && strain_mm <= most_mm) break;
    }
    if (least_mm <= most_mm) strains.push_back(least_mm);
    const bool is_lost = best.IsSeen() && least_mm > most_mm;
    course.poses.push_back(is_lost ? Pose() : best);
    course.out.push_back(is_lost ? Course::kLost : out);
  }
  course.strain_mm = RootMeanSquare(strains);
  course.whole_strain_mm = MedianOfKnown(whole_strains);
  return course;
}

// ---- the knee in the segment's frame, against flexion

constexpr std::size_t kBins = 7;  // of the range of flexion, in which the residual is kept

// The range of flexion on −1 … 1.
double UnitOf(const LearntKnee& knee, double flexion_deg) {
  return (2 * flexion_deg - knee.from_deg - knee.to_deg) / (knee.to_deg - knee.from_deg);
}

std::size_t BinOf(const LearntKnee& knee, double flexion_deg) {
  return static_cast<std::size_t>(std::clamp((UnitOf(knee, flexion_deg) + 1) / 2 * kBins, 0.0, kBins - 1.0));
}

// As constant, slope and curvature; beyond the range straight on.
Vector3d ValueAt(const Matrix3Xd& coefficients, double u) {
  const double inside = std::clamp(u, -1.0, 1.0);
  Vector3d value = Vector3d::Zero(), slope = Vector3d::Zero();
  for (Eigen::Index k = coefficients.cols() - 1; k >= 0; --k) {
    slope = slope * inside + value;
    value = value * inside + coefficients.col(k);
  }
  return value + slope * (u - inside);
}

// A frame to learn from.
struct KneeFrame {
  int part;  // left out together
  double flexion_deg;
  Vector3d place;        // of the knee, in the segment's frame
  Eigen::Matrix3d turn;  // leg from segment
  Matrix3Xd markers;     // the segment's, in the leg's axes
};

std::set<int> Parts(const std::vector<KneeFrame>& frames) {
  std::set<int> parts;
  for (const KneeFrame& frame : frames) parts.insert(frame.part);
  return parts;
}

// Flexions count alike, however long the leg keeps them.
Matrix3Xd FitPolynomial(const LearntKnee& knee, const std::vector<KneeFrame>& frames, int degree, int without) {
  std::vector<int> counts(kBins, 0);
  for (const KneeFrame& frame : frames) ++counts[BinOf(knee, frame.flexion_deg)];
  MatrixXd normal = MatrixXd::Zero(degree + 1, degree + 1), right = MatrixXd::Zero(degree + 1, 3);
  for (const KneeFrame& frame : frames) {
    if (frame.part == without) continue;
    VectorXd powers = VectorXd::Ones(degree + 1);
    for (int k = 1; k <= degree; ++k) powers[k] = powers[k - 1] * UnitOf(knee, frame.flexion_deg);
    const VectorXd weighted = powers / counts[BinOf(knee, frame.flexion_deg)];
    normal += weighted * powers.transpose();
    right += weighted * frame.place.transpose();
  }
  return normal.completeOrthogonalDecomposition().solve(right).transpose();
}

// Where each part is left out in turn: how far the markers are from their places in the shape of the others, as strain.
double LeftOutStrain(const LearntKnee& knee, const std::vector<KneeFrame>& frames) {
  std::vector<double> strains;
  LearntKnee rest = knee;
  for (const int part : Parts(frames)) {
    std::vector<Matrix3Xd> others;
    for (const KneeFrame& frame : frames)
      if (frame.part != part) others.push_back(frame.markers);
    const auto rigid = dynamics::FitRigidSegment(others, NormalOf(knee));
    if (!rigid) return knee.strain_mm;
    rest.shape_mm = rigid->shape;
    for (const KneeFrame& frame : frames)
      if (frame.part == part)
        strains.push_back(
            StrainOf(rest, dynamics::PoseOf(rest.shape_mm, frame.markers, NormalOf(knee)), frame.markers));
  }
  return RootMeanSquare(strains);
}

// Where each part is left out in turn: variance per axis in the sagittal plane, by flexion; NaN where no other part has
// it.
std::vector<double> LeftOutVariances(const LearntKnee& knee, const std::vector<KneeFrame>& frames, int degree) {
  struct Rest {
    Matrix3Xd fit;
    double from_deg = kInfinity, to_deg = -kInfinity;
  };
  std::vector<double> variances(kBins, 0), counts(kBins, 0);
  std::map<int, Rest> without;
  for (const KneeFrame& frame : frames) {
    Rest& rest = without[frame.part];
    if (rest.fit.cols() == 0) {
      rest.fit = FitPolynomial(knee, frames, degree, frame.part);
      for (const KneeFrame& other : frames) {
        if (other.part == frame.part) continue;
        rest.from_deg = std::min(rest.from_deg, other.flexion_deg);
        rest.to_deg = std::max(rest.to_deg, other.flexion_deg);
      }
    }
    if (frame.flexion_deg < rest.from_deg || frame.flexion_deg > rest.to_deg) continue;
    const Vector3d off = frame.turn * (frame.place - ValueAt(rest.fit, UnitOf(knee, frame.flexion_deg)));
    const std::size_t bin = BinOf(knee, frame.flexion_deg);
    variances[bin] += off.head<2>().squaredNorm() / 2;
    ++counts[bin];
  }
  for (std::size_t bin = 0; bin < kBins; ++bin) variances[bin] /= counts[bin];
  return variances;
}

// The polynomial, of the degree that errs least, and its residual without the markers' noise; returns the variance over
// all flexions.
double Fit(const std::vector<KneeFrame>& frames, double noise_mm, LearntKnee& knee) {
  constexpr int kMostDegree = 2;
  constexpr double kLeast = 0.1;  // of the variance
  double least = kInfinity;
  for (int degree = 0; degree <= kMostDegree; ++degree) {
    std::vector<double> variances = LeftOutVariances(knee, frames, degree), known = variances;
    std::erase_if(known, [](double variance) { return std::isnan(variance); });
    const double mean = Mean(known);
    if (!(mean < least)) continue;
    least = mean;
    knee.knee_mm = FitPolynomial(knee, frames, degree, -1);
    knee.residual_mm.clear();
    for (const double variance : variances) {
      const double here = std::isnan(variance) ? mean : variance;
      knee.residual_mm.push_back(std::sqrt(std::max(kLeast * here, here - 2 * noise_mm * noise_mm)));
    }
  }
  return least;
}

struct KneeAt {
  Vector3d place;  // in the segment's frame
  double sd;       // per axis in the sagittal plane; beyond the range that was learnt it grows
};

KneeAt KneeAtFlexion(const LearntKnee& knee, double flexion_deg) {
  const double u = UnitOf(knee, flexion_deg), inside = std::clamp(u, -1.0, 1.0), beyond = std::abs(u - inside),
               residual = knee.residual_mm[BinOf(knee, flexion_deg)];
  // As far as it goes beyond, the slope there is as good as unknown.
  const double slope = (ValueAt(knee.knee_mm, 2 * inside) - ValueAt(knee.knee_mm, inside)).head<2>().norm();
  return {ValueAt(knee.knee_mm, u), std::hypot(residual, beyond * std::hypot(slope / std::sqrt(2), residual))};
}

// ---- learning

// Each frame's repetition, or the one before; empty without two of them.
std::vector<int> RepetitionsOf(const motion::LegMotion& motion) {
  std::vector<int> of;
  std::set<int> repetitions;
  int now = 1;
  for (const motion::LegSample& sample : motion.samples) {
    if (sample.repetition.value_or(0) > 0) repetitions.insert(now = *sample.repetition);
    of.push_back(now);
  }
  return repetitions.size() < 2 ? std::vector<int>() : of;
}

// Learns all but the segment and its markers, which `knee` has; returns the variance, infinite where too few frames
// show all of it.
double Learn(const LegPlaces& places, const LegMarkers& names, const std::vector<int>& repetitions, double noise_mm,
             LearntKnee& knee) {
  constexpr std::size_t kLeast = 30;     // frames
  constexpr double kLeastRange_deg = 1;  // of a leg that stands still
  const KneeSegment& segment = SegmentOf(knee.segment);
  const std::vector<Matrix3Xd> seen = places.Of(knee.markers),
                               leg = places.Of({names.knee, names.*segment.end, names.*segment.far_end});
  const auto rigid = dynamics::FitRigidSegment(seen, NormalOf(knee));
  if (!rigid) return kInfinity;
  Vector3d along = Vector3d::Zero();
  for (std::size_t i = 0; i < leg.size(); ++i)
    if (seen[i].allFinite() && leg[i].allFinite())
      along += segment.upward * (rigid->poses[i].turn.transpose() * (leg[i].col(0) - leg[i].col(1)));
  const Eigen::Matrix3d upright(Eigen::AngleAxisd(std::atan2(along.x(), along.y()), Vector3d::UnitZ()));
  knee.shape_mm = upright * rigid->shape;
  const Course course = Follow(knee, seen);
  knee.strain_mm = course.strain_mm;
  std::vector<KneeFrame> frames;
  for (std::size_t i = 0; i < leg.size(); ++i) {
    if (course.out[i] != Course::kNone || !seen[i].allFinite() || !leg[i].allFinite()) continue;
    const Vector3d place = ToSegment(course.poses[i], leg[i].col(0));
    frames.push_back({repetitions.empty() ? 0 : repetitions[i],
                      segment.FlexionDeg(place, ToSegment(course.poses[i], leg[i].col(2))), place, course.poses[i].turn,
                      seen[i]});
  }
  if (frames.size() < kLeast) return kInfinity;
  if (repetitions.empty())  // quarters of the frames
    for (std::size_t k = 0; k < frames.size(); ++k) frames[k].part = static_cast<int>(4 * k / frames.size());
  knee.strain_mm = LeftOutStrain(knee, frames);
  const auto [least, most] = std::ranges::minmax_element(frames, {}, &KneeFrame::flexion_deg);
  knee.from_deg = least->flexion_deg;
  knee.to_deg = std::max(most->flexion_deg, knee.from_deg + kLeastRange_deg);
  return Fit(frames, noise_mm, knee);
}

// ---- rebuilding

// Where markers carry the knee in one frame, in the leg's axes.
struct Carried {
  Vector3d place = Vector3d::Constant(kNaN);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  // leg from segment
  double sd = kNaN;                                    // what lasts, per axis
  bool is_in_range = false;
};

struct Found {
  LegPlaces places;
  Course course = {};
  std::vector<Carried> carried = {};
  double noise = 0;  // of a rebuilt place per mm of the markers' own
  std::ptrdiff_t in_range = 0;
};

// Knee and flexion together: a degree moves the knee by a hundredth of the thigh's.
Carried CarriedBy(const LearntKnee& knee, const Pose& pose, const Vector3d& far_end) {
  constexpr int kIterations = 12;
  constexpr double kMargin_deg = 10;
  double flexion_deg = (knee.from_deg + knee.to_deg) / 2;
  KneeAt at;
  for (int k = 0; k < kIterations; ++k) {
    at = KneeAtFlexion(knee, flexion_deg);
    flexion_deg = SegmentOf(knee.segment).FlexionDeg(at.place, ToSegment(pose, far_end));
  }
  return {pose.origin + pose.turn * at.place, pose.turn, at.sd,
          flexion_deg > knee.from_deg - kMargin_deg && flexion_deg < knee.to_deg + kMargin_deg};
}

Found Find(const LearntKnee& knee, const LegPlaces& places, const LegMarkers& names) {
  Found found{.places = places, .course = Follow(knee, places.Of(knee.markers))};
  // A turn in the plane, by errors across the markers' radii, moves the knee across its own.
  const double lever = knee.knee_mm.col(0).head<2>().norm() / knee.shape_mm.topRows<2>().norm();
  found.noise = std::hypot(1 / std::sqrt(knee.markers.size()), lever / std::sqrt(2));
  // Markers that keep their places clearly less well than when they were learnt may have been put on again beside them.
  const double strain = std::pow(found.course.strain_mm, 2) - std::pow(knee.strain_mm, 2);
  for (const Matrix3Xd& far_end : places.Of({names.*SegmentOf(knee.segment).far_end})) {
    const Pose& pose = found.course.poses[found.carried.size()];
    Carried& carried = found.carried.emplace_back();
    if (!pose.IsSeen() || !far_end.allFinite()) continue;
    carried = CarriedBy(knee, pose, far_end.col(0));
    carried.sd = std::hypot(carried.sd, found.noise * std::sqrt(std::max(0.0, strain)));
    found.in_range += carried.is_in_range;
  }
  return found;
}

// Where it is not given which way the person faces, as more of the flexions are in the learnt range.
Found Find(const LearntKnee& knee, const motion::MarkerRecording& in_plane, const LateralPlaces& lateral,
           const LegFitOptions& options) {
  LegPlaces places{&in_plane, &lateral, options.facing.value_or(Facing::kRight), options.up};
  Found found = Find(knee, places, options.markers);
  if (options.facing) return found;
  places.facing = Facing::kLeft;
  Found left = Find(knee, places, options.markers);
  return left.in_range > found.in_range ? left : found;
}

// Two names whose exchange puts the markers in their places.
std::optional<std::string> ExchangeOf(const LearntKnee& knee, const LegPlaces& places) {
  constexpr double kMost = 0.9;  // of the frames
  for (std::size_t a = 0; a < knee.markers.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      std::vector<std::string> exchanged = knee.markers;
      std::swap(exchanged[a], exchanged[b]);
      if (Follow(knee, places.Of(exchanged)).Share(Course::kNone) > kMost)
        return fmt::format("'{}' and '{}'", knee.markers[b], knee.markers[a]);
    }
  return {};
}

// Throws Error where the markers are absent, exchanged or elsewhere than when the knee was learnt, or the flexion is
// never one that was; warns of the frames in which one is.
void CheckMarkers(const LearntKnee& knee, const Found& found, const LegFitOptions& options,
                  const std::vector<std::int64_t>& frame, std::vector<std::string>& warnings) {
  constexpr double kMany = 0.5, kFew = 0.05;  // of the frames
  constexpr double kChanged_mm = 2;
  std::vector<std::string> absent;
  for (const std::string& marker : knee.markers)
    if (!found.places.in_plane->Find(marker)) absent.push_back(marker);
  if (knee.markers.size() - absent.size() < (knee.in_space ? 3u : 2u))
    throw Fail("the knee was learnt in {} from {} on the {}, and this trial has no '{}': mark and name {}", knee.trial,
               fmt::join(knee.markers, ", "), knee.segment, fmt::join(absent, "', '"),
               absent.size() == 1 ? "it" : "them");
  const Course& course = found.course;
  const auto markers = std::ssize(knee.markers);
  double most = course.Share(Course::kLost);
  for (std::ptrdiff_t m = 0; m < markers; ++m) most = std::max(most, course.Share(m));
  if (const auto exchanged = most > kMany ? ExchangeOf(knee, found.places) : std::nullopt)
    throw Fail(
        "the technical markers {} of the {} are exchanged: their distances are those of {} the other way round; "
        "put their names right, {}",
        *exchanged, knee.segment, knee.trial, options.ways_out);
  const std::string elsewhere =
      fmt::format("the technical markers of the {} are not where they were in {}: their distances are off by {:.0f} mm",
                  knee.segment, knee.trial, course.whole_strain_mm);
  if (course.Share(Course::kLost) > kMany)
    throw Fail("{}; are both trials of the same leg, and were the markers left on?", elsewhere);
  if (found.in_range == 0 && course.Share(Course::kNone) > 0)
    throw Fail(
        "the knee was learnt in {} at flexions of {:.0f}° to {:.0f}°, and here none is within them: learn it in a "
        "trial of the same movement",
        knee.trial, knee.from_deg, knee.to_deg);
  const auto warn = [&](std::ptrdiff_t out, const std::string& text) {
    if (course.Share(out) > kFew)
      warnings.push_back(fmt::format("frames {}: {}", FramesOf(frame, course.Where(out)), text));
  };
  warn(Course::kLost, elsewhere + ", and which has come off is not known: the knee is not rebuilt there");
  for (std::ptrdiff_t m = 0; m < markers; ++m)
    warn(m, fmt::format("'{}' is not where it was on the {} in {}: has it come off, or was it put on again? It is left "
                        "out there",
                        knee.markers[static_cast<std::size_t>(m)], knee.segment, knee.trial));
  if (course.strain_mm > kChanged_mm + knee.strain_mm)
    warnings.push_back(fmt::format(
        "the technical markers of the {} have moved against each other since {} (by {:.0f} mm): the rebuilt knee's "
        "standard deviation holds that",
        knee.segment, knee.trial, course.strain_mm));
}

// What the seen frames say of the rebuilt ones' errors, in the segment's axes.
class SeenErrors {
 public:
  SeenErrors(const std::vector<double>& time_s, const std::vector<Carried>& carried, const std::vector<Matrix3Xd>& seen)
      : time_s_(time_s), error_(time_s.size()) {
    std::vector<double> variances, squares;
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      error_[i] = carried[i].turn.transpose() * (seen[i].col(0) - carried[i].place);
      if (!error_[i].allFinite()) continue;
      frames_.push_back(i);
      shift_ += error_[i];
      squares.push_back(error_[i].head<2>().squaredNorm());
      variances.push_back(carried[i].sd * carried[i].sd);
    }
    if (frames_.empty()) return;
    const double count = static_cast<double>(frames_.size());
    shift_ /= count;
    rms_ = std::sqrt(Mean(squares));
    // Errors stay alike for the memory's time: so many of them are independent.
    const double independent = 1 + count * MedianInterval(time_s) / (2 * kRebuiltMemory_s);
    constexpr double kDiffers = 0.25;  // of the shift, where the flexion is another
    shift_variance_ = Mean(variances) / independent + kDiffers * kDiffers * shift_.head<2>().squaredNorm() / 2;
  }

  void Report(RebuiltKnee& rebuilt) const {
    rebuilt.seen_frames = frames_.size();
    rebuilt.difference_mm = shift_.head<2>();
    rebuilt.difference_rms_mm = rms_;
  }

  // An error that decays from the seen frames before and after (Ornstein–Uhlenbeck bridge) to the mean shift.
  void Correct(std::size_t i, Carried& carried) const {
    const auto after = std::ranges::upper_bound(frames_, i);
    const auto alike = [&](std::size_t other) {
      return std::exp(-std::abs(time_s_[i] - time_s_[other]) / kRebuiltMemory_s);
    };
    const double a = after == frames_.begin() ? 0 : alike(*std::prev(after)),
                 b = after == frames_.end() ? 0 : alike(*after), both = a * b;
    const double before_weight = (a - b * both) / (1 - both * both), after_weight = (b - a * both) / (1 - both * both);
    Vector3d correction = shift_;
    if (a > 0) correction += before_weight * (error_[*std::prev(after)] - shift_);
    if (b > 0) correction += after_weight * (error_[*after] - shift_);
    const double unseen = std::max(0.0, 1 - (before_weight * a + after_weight * b));
    carried.place += carried.turn * correction;
    carried.sd = std::sqrt((carried.sd * carried.sd + shift_variance_) * unseen);
  }

 private:
  const std::vector<double>& time_s_;
  std::vector<Vector3d> error_;
  std::vector<std::size_t> frames_;
  Vector3d shift_ = Vector3d::Zero();
  double rms_ = 0, shift_variance_ = 0;
};

// Of the ankle, in the plane, as the other markers are seen alike.
double NoiseOf(const Detections& ankle) {
  std::vector<double> sigmas;
  for (std::size_t i = 0; i < ankle.trusted.size(); ++i)
    if (ankle.trusted[i]) sigmas.push_back(ankle.plane_sigma[i]);
  return MedianOfKnown(std::move(sigmas));
}

// Every field with its key in summary.json.
template <typename Knee, typename Do>
void ForEachField(Knee& knee, const Do& field) {
  field("shank_mm", knee.shank_mm);
  field("segment", knee.segment);
  field("markers", knee.markers);
  field("shape_mm", knee.shape_mm);
  field("in_space", knee.in_space);
  field("strain_mm", knee.strain_mm);
  field("from_deg", knee.from_deg);
  field("to_deg", knee.to_deg);
  field("knee_mm", knee.knee_mm);
  field("residual_sd_mm", knee.residual_mm);
}

}  // namespace

LearntKnee LearnKnee(const LegFitResult& fit, const TechnicalMarkers& technical, const LateralPlaces& lateral) {
  if (fit.measured.unit != motion::LengthUnit::kMm)
    throw UsageError("--technical: lengths are in px; give --scale, or a --camera with the sagittal plane");
  motion::MarkerRecording measured = fit.measured;
  for (std::size_t m = 0; m < measured.markers.size(); ++m)
    for (std::size_t i = 0; i < measured.Frames(); ++i)  // without outliers
      if (fit.tracks.markers[m].samples[i].status != motion::SampleStatus::kDetected)
        measured.markers[m].samples[i] = {};
  const LegPlaces places{&measured, &lateral, fit.motion.facing, fit.up};
  const std::vector<int> repetitions = RepetitionsOf(fit.motion);
  const motion::MarkerTrack& own = *measured.Find(fit.leg_markers.knee);
  std::vector<char> seen;
  for (const motion::MarkerSample& sample : own.samples)
    seen.push_back(sample.status == motion::SampleStatus::kDetected);
  const double noise_mm = NoiseFromDifferences(own, seen);
  LearntKnee best;
  double least = kInfinity;
  for (const auto& [name, markers] : technical) {
    for (const std::string& marker : markers)
      if (!measured.Find(marker))
        throw Fail("--technical: no marker '{}' in the recording (it has: {})", marker,
                   fmt::join(MarkerNames(fit.measured), ", "));
    std::vector<std::string> with_end = markers;
    if (const std::string& end = fit.leg_markers.*SegmentOf(name).end; std::ranges::count(markers, end) == 0)
      with_end.push_back(end);
    constexpr double kWorthAMarker = 0.5;  // of the variance; more markers show which of them has come off
    for (const std::vector<std::string>& cluster : {with_end, markers}) {
      LearntKnee knee{.segment = name, .markers = cluster, .in_space = !lateral.empty() && cluster.size() > 2};
      const double variance = Learn(places, fit.leg_markers, repetitions, noise_mm, knee);
      if (variance >= (cluster.size() < with_end.size() ? kWorthAMarker : 1) * least) continue;
      least = variance;
      best = std::move(knee);
    }
  }
  if (best.markers.empty())
    throw Fail(
        "--technical: knee, ankle, hip and the technical markers are seen together in fewer than 30 frames: "
        "nothing is learnt");
  best.shank_mm = motion::MedianLength(fit.motion, &motion::LegSample::ak);
  return best;
}

std::optional<CarriedKnee> CarriedKneeIn(const motion::MarkerRecording& frame, const LegView& view,
                                         const LearntKnee& learnt, const std::optional<Facing>& facing) {
  LegFitOptions options;
  options.facing = facing;
  if (!frame.Find(options.markers.ankle) || !frame.Find(options.markers.hip)) return std::nullopt;
  const motion::MarkerRecording in_plane = InPlane(frame, view);
  const LateralPlaces none;
  const Found found = Find(learnt, in_plane, none, options);
  if (found.in_range == 0) return std::nullopt;
  return CarriedKnee{PlaneFromLeg(found.carried[0].place.head<2>(), found.places.facing, options.up),
                     found.places.facing};
}

RebuiltKnee RebuildKnee(const LearntKnee& learnt, const motion::MarkerRecording& recording, const LegView& view,
                        const LateralPlaces& lateral, const LegFitOptions& options,
                        std::array<Detections, kLegMarkers>& leg, std::vector<std::string>& warnings) {
  if (PlaneUnit(view) != motion::LengthUnit::kMm)
    throw UsageError("--knee-from: lengths are in px; give --scale, or a --camera with the sagittal plane");
  const motion::MarkerRecording in_plane = InPlane(recording, view);
  Found found = Find(learnt, in_plane, lateral, options);
  CheckMarkers(learnt, found, options, recording.frame, warnings);
  Detections& knee = leg[kKnee];
  const std::size_t n = recording.Frames();
  std::vector<Matrix3Xd> seen = found.places.Of({options.markers.knee});
  for (std::size_t i = 0; i < n; ++i)
    if (!knee.trusted[i]) seen[i].setConstant(kNaN);
  const SeenErrors errors(recording.time_s, found.carried, seen);
  RebuiltKnee rebuilt{.trial = learnt.trial, .frames = std::vector<char>(n, 0)};
  errors.Report(rebuilt);
  const double noise_mm = std::max(1e-3, found.noise * NoiseOf(leg[kAnkle]));
  knee.rebuilt_sd.assign(n, kNaN);
  for (std::size_t i = 0; i < n; ++i) {
    Carried& carried = found.carried[i];
    if (knee.trusted[i] || !carried.place.allFinite()) continue;
    errors.Correct(i, carried);
    knee.in_plane[i] = PlaneFromLeg(carried.place.head<2>(), found.places.facing, options.up);
    knee.plane_sigma[i] = noise_mm;
    knee.sigma[i] = noise_mm / PlaneUnitsPerRecorded(view, knee.in_plane[i], knee.depth_mm);
    if (!knee.lateral.empty())
      knee.lateral[i] = found.places.facing == Facing::kRight ? carried.place.z() : -carried.place.z();
    knee.rebuilt_sd[i] = carried.sd;
    knee.seen[i] = 0;
    knee.trusted[i] = rebuilt.frames[i] = 1;
  }
  return rebuilt;
}

TechnicalMarkers ParseSegmentMarkers(const OptionTexts& texts, const std::string& said) {
  TechnicalMarkers named;
  for (const auto& [segment, text] : NamesAndValues(texts, said)) {
    if (segment != SegmentOf(segment).name)
      throw UsageError("{} {}: the segments that end at the knee are shank and thigh", said, segment);
    const std::vector<std::string> markers = SplitText(text, ',');
    const std::set<std::string> distinct(markers.begin(), markers.end());
    if (distinct.size() < 2 || distinct.contains("") || distinct.size() < markers.size())
      throw UsageError("{} {}={}: give two markers or more; one alone does not show how the {} turns", said, segment,
                       text, segment);
    named[segment] = markers;
  }
  return named;
}

void Describe(TechnicalMarkers& technical, OptionList& options) {
  options
      .AddCustom(
          "technical", "Further markers on the skin of shank or thigh, two at least: they replace a hidden knee",
          [&technical](const OptionTexts& texts, const std::string& said) {
            technical = ParseSegmentMarkers(texts, said);
          },
          [&technical] {
            OptionTexts texts;
            for (const auto& [segment, markers] : technical)
              texts.push_back(fmt::format("{}={}", segment, fmt::join(markers, ",")));
            return fmt::format("{}", fmt::join(texts, " "));
          })
      .Value("SEGMENT=A,B")
      .Repeats();
}

void AddTechnical(const TechnicalMarkers& technical, std::vector<std::string>& names) {
  for (const auto& [segment, markers] : technical)
    for (const std::string& marker : markers)
      if (std::ranges::count(names, marker) == 0) names.push_back(marker);
}

Option& DescribeKneeFrom(std::optional<std::filesystem::path>& trial, OptionList& options) {
  return options
      .Add("knee-from", trial,
           "Rebuild the knee where its marker is hidden, as learnt in this folder of lake track or lake gait (the "
           "person without exoskeleton, --technical)")
      .IsPath(Option::Path::kFolder);
}

Json LearntKneeJson(const LearntKnee& knee) {
  Json json;
  ForEachField(knee, [&json](const char* key, const auto& value) { json[key] = value; });
  return json;
}

std::filesystem::path LearntKneeFile(const std::filesystem::path& trial) {
  return trial.extension() == ".json" ? trial : trial / "summary.json";
}

void ReadKneeFrom(LegFitOptions& options) {
  if (options.knee_trial) options.knee_from = std::make_shared<LearntKnee>(ReadLearntKnee(*options.knee_trial));
}

LearntKnee ReadLearntKnee(const std::filesystem::path& trial) {
  const std::filesystem::path summary = LearntKneeFile(trial);
  const Json json = ReadJsonFile(summary);
  if (!json.is_object() || !json.contains(kLearntKnee))
    throw Fail("{}: no knee was learnt there; track or fit that trial with --technical shank=A,B", summary.string());
  LearntKnee knee{.trial = trial.string()};
  try {
    ForEachField(knee, [&](const char* key, auto& value) { json[kLearntKnee].at(key).get_to(value); });
  } catch (const Json::exception& error) {
    throw Fail("{}: '{}': {}", summary.string(), kLearntKnee, error.what());
  }
  if (knee.segment != SegmentOf(knee.segment).name || knee.markers.size() < 2 ||
      std::cmp_not_equal(knee.shape_mm.cols(), knee.markers.size()) || knee.knee_mm.cols() < 1 ||
      knee.residual_mm.size() != kBins || !(knee.from_deg < knee.to_deg))
    throw Fail("{}: '{}' does not fit together", summary.string(), kLearntKnee);
  return knee;
}

}  // namespace lake::gait
