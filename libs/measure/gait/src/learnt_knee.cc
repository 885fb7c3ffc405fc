#include "lake/gait/learnt_knee.h"

#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/gait/marker_measures.h"
#include "noise_from_differences.h"
#include "segment_knee.h"

namespace lake::gait {
namespace {

using dynamics::RigidSegment;
using Eigen::Matrix3Xd, Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d;

constexpr KneeSegment kKneeSegments[] = {{"shank", &LegMarkers::ankle, &LegMarkers::hip, 1},
                                         {"thigh", &LegMarkers::hip, &LegMarkers::ankle, -1}};
constexpr std::size_t kNodes = 7;  // flexions at which the residual is kept

// A frame of one candidate to learn from.
struct KneeFrame {
  std::size_t frame;
  int part;              // left out together
  double flexion_deg;    // between the segment and the other one
  Vector3d knee;         // in the segment's frame
  Eigen::Matrix3d turn;  // leg from segment
  double weight = 1;
  Vector2d error = Vector2d::Constant(kNaN);  // in the sagittal plane, where its part is left out
};

// The range of flexion on −1 … 1.
struct FlexionScale {
  double middle_deg, half_deg;
  double operator()(double flexion_deg) const { return (flexion_deg - middle_deg) / half_deg; }
};

FlexionScale ScaleOf(double from_deg, double to_deg) {
  constexpr double kLeastHalf_deg = 0.5;  // of a leg that stands still
  return {(from_deg + to_deg) / 2, std::max(kLeastHalf_deg, (to_deg - from_deg) / 2)};
}

double KernelAt(double u, std::size_t node) {
  constexpr double kWidth = 1.5;  // of the distance between nodes
  const double step = 2.0 / (kNodes - 1), at = -1 + step * static_cast<double>(node);
  return std::max(0.0, 1 - std::abs(u - at) / (kWidth * step));
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

Matrix3Xd FitPolynomial(const std::vector<KneeFrame>& frames, const FlexionScale& scale, int degree, int without) {
  MatrixXd normal = MatrixXd::Zero(degree + 1, degree + 1), right = MatrixXd::Zero(degree + 1, 3);
  for (const KneeFrame& frame : frames) {
    if (frame.part == without) continue;
    Eigen::VectorXd powers(degree + 1);
    powers[0] = 1;
    for (int k = 1; k <= degree; ++k) powers[k] = powers[k - 1] * scale(frame.flexion_deg);
    normal += frame.weight * powers * powers.transpose();
    right += frame.weight * powers * frame.knee.transpose();
  }
  return normal.completeOrthogonalDecomposition().solve(right).transpose();
}

// Sets each frame's error where its part is left out, NaN at flexions that the other parts do not reach; returns their
// root mean square, flexions alike.
double CrossValidate(const FlexionScale& scale, int degree, std::vector<KneeFrame>& frames) {
  struct Rest {
    Matrix3Xd fit;
    double from_deg = kInfinity, to_deg = -kInfinity;
  };
  std::map<int, Rest> without;
  double sum = 0, weights = 0;
  for (KneeFrame& frame : frames) {
    auto [rest, is_new] = without.try_emplace(frame.part);
    Rest& of = rest->second;
    if (is_new) {
      of.fit = FitPolynomial(frames, scale, degree, frame.part);
      for (const KneeFrame& other : frames)
        if (other.part != frame.part) {
          of.from_deg = std::min(of.from_deg, other.flexion_deg);
          of.to_deg = std::max(of.to_deg, other.flexion_deg);
        }
    }
    frame.error.setConstant(kNaN);
    if (frame.flexion_deg < of.from_deg || frame.flexion_deg > of.to_deg) continue;
    frame.error = (frame.turn * (frame.knee - ValueAt(of.fit, scale(frame.flexion_deg)))).head<2>();
    sum += frame.weight * frame.error.squaredNorm() / 2;
    weights += frame.weight;
  }
  return std::sqrt(sum / weights);
}

// Per axis, of the markers from frame to frame: what smoothing averages away.
double NoiseOf(const std::vector<KneeFrame>& frames) {
  motion::MarkerTrack errors{"", std::vector<motion::MarkerSample>(frames.back().frame + 1)};
  std::vector<char> seen(errors.samples.size(), 0);
  for (const KneeFrame& frame : frames) {
    errors.samples[frame.frame].position = frame.error;
    seen[frame.frame] = frame.error.allFinite();
  }
  return NoiseFromDifferences(errors, seen);
}

struct Candidate {
  SegmentKnee knee;
  std::vector<KneeFrame> frames;
  double error_mm = kInfinity, noise_mm = 0;
};

// The segment's frame turned so that y leads from its lower to its upper end.
void Align(const KneeSegment& segment, const std::vector<Vector3d>& along, RigidSegment& rigid) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& direction : along) sum += segment.upward * direction.normalized();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(std::atan2(sum.x(), sum.y()), Vector3d::UnitZ()).toRotationMatrix();
  rigid.shape = turn * rigid.shape;
  for (dynamics::Pose& pose : rigid.poses) pose.turn *= turn.transpose();
}

// Flexions count alike, however long the leg keeps them.
void SetWeights(const FlexionScale& scale, std::vector<KneeFrame>& frames) {
  std::vector<double> counts(kNodes, 0.0);
  for (const KneeFrame& frame : frames)
    for (std::size_t node = 0; node < kNodes; ++node) counts[node] += KernelAt(scale(frame.flexion_deg), node);
  const double least = 0.02 * static_cast<double>(frames.size());
  for (KneeFrame& frame : frames) {
    double count = 0, kernels = 0;
    for (std::size_t node = 0; node < kNodes; ++node) {
      const double kernel = KernelAt(scale(frame.flexion_deg), node);
      count += kernel * counts[node];
      kernels += kernel;
    }
    frame.weight = 1 / std::max(least, count / kernels);
  }
}

// Each frame's repetition, or the one before; 0 in all without two of them.
std::vector<int> RepetitionsOf(const motion::LegMotion& motion) {
  std::vector<int> of;
  int now = 1;
  std::set<int> repetitions;
  for (const motion::LegSample& sample : motion.samples) {
    if (sample.repetition && *sample.repetition > 0) repetitions.insert(now = *sample.repetition);
    of.push_back(now);
  }
  if (repetitions.size() < 2) std::ranges::fill(of, 0);
  return of;
}

// Quarters of the frames where repetitions are not known.
void SetParts(std::vector<KneeFrame>& frames) {
  constexpr std::size_t kParts = 4;
  for (std::size_t k = 0; k < frames.size(); ++k)
    if (frames[k].part == 0) frames[k].part = 1 + static_cast<int>(kParts * k / frames.size());
}

struct Learner {
  const LegMarkers& names;
  const LegPlaces& places;
  std::vector<int> part;  // of each frame; 0: not known

