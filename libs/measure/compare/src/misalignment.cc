#include "lake/compare/misalignment.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/compare/pointwise_error.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"
#include "noise.h"

namespace lake::compare {
namespace {

using Eigen::Vector2d;

void Check(const MisalignmentOptions& options) {
  if (!(options.replacement_sd_mm >= 0 && options.replacement_sd_mm <= 100))
    throw UsageError(fmt::format("--replacement-sd {}: 0 to 100 mm", options.replacement_sd_mm));
  if (options.resamples != 0 && (options.resamples < 50 || options.resamples > 100000))
    throw UsageError(fmt::format("resamples {}: 0 or 50 to 100000", options.resamples));
}

void FillErrors(Misalignment& m) {
  m.shank_mm = ShankLengths(m.human);
  for (std::size_t i = 0; i < kPercentSamples; ++i) {
    m.distance_mm.push_back(std::sqrt(SquaredDistance(m.exo.knee[i], m.human.knee[i])));
    m.relative_error.push_back(std::sqrt(SquaredRelativeError(m.exo.knee[i], m.human.knee[i], m.shank_mm[i])));
    m.relative_error_paper.push_back(RelativeErrorPaper(m.exo.knee[i], m.human.knee[i]));
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
        errors.push_back(std::sqrt(SquaredRelativeError(e.knee[i], h.knee[i], (h.knee[i] - h.ankle[i]).norm())));
    deviations.push_back(StandardDeviation(errors));
  }
  return deviations;
}

// Draws around a known `centre` show how far an estimate strays from the truth: the estimate less that. The basic
// bootstrap interval (Davison & Hinkley 1997, sec. 5.2); it takes out the bias that noise brings.
Interval BasicInterval(double estimate, double centre, const std::vector<double>& draws) {
  const Interval drawn = PercentileInterval(draws);
  return {estimate - (drawn.high - centre), estimate - (drawn.low - centre)};
}

// Of an RMS, from its square, to which noise adds; the draws of squares are around that of `shrink` times the estimate.
Interval BasicRms(double square, double shrink, const std::vector<double>& squares) {
  const Interval basic = BasicInterval(square, shrink * shrink * square, squares);
  return {std::sqrt(std::max(0.0, basic.low)), std::sqrt(std::max(0.0, basic.high))};
}

// Noise adds to a mean square, so what is measured holds it once already: the factor that takes it out.
double WithoutNoise(double measured_square, double noise_square) {
  return measured_square > 0 ? std::sqrt(std::max(0.0, 1 - noise_square / measured_square)) : 0;
}

// Placement, timing, shape of a decomposition to whose shape something is added that the fit takes for nothing else.
Eigen::Vector3d FractionsWithShape(const Decomposition& d, double factor, const std::vector<Vector2d>& added_mm) {
  Eigen::Vector3d parts = Eigen::Vector3d::Zero();
  double total = 0;
  for (std::size_t i = 0; i < kPercentSamples; ++i) {
    const Vector2d shape = d.shape_mm[i] + factor * added_mm[i];
    const Vector2d difference = d.placement_mm[i] + d.timing_mm[i] + shape;
    parts += Eigen::Vector3d(d.placement_mm[i].dot(difference), d.timing_mm[i].dot(difference), shape.dot(difference));
    total += difference.squaredNorm();
  }
  return parts / total;
}

class Bootstrap {
 public:
  Bootstrap(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options)
      : options_(options), noise_(human, exo, options), random_(options.seed) {}

  void Run(Misalignment& m) {
    std::vector<std::vector<Vector2d>> draws;
    double square_mm = 0, square_relative = 0;
    const std::vector<Vector2d> zero(kPercentSamples, Vector2d::Zero());
    for (int k = 0; k < options_.resamples; ++k) {
      draws.push_back(noise_.Draw(random_));
      square_mm += MeanSquaredDistance(draws.back(), zero) / options_.resamples;
      square_relative += MeanSquaredRelativeError(draws.back(), zero, m.shank_mm) / options_.resamples;
    }
    m.noise_floor_mm = std::sqrt(square_mm);
    m.noise_floor_relative = std::sqrt(square_relative);
    const double shrink = WithoutNoise(m.metrics.relative_rms * m.metrics.relative_rms, square_relative);
    for (const std::vector<Vector2d>& noise : draws) AddDistances(m, shrink, noise);
    m.intervals.emplace();
    SetDistanceIntervals(*m.intervals);
    SetPartIntervals(m, draws);
  }

 private:
  void AddDistances(const Misalignment& m, double shrink, const std::vector<Vector2d>& noise) {
    std::vector<double> distance, relative;
    for (std::size_t i = 0; i < kPercentSamples; ++i) {
      distance.push_back((shrink * (m.exo.knee[i] - m.human.knee[i]) + noise[i]).norm());
      relative.push_back(distance.back() / m.shank_mm[i]);
    }
    rms_.push_back(RootMeanSquare(distance));
    max_.push_back(*std::max_element(distance.begin(), distance.end()));
    relative_rms_.push_back(RootMeanSquare(relative));
    relative_max_.push_back(*std::max_element(relative.begin(), relative.end()));
  }

