#include "lake/compare/misalignment.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "decomposition_beside_knee.h"
#include "lake/compare/pointwise_error.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "noise.h"

namespace lake::compare {
namespace {

using Eigen::Vector2d;

void Check(const MisalignmentOptions& options) {
  if (!(options.replacement_sd_mm >= 0 && options.replacement_sd_mm <= 100))
    throw UsageError("--replacement-sd {}: 0 to 100 mm", options.replacement_sd_mm);
  if (options.resamples != 0 && (options.resamples < 50 || options.resamples > 100000))
    throw UsageError("resamples {}: 0 or 50 to 100000", options.resamples);
}

void FillErrors(Misalignment& m) {
  m.shank_mm = ShankLengths(m.human);
  for (std::size_t i = 0; i < kPercentSamples; ++i) {
    m.distance_mm.push_back(std::sqrt(SquaredDistance(m.exo.knee[i], m.human.knee[i])));
    m.misalignment_ratio.push_back(std::sqrt(SquaredMisalignment(m.exo.knee[i], m.human.knee[i], m.shank_mm[i])));
    m.misalignment_ratio_paper.push_back(PaperMisalignment(m.exo.knee[i], m.human.knee[i]));
  }
}

// Over all pairs of a human's and an exoskeleton's repetition.
std::vector<double> ErrorDeviations(const RegisteredTrial& human, const RegisteredTrial& exo) {
  std::vector<double> deviations;
  if (human.repetitions.size() * exo.repetitions.size() < 2) return deviations;
  for (std::size_t i = 0; i < kPercentSamples; ++i) {
    std::vector<double> errors;
    for (const StsCurve& h : human.repetitions)
      for (const StsCurve& e : exo.repetitions)
        errors.push_back(std::sqrt(SquaredMisalignment(e.knee[i], h.knee[i], (h.knee[i] - h.ankle[i]).norm())));
    deviations.push_back(StandardDeviation(errors));
  }
  return deviations;
}

// Draws around an estimate show how far an estimate strays from the truth: the estimate less that. The basic bootstrap
// interval (Davison & Hinkley 1997, sec. 5.2).
Interval BasicInterval(double estimate, const std::vector<double>& draws) {
  const Interval drawn = PercentileInterval(draws);
  return {2 * estimate - drawn.high, 2 * estimate - drawn.low};
}

// The basic interval takes out the bias of noise that is small, but not where large noise makes the estimate itself one
// of many: then the truth is among the draws.
Interval FractionInterval(double estimate, const std::vector<double>& draws) {
  const Interval basic = BasicInterval(estimate, draws), drawn = PercentileInterval(draws);
  return {std::min(basic.low, drawn.low), std::max(basic.high, drawn.high)};
}

std::vector<Vector2d> Over(std::vector<Vector2d> a, const std::vector<double>& unit) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] /= unit[i];
  return a;
}

// The exoskeleton's path with its joint moved by −mean_mm in the shank's frame; empty where no leg is shown.
std::vector<Vector2d> PathWithJointMoved(const Misalignment& m) {
  if (!m.joint || m.exo.leg_knee.empty()) return {};
  std::vector<Vector2d> path = m.exo.knee;
  for (std::size_t i = 0; i < path.size(); ++i)
    path[i] -= AxesAlong(m.exo.leg_knee[i] - m.exo.ankle[i]) * m.joint->mean_mm;
  return path;
}

std::optional<JointMoved> MoveJoint(const Misalignment& m) {
  const std::vector<Vector2d> path = PathWithJointMoved(m);
  if (path.empty()) return std::nullopt;
  return JointMoved{std::sqrt(MeanSquaredDistance(path, m.human.knee)),
                    std::sqrt(MeanSquaredMisalignment(path, m.human.knee, m.shank_mm)),
                    {}};
}