  std::optional<Candidate> Learn(const KneeSegment& segment, const std::vector<std::string>& markers,
                                 bool in_space) const;
};

std::optional<Candidate> Learner::Learn(const KneeSegment& segment, const std::vector<std::string>& markers,
                                        bool in_space) const {
  constexpr std::size_t kLeast = 30;  // frames
  const auto at = [&](std::string LegMarkers::*name) -> const std::vector<Vector3d>& {
    return places.at(names.*name).place;
  };
  const auto &knee = at(&LegMarkers::knee), &end = at(segment.end), &other = at(segment.other);
  std::vector<Matrix3Xd> seen;
  for (std::size_t i = 0; i < part.size(); ++i) seen.push_back(PlacesAt(places, markers, i));
  std::optional<RigidSegment> rigid = dynamics::FitRigidSegment(seen, NormalOf(in_space));
  if (!rigid) return std::nullopt;
  std::vector<std::size_t> used;
  std::vector<Vector3d> along;
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (!seen[i].allFinite() || !(knee[i] + end[i] + other[i]).allFinite()) continue;
    used.push_back(i);
    along.push_back(rigid->poses[i].turn.transpose() * (knee[i] - end[i]));
  }
  if (used.size() < kLeast) return std::nullopt;
  Align(segment, along, *rigid);
  Candidate best{{segment.name, markers, rigid->shape, in_space, 0, {}, {}}, {}};
  double square = 0;
  for (const std::size_t i : used) {
    const dynamics::Pose& pose = rigid->poses[i];
    square += std::pow(StrainOf(best.knee, pose, seen[i]), 2);
    const auto local = [&](const Vector3d& place) -> Vector3d { return pose.turn.transpose() * (place - pose.origin); };
    best.frames.push_back(
        {i, part[i], FlexionDeg(segment, local(knee[i]), local(other[i])), local(knee[i]), pose.turn});
  }
  SetParts(best.frames);
  best.knee.strain_mm = std::sqrt(square / static_cast<double>(used.size()));
  return best;
}