  void SetDistanceIntervals(MisalignmentIntervals& intervals) const {
    intervals.rms_mm = PercentileInterval(rms_);
    intervals.max_mm = PercentileInterval(max_);
    intervals.relative_rms = PercentileInterval(relative_rms_);
    intervals.relative_max = PercentileInterval(relative_max_);
  }

  // The measured shape holds noise already. So noise is drawn on top of placement and timing alone; what it leaves in
  // the shape tells how much of the measured shape is noise, and the rest of that is added to every draw: the fit takes
  // a shape, which is what it left, for nothing else.
  void SetPartIntervals(Misalignment& m, const std::vector<std::vector<Vector2d>>& draws) const {
    std::vector<Decomposition> parts;
    double noise_square = 0;
    for (const std::vector<Vector2d>& noise : draws) {
      ThrowIfInterrupted();
      StsCurve exo = m.exo;
      for (std::size_t i = 0; i < kPercentSamples; ++i) exo.knee[i] += noise[i] - m.decomposition.shape_mm[i];
      parts.push_back(DecomposeFrom(m.decomposition, m.human, exo, options_.decomposition));
      noise_square += MeanSquare(parts.back().shape_mm) / static_cast<double>(draws.size());
    }
    const std::vector<Vector2d>& shape_mm = m.decomposition.shape_mm;
    const double shrink = WithoutNoise(MeanSquare(shape_mm), noise_square);
    const Eigen::Vector3d centre = FractionsWithShape(m.decomposition, shrink - 1, shape_mm);
    std::array<std::vector<double>, 3> fractions, squares;
    std::vector<Vector2d> taken_away_mm = shape_mm;
    for (Vector2d& v : taken_away_mm) v *= -shrink;
    std::vector<double> offset_x, offset_y;
    for (const Decomposition& d : parts) {
      const Eigen::Vector3d drawn = FractionsWithShape(d, shrink, shape_mm);
      for (int part = 0; part < 3; ++part) fractions[static_cast<std::size_t>(part)].push_back(drawn[part]);
      squares[0].push_back(MeanSquare(d.placement_mm));
      squares[1].push_back(MeanSquare(d.timing_mm));
      squares[2].push_back(MeanSquaredDistance(d.shape_mm, taken_away_mm));
      offset_x.push_back(d.offset_mm.x());
      offset_y.push_back(d.offset_mm.y());
    }
    const Decomposition& d = m.decomposition;
    m.intervals->placement = BasicInterval(d.placement, centre[0], fractions[0]);
    m.intervals->timing = BasicInterval(d.timing, centre[1], fractions[1]);
    m.intervals->shape = BasicInterval(d.shape, centre[2], fractions[2]);
    m.intervals->placement_mm = BasicRms(MeanSquare(d.placement_mm), 1, squares[0]);
    m.intervals->timing_mm = BasicRms(MeanSquare(d.timing_mm), 1, squares[1]);
    m.intervals->shape_mm = BasicRms(MeanSquare(d.shape_mm), shrink, squares[2]);
    m.intervals->offset_x_mm = BasicInterval(d.offset_mm.x(), d.offset_mm.x(), offset_x);
    m.intervals->offset_y_mm = BasicInterval(d.offset_mm.y(), d.offset_mm.y(), offset_y);
  }

  const MisalignmentOptions& options_;
  NoiseModel noise_;
  std::mt19937_64 random_;
  std::vector<double> rms_, max_, relative_rms_, relative_max_;
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
    m.warnings.push_back(fmt::format(
        "the misalignment ({:.2g} mm RMS) is less than twice the noise floor ({:.2g} mm): its parts mean little",
        m.metrics.rms_mm, m.noise_floor_mm));
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
  m.relative_error_sd = ErrorDeviations(human, exo);
  m.spike = FindSpikes(m.human, m.exo, options.spikes);
  std::vector<bool> all(kPercentSamples, true), quiet = m.spike;
  quiet.flip();
  m.joint = FindJointMisalignment(exo, m.spike, {options.resamples, options.seed, options.noise_width_percent});
  m.metrics = ComputeMetrics(m.human, m.exo, all);
  m.metrics_without_spikes = ComputeMetrics(m.human, m.exo, quiet);
  m.decomposition = Decompose(m.human, m.exo, options.decomposition);
  if (options.resamples > 0) Bootstrap(human, exo, options).Run(m);
  m.pace = ComparePace(human, exo);
  m.posture = ComparePosture(human, exo);
  const auto [least, most] = std::minmax_element(m.human.knee_deg.begin(), m.human.knee_deg.end());
  m.best_pivot = BestFixedPivot(std::clamp(*least, 0.0, 119.0), std::clamp(*most, 1.0, 120.0));
  AddWarnings(human, exo, m);
  return m;
}

std::string DescribeJoint(const Vector2d& offset_mm) {
  return fmt::format("{:.0f} mm {} the knee and {:.0f} mm {} it along the shank", std::abs(offset_mm.x()),
                     offset_mm.x() < 0 ? "behind" : "in front of", std::abs(offset_mm.y()),
                     offset_mm.y() < 0 ? "below" : "above");
}

}  // namespace lake::compare