// The knee angle in degrees, and 0, in the place of the knee: its noise is that of a knee that is seen from both ends
// of the leg.
RegisteredTrial AnglesOf(const RegisteredTrial& trial) {
  RegisteredTrial angles;
  for (const StsCurve& curve : trial.repetitions) {
    StsCurve& angle = angles.repetitions.emplace_back(curve);
    for (std::size_t i = 0; i < curve.knee_deg.size(); ++i) {
      angle.knee[i] = {curve.knee_deg[i], 0};
      const double per_mm = 1 / (curve.knee[i] - curve.ankle[i]).norm() + 1 / (curve.hip[i] - curve.knee[i]).norm();
      angle.knee_sigma_mm[i] = DegreesFromRadians(curve.knee_sigma_mm[i] * per_mm);
    }
  }
  return angles;
}

// Neither lean nor a marker that is put back elsewhere along the leg turns the knee.
MisalignmentOptions OfAngles(MisalignmentOptions options) {
  options.replacement_sd_mm = options.lean_sd_deg = 0;
  return options;
}

class Bootstrap {
 public:
  Bootstrap(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options)
      : options_(options), human_(human), exo_(exo), noise_(human, exo, options) {
    std::mt19937_64 random(options.seed);
    for (int k = 0; k < options.resamples; ++k) draws_.push_back(noise_.Draw(random));
  }

  void Run(Misalignment& m) const {
    SetFloor(m);
    m.intervals.emplace();
    SetDistanceIntervals(m);
    SetPartIntervals(m);
    SetAngleIntervals(m);
  }

 private:
  void SetFloor(Misalignment& m) const {
    const std::vector<double> square = noise_.Floor();
    double relative = 0;
    for (std::size_t i = 0; i < square.size(); ++i) relative += square[i] / (m.shank_mm[i] * m.shank_mm[i]);
    m.noise_floor_mm = std::sqrt(Mean(square));
    m.noise_floor_relative = std::sqrt(relative / static_cast<double>(square.size()));
  }

  void SetDistanceIntervals(Misalignment& m) const {
    const std::vector<Vector2d> moved = PathWithJointMoved(m);
    JointMoved::Intervals of_moved;
    const auto set = [&](const std::vector<double>& unit, Interval& rms, Interval& max, Interval& moved_rms) {
      std::vector<std::vector<Vector2d>> draws;
      draws.reserve(draws_.size());
      for (const MeanErrors& errors : draws_) draws.push_back(Over(Less(errors.exo, errors.human), unit));
      const std::vector<Vector2d> difference = Over(Less(m.exo.knee, m.human.knee), unit);
      rms = RmsInterval(difference, draws);
      max = MaxInterval(difference, draws);
      if (!moved.empty()) moved_rms = RmsInterval(Over(Less(moved, m.human.knee), unit), draws);
    };
    set(std::vector<double>(kPercentSamples, 1.0), m.intervals->rms_mm, m.intervals->max_mm, of_moved.rms_mm);
    set(m.shank_mm, m.intervals->relative_rms, m.intervals->relative_max, of_moved.relative_rms);
    if (m.joint_moved) m.joint_moved->intervals = of_moved;
  }

  void SetAngleIntervals(Misalignment& m) const {
    const RegisteredTrial human = AnglesOf(human_), exo = AnglesOf(exo_);
    std::vector<std::vector<Vector2d>> draws;
    std::vector<double> strays_deg;
    draws.reserve(draws_.size());
    strays_deg.reserve(draws_.size());
    for (const MeanErrors& errors : DrawAngles()) {
      draws.push_back(Less(errors.exo, errors.human));
      strays_deg.push_back(std::sqrt(MeanSquare(errors.human)));
    }
    const StsCurve of_human = MeanCurve(human.repetitions), of_exo = MeanCurve(exo.repetitions);
    m.intervals->knee_rmse_deg = RmsInterval(Less(of_exo.knee, of_human.knee), draws);
    constexpr double kMost = 0.95;
    m.human_angle_strays_deg = DrawnQuantile(strays_deg, kMost);
  }

  // The errors of both mean angles, of the same draws as those of the paths.
  std::vector<MeanErrors> DrawAngles() const {
    const RegisteredTrial human = AnglesOf(human_), exo = AnglesOf(exo_);
    const MisalignmentOptions options = OfAngles(options_);
    const NoiseModel noise(human, exo, options);
    std::mt19937_64 random(options.seed);
    std::vector<MeanErrors> draws;
    for (int k = 0; k < options.resamples; ++k) draws.push_back(noise.Draw(random));
    return draws;
  }