// Of the segment's own frames: its polynomial and residual over a range of flexion.
void Fit(double from_deg, double to_deg, Candidate& candidate) {
  constexpr int kMostDegree = 2;
  const FlexionScale scale = ScaleOf(from_deg, to_deg);
  SetWeights(scale, candidate.frames);
  int best = 0;
  for (int degree = 0; degree <= kMostDegree; ++degree)
    if (const double error_mm = CrossValidate(scale, degree, candidate.frames); error_mm < candidate.error_mm) {
      candidate.error_mm = error_mm;
      best = degree;
    }
  CrossValidate(scale, best, candidate.frames);
  candidate.knee.knee_mm = FitPolynomial(candidate.frames, scale, best, -1);
  candidate.knee.residual_mm.clear();
  candidate.noise_mm = NoiseOf(candidate.frames);
  for (std::size_t node = 0; node < kNodes; ++node) {
    constexpr double kCommon = 0.1;  // of all flexions in each
    double sum = 0, weights = 0;
    for (const KneeFrame& frame : candidate.frames) {
      if (!frame.error.allFinite()) continue;
      const double weight = frame.weight * (kCommon + KernelAt(scale(frame.flexion_deg), node));
      sum += weight * frame.error.squaredNorm() / 2;
      weights += weight;
    }
    constexpr double kLeast = 0.1;  // of the variance
    const double variance = sum / weights;
    candidate.knee.residual_mm.push_back(
        std::sqrt(std::max(kLeast * variance, variance - std::pow(candidate.noise_mm, 2))));
  }
}

// The errors of both over their product, where both are known.
double CorrelationOf(const std::vector<KneeFrame>& a, const std::vector<KneeFrame>& b) {
  std::map<std::size_t, Vector2d> of_b;
  for (const KneeFrame& frame : b) of_b[frame.frame] = frame.error;
  double both = 0, square_a = 0, square_b = 0;
  for (const KneeFrame& frame : a)
    if (const auto other = of_b.find(frame.frame);
        other != of_b.end() && frame.error.allFinite() && other->second.allFinite()) {
      both += frame.error.dot(other->second);
      square_a += frame.error.squaredNorm();
      square_b += other->second.squaredNorm();
    }
  return both == 0 ? 0 : std::clamp(both / std::sqrt(square_a * square_b), -0.9, 0.9);
}

// By the correlation of errors a tenth of a second apart.
double MemoryOf(const Candidate& candidate, const std::vector<double>& time_s) {
  constexpr double kApart_s = 0.1, kLeast_s = 0.05, kMost_s = 2;
  double both = 0, square = 0;
  const std::vector<KneeFrame>& frames = candidate.frames;
  for (std::size_t i = 0, j = 0; i < frames.size(); ++i) {
    while (j < frames.size() && time_s[frames[j].frame] < time_s[frames[i].frame] + kApart_s - 1e-9) ++j;
    if (j == frames.size() || time_s[frames[j].frame] > time_s[frames[i].frame] + 1.5 * kApart_s) continue;
    if (!(frames[i].error + frames[j].error).allFinite()) continue;
    both += frames[i].error.dot(frames[j].error);
    square += (frames[i].error.squaredNorm() + frames[j].error.squaredNorm()) / 2 - 2 * std::pow(candidate.noise_mm, 2);
  }
  if (!(both > 0) || both >= square) return both > 0 ? kMost_s : kLeast_s;
  return std::clamp(-kApart_s / std::log(both / square), kLeast_s, kMost_s);
}

// What was measured, in the leg's axes; without what was found to be an outlier.
LegPlaces MeasuredPlaces(const LegFitResult& fit, const LateralPlaces& lateral, const std::set<std::string>& markers) {
  LegPlaces places;
  const motion::Facing facing = fit.motion.facing;
  const double right = facing == motion::Facing::kRight ? 1 : -1;
  for (const std::string& name : markers) {
    const motion::MarkerTrack *measured = fit.measured.Find(name), *track = fit.tracks.Find(name);
    if (!measured)
      throw Fail("--technical: no marker '{}' in the recording (it has: {})", name,
                 fmt::join(MarkerNames(fit.measured), ", "));
    const auto across = lateral.find(name);
    MarkerPlaces& of = places[name];
    for (std::size_t i = 0; i < measured->samples.size(); ++i) {
      const bool is_known = track->samples[i].status == motion::SampleStatus::kDetected;
      const Vector2d in_leg = LegFromPlane(measured->samples[i].position, facing, fit.up);
      of.place.emplace_back(Vector3d::Constant(kNaN));
      of.noise.push_back(measured->samples[i].sigma);
      if (is_known) of.place.back() << in_leg, across == lateral.end() ? 0 : right * across->second[i];
    }
  }
  return places;
}

}  // namespace

const KneeSegment& KneeSegmentOf(const std::string& name) {
  return name == kKneeSegments[0].name ? kKneeSegments[0] : kKneeSegments[1];
}

Matrix3Xd PlacesAt(const LegPlaces& places, const std::vector<std::string>& markers, std::size_t frame) {
  Matrix3Xd at(3, markers.size());
  for (std::size_t m = 0; m < markers.size(); ++m) {
    const auto marker = places.find(markers[m]);
    at.col(static_cast<Eigen::Index>(m)) =
        marker == places.end() ? Vector3d::Constant(kNaN) : marker->second.place[frame];
  }
  return at;
}

dynamics::TurnNormal NormalOf(bool in_space) {
  return in_space ? dynamics::TurnNormal() : dynamics::TurnNormal(Vector3d::UnitZ());
}

double StrainOf(const SegmentKnee& segment, const dynamics::Pose& pose, const Matrix3Xd& places) {
  double square = 0, coordinates = 0;
  for (Eigen::Index m = 0; m < places.cols(); ++m) {
    if (!places.col(m).allFinite()) continue;
    const Vector3d off = pose.turn.transpose() * (places.col(m) - pose.origin) - segment.shape_mm.col(m);
    square += segment.in_space ? off.squaredNorm() : off.head<2>().squaredNorm();
    coordinates += segment.in_space ? 3 : 2;
  }
  return std::sqrt(square / coordinates);
}

double FlexionDeg(const KneeSegment& segment, const Vector3d& knee, const Vector3d& other) {
  const Vector3d along = segment.upward * (other - knee);
  return -segment.upward * DegreesFromRadians(std::atan2(along.x(), along.y()));
}