  // Where the joint is from the knee, for each draw, by its own interval.
  std::vector<Vector2d> DrawJoint(const JointMisalignment& joint) const {
    constexpr double kReach = 2 * 1.96;  // standard deviations in a 95 % interval
    std::mt19937_64 random(options_.seed + 1);
    std::normal_distribution<double> normal;
    const Interval &x = joint.intervals->mean_x_mm, &y = joint.intervals->mean_y_mm;
    std::vector<Vector2d> draws;
    for (int k = 0; k < options_.resamples; ++k) {
      const double dx = normal(random), dy = normal(random);
      draws.emplace_back(joint.mean_mm + Vector2d((x.high - x.low) / kReach * dx, (y.high - y.low) / kReach * dy));
    }
    return draws;
  }

  void SetPartIntervals(Misalignment& m) const {
    const Decomposition& d = m.decomposition;
    std::array<std::vector<double>, 3> fractions;
    std::array<std::vector<std::vector<Vector2d>>, 3> parts;
    std::vector<double> offset_x, offset_y;
    DecompositionOptions rough = options_.decomposition;  // draws are larger than what more steps would change
    rough.tolerance = 1e-4;
    rough.max_iterations = 3;
    const std::vector<MeanErrors> angles = m.joint ? DrawAngles() : std::vector<MeanErrors>();
    const std::vector<Vector2d> joints = m.joint ? DrawJoint(*m.joint) : std::vector<Vector2d>();
    for (std::size_t k = 0; k < draws_.size(); ++k) {
      ThrowIfInterrupted();
      StsCurve human = m.human, exo = m.exo;
      human.knee = Sum(human.knee, draws_[k].human);
      exo.knee = Sum(exo.knee, draws_[k].exo);
      if (m.joint) {
        for (std::size_t i = 0; i < kPercentSamples; ++i) {
          human.knee_deg[i] += angles[k].human[i].x();
          exo.knee_deg[i] += angles[k].exo[i].x();
        }
      }
      const Decomposition drawn =
          m.joint ? DecomposeBesideKnee(human, exo, joints[k], rough, &d) : DecomposeFrom(d, human, exo, rough);
      fractions[0].push_back(drawn.placement);
      fractions[1].push_back(drawn.timing);
      fractions[2].push_back(drawn.shape);
      parts[0].push_back(Less(drawn.placement_mm, d.placement_mm));
      parts[1].push_back(Less(drawn.timing_mm, d.timing_mm));
      parts[2].push_back(Less(drawn.shape_mm, d.shape_mm));
      offset_x.push_back(drawn.offset_mm.x());
      offset_y.push_back(drawn.offset_mm.y());
    }
    m.intervals->placement = FractionInterval(d.placement, fractions[0]);
    m.intervals->timing = FractionInterval(d.timing, fractions[1]);
    m.intervals->shape = FractionInterval(d.shape, fractions[2]);
    m.intervals->placement_mm = RmsInterval(d.placement_mm, parts[0]);
    m.intervals->timing_mm = RmsInterval(d.timing_mm, parts[1]);
    m.intervals->shape_mm = RmsInterval(d.shape_mm, parts[2]);
    m.intervals->offset_x_mm = BasicInterval(d.offset_mm.x(), offset_x);
    m.intervals->offset_y_mm = BasicInterval(d.offset_mm.y(), offset_y);
  }

  const MisalignmentOptions& options_;
  const RegisteredTrial &human_, &exo_;
  NoiseModel noise_;
  std::vector<MeanErrors> draws_;
};

// The longest distance from ankle to hip: of the compared markers only the exoskeleton's may sit beside the knee.
double LegLength(const StsCurve& curve) {
  double longest_mm = 0;
  for (std::size_t i = 0; i < curve.hip.size(); ++i)
    longest_mm = std::max(longest_mm, (curve.hip[i] - curve.ankle[i]).norm());
  return longest_mm;
}