KneeAt KneeAtFlexion(const LearntKnee& learnt, const SegmentKnee& segment, double flexion_deg) {
  const double u = ScaleOf(learnt.from_deg, learnt.to_deg)(flexion_deg), inside = std::clamp(u, -1.0, 1.0);
  const double node = (inside + 1) / 2 * static_cast<double>(segment.residual_mm.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(node), segment.residual_mm.size() - 2);
  const double residual =
      std::lerp(segment.residual_mm[below], segment.residual_mm[below + 1], node - static_cast<double>(below));
  // As far as it goes beyond, the slope there is as good as unknown.
  const double slope = (ValueAt(segment.knee_mm, inside * 2) - ValueAt(segment.knee_mm, inside)).head<2>().norm();
  const double beyond =
      std::abs(u - inside) > 0 ? std::abs(u - inside) * std::hypot(slope / std::sqrt(2), residual) : 0;
  return {ValueAt(segment.knee_mm, u), std::hypot(residual, beyond)};
}

LearntKnee LearnKnee(const LegFitResult& fit, const TechnicalMarkers& technical, const LateralPlaces& lateral) {
  if (fit.measured.unit != motion::LengthUnit::kMm)
    throw UsageError("--technical: lengths are in px; give --scale, or a --camera with the sagittal plane");
  const LegMarkers& names = fit.leg_markers;
  std::set<std::string> all = {names.ankle, names.knee, names.hip};
  for (const auto& [segment, markers] : technical) all.insert(markers.begin(), markers.end());
  const LegPlaces places = MeasuredPlaces(fit, lateral, all);
  const Learner learner{names, places, RepetitionsOf(fit.motion)};
  constexpr double kWorthAMarker = 0.75;  // of the error; more markers show which of them has come off
  std::vector<Candidate> best;
  std::vector<double> flexions;
  for (const auto& [name, markers] : technical) {
    const KneeSegment& segment = KneeSegmentOf(name);
    std::vector<std::string> with_end = markers;
    if (std::ranges::count(markers, names.*segment.end) == 0) with_end.push_back(names.*segment.end);
    Candidate chosen;
    for (const std::vector<std::string>& cluster : {with_end, markers})
      for (const bool in_space : {false, true}) {
        if (in_space && (lateral.empty() || cluster.size() < 3)) continue;
        std::optional<Candidate> candidate = learner.Learn(segment, cluster, in_space);
        if (!candidate) continue;
        const auto [least, most] = std::ranges::minmax_element(candidate->frames, {}, &KneeFrame::flexion_deg);
        Fit(least->flexion_deg, most->flexion_deg, *candidate);
        const bool is_of_fewer = cluster.size() < chosen.knee.markers.size();
        if (candidate->error_mm < (is_of_fewer ? kWorthAMarker : 1) * chosen.error_mm) chosen = *std::move(candidate);
      }
    if (chosen.frames.empty())
      throw Fail("--technical {}: knee, ankle, hip and {} are seen together in fewer than 30 frames: nothing is learnt",
                 name, fmt::join(markers, ", "));
    for (const KneeFrame& frame : chosen.frames) flexions.push_back(frame.flexion_deg);
    best.push_back(std::move(chosen));
  }
  LearntKnee learnt;
  learnt.from_deg = *std::ranges::min_element(flexions);
  learnt.to_deg = *std::ranges::max_element(flexions);
  for (Candidate& candidate : best) {
    candidate.error_mm = kInfinity;
    Fit(learnt.from_deg, learnt.to_deg, candidate);
    learnt.segments.push_back(candidate.knee);
  }
  learnt.shank_mm = motion::MedianLength(fit.motion, &motion::LegSample::ak);
  learnt.memory_s = MemoryOf(best.front(), fit.motion.time_s);
  if (best.size() > 1) learnt.correlation = CorrelationOf(best[0].frames, best[1].frames);
  return learnt;
}

void Describe(TechnicalMarkers& technical, OptionList& options) {
  options
      .AddCustom(
          "technical", "Further markers on the skin of shank or thigh, two at least: they replace a hidden knee",
          [&technical](const OptionTexts& texts, const std::string& said) {
            technical.clear();
            for (const auto& [segment, markers] : NamesAndValues(texts, said)) {
              if (segment != "shank" && segment != "thigh")
                throw UsageError("{} {}: the segments that end at the knee are shank and thigh", said, segment);
              technical[segment] = SplitText(markers, ',');
              const std::set<std::string> distinct(technical[segment].begin(), technical[segment].end());
              if (distinct.size() < 2 || distinct.contains("") || distinct.size() < technical[segment].size())
                throw UsageError("{} {}={}: give two markers or more; one alone does not show how the {} turns", said,
                                 segment, markers, segment);
            }
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

void DescribeHiddenKnee(LegFitOptions& o, OptionList& options) {
  Describe(o.technical, options);
  DescribeKneeFrom(o.knee_trial, options);
}

Json LearntKneeJson(const LearntKnee& knee) {
  Json segments = Json::array();
  for (const SegmentKnee& segment : knee.segments) {
    const auto columns = [](const Eigen::Matrix3Xd& matrix) {
      Json json = Json::array();
      for (Eigen::Index c = 0; c < matrix.cols(); ++c) json.push_back({matrix(0, c), matrix(1, c), matrix(2, c)});
      return json;
    };
    segments.push_back({{"segment", segment.segment},
                        {"markers", segment.markers},
                        {"shape_mm", columns(segment.shape_mm)},
                        {"in_space", segment.in_space},
                        {"strain_mm", segment.strain_mm},
                        {"knee_mm", columns(segment.knee_mm)},
                        {"residual_sd_mm", segment.residual_mm}});
  }
  return {{"flexion_deg", {knee.from_deg, knee.to_deg}},
          {"shank_mm", knee.shank_mm},
          {"memory_s", knee.memory_s},
          {"correlation", knee.correlation},
          {"segments", segments}};
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
  try {
    const Json& knee = json[kLearntKnee];
    LearntKnee learnt{trial.string(),
                      knee.at("flexion_deg").at(0),
                      knee.at("flexion_deg").at(1),
                      knee.at("shank_mm"),
                      knee.at("memory_s"),
                      knee.at("correlation"),
                      {}};
    for (const Json& row : knee.at("segments")) {
      SegmentKnee& segment = learnt.segments.emplace_back();
      const auto columns = [](const Json& rows) {
        Eigen::Matrix3Xd matrix(3, rows.size());
        for (std::size_t c = 0; c < rows.size(); ++c)
          for (int i = 0; i < 3; ++i) matrix(i, static_cast<Eigen::Index>(c)) = rows[c].at(static_cast<std::size_t>(i));
        return matrix;
      };
      row.at("segment").get_to(segment.segment);
      row.at("markers").get_to(segment.markers);
      segment.shape_mm = columns(row.at("shape_mm"));
      row.at("in_space").get_to(segment.in_space);
      row.at("strain_mm").get_to(segment.strain_mm);
      segment.knee_mm = columns(row.at("knee_mm"));
      row.at("residual_sd_mm").get_to(segment.residual_mm);
      if (segment.segment != KneeSegmentOf(segment.segment).name ||
          std::cmp_not_equal(segment.shape_mm.cols(), segment.markers.size()) || segment.markers.size() < 2 ||
          segment.knee_mm.cols() < 1 || segment.residual_mm.size() < 2)
        throw Fail("{}: '{}' does not fit together", summary.string(), kLearntKnee);
    }
    if (learnt.segments.empty() || !(learnt.from_deg < learnt.to_deg) || !(learnt.memory_s > 0) ||
        !(std::abs(learnt.correlation) < 1))
      throw Fail("{}: '{}' does not fit together", summary.string(), kLearntKnee);
    return learnt;
  } catch (const Json::exception& error) {
    throw Fail("{}: '{}': {}", summary.string(), kLearntKnee, error.what());
  }
}

}  // namespace lake::gait