void AddWarnings(const RegisteredTrial& human, const RegisteredTrial& exo, Misalignment& m) {
  for (const RegisteredTrial* trial : {&human, &exo})
    m.warnings.insert(m.warnings.end(), trial->warnings.begin(), trial->warnings.end());
  const double human_mm = LegLength(m.human), exo_mm = LegLength(m.exo);
  constexpr double kMostDifference = 0.05;
  if (std::abs(exo_mm / human_mm - 1) > kMostDifference)
    m.warnings.push_back(fmt::format(
        "ankle to hip is {:.0f} mm in the human trial and {:.0f} mm in the exoskeleton trial: another subject, "
        "another marker placement, or a wrong scale?",
        human_mm, exo_mm));
  const bool same_path = std::isnan(m.decomposition.placement);
  if (same_path)
    m.warnings.emplace_back(
        "both knee paths are one: there is no misalignment to take apart; is one trial given as both?");
  if (!m.decomposition.converged)
    m.warnings.emplace_back("the decomposition did not converge: its fractions are approximate");
  if (!same_path && m.metrics.rms_mm < 2 * m.noise_floor_mm)
    m.warnings.push_back(
        fmt::format("the misalignment ({} mm RMS) is less than twice the noise floor ({} mm): its parts mean little",
                    SignificantText(m.metrics.rms_mm, 2), SignificantText(m.noise_floor_mm, 2)));
  const auto spikes = std::count(m.spike.begin(), m.spike.end(), true);
  if (spikes > 0)
    m.warnings.push_back(fmt::format("{} of 101 samples are spikes; figures without them are given beside", spikes));
}

}  // namespace

Misalignment CompareTrials(const RegisteredTrial& human, const RegisteredTrial& exo,
                           const MisalignmentOptions& options) {
  Check(options);
  Misalignment m;
  m.human = MeanCurve(human.repetitions);
  m.exo = MeanCurve(exo.repetitions);
  m.human_repetitions = static_cast<int>(human.repetitions.size());
  m.exo_repetitions = static_cast<int>(exo.repetitions.size());
  FillErrors(m);
  m.misalignment_ratio_sd = ErrorDeviations(human, exo);
  m.spike = FindSpikes(m.human, m.exo, options.spikes);
  std::vector<bool> all(kPercentSamples, true), quiet = m.spike;
  quiet.flip();
  m.joint = FindJointMisalignment(exo, m.spike,
                                  {options.resamples, options.seed, options.noise_width_percent, options.event_sd_s});
  m.joint_moved = MoveJoint(m);
  m.metrics = ComputeMetrics(m.human, m.exo, all);
  m.metrics_without_spikes = ComputeMetrics(m.human, m.exo, quiet);
  m.decomposition = m.joint ? DecomposeBesideKnee(m.human, m.exo, m.joint->mean_mm, options.decomposition)
                            : Decompose(m.human, m.exo, options.decomposition);
  if (options.resamples > 0) Bootstrap(human, exo, options).Run(m);
  m.pace = ComparePace(human, exo);
  m.posture = ComparePosture(human, exo);
  const auto [least, most] = std::minmax_element(m.human.knee_deg.begin(), m.human.knee_deg.end());
  m.best_pivot = BestFixedPivot(std::clamp(*least, 0.0, 119.0), std::clamp(*most, 1.0, 120.0));
  AddWarnings(human, exo, m);
  return m;
}

std::string DescribeJoint(const Vector2d& offset_mm, const Vector2d& half_width_mm) {
  constexpr double kRoundsToZero_mm = 0.5;
  if (offset_mm.cwiseAbs().maxCoeff() < kRoundsToZero_mm) return "on the knee";
  return fmt::format("{} mm {} the knee and {} mm {} it along the shank",
                     KnownText(std::abs(offset_mm.x()), half_width_mm.x(), 0),
                     offset_mm.x() < 0 ? "behind" : "in front of",
                     KnownText(std::abs(offset_mm.y()), half_width_mm.y(), 0), offset_mm.y() < 0 ? "below" : "above");
}

}  // namespace lake::compare
