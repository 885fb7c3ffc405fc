#include "lake/compare/misalignment.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "decomposition_beside_knee.h"
#include "lake/compare/pointwise_error.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "standard_errors.h"

namespace lake::compare {
namespace {

using Eigen::Vector2d;

void Check(const MisalignmentOptions& options) {
  if (!(options.replacement_sd_mm >= 0 && options.replacement_sd_mm <= 100))
    throw UsageError("--replacement-sd {}: 0 to 100 mm", options.replacement_sd_mm);
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

// Mean squared error of the mean knee path, mm², over both axes, as the recording shows it: from the differences
// between several repetitions, of a single one from its markers' sigmas.
std::vector<double> SquaredErrorOfMean(const RegisteredTrial& trial, const StsCurve& mean) {
  const auto n = static_cast<double>(trial.repetitions.size());
  std::vector<double> square(mean.knee.size(), 0);
  for (std::size_t i = 0; i < square.size(); ++i)
    if (trial.repetitions.size() == 1)
      square[i] = 2 * mean.knee_sigma_mm[i] * mean.knee_sigma_mm[i];
    else
      for (const StsCurve& curve : trial.repetitions)
        square[i] += (curve.knee[i] - mean.knee[i]).squaredNorm() / (n * (n - 1));
  return square;
}

// The RMS that the recordings' own scatter and a marker that is put back elsewhere show without any difference.
void SetNoiseFloor(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options,
                   Misalignment& m) {
  std::vector<double> square = SquaredErrorOfMean(exo, m.exo);
  const std::vector<double> of_human = SquaredErrorOfMean(human, m.human);
  double relative = 0;
  for (std::size_t i = 0; i < square.size(); ++i) {
    square[i] += of_human[i] + 2 * options.replacement_sd_mm * options.replacement_sd_mm;
    relative += square[i] / (m.shank_mm[i] * m.shank_mm[i]);
  }
  m.noise_floor_mm = std::sqrt(Mean(square));
  m.noise_floor_relative = std::sqrt(relative / static_cast<double>(square.size()));
}

// The means over the repetitions, and all that follows from them but intervals.
Misalignment CompareMeans(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options,
                          bool with_parts = true) {
  Misalignment m;
  m.human = MeanCurve(human.repetitions);
  m.exo = MeanCurve(exo.repetitions);
  m.exo_sight = exo.sight;
  m.human_repetitions = static_cast<int>(human.repetitions.size());
  m.exo_repetitions = static_cast<int>(exo.repetitions.size());
  FillErrors(m);
  m.spike = FindSpikes(m.human, m.exo, options.spikes);
  std::vector<bool> all(kPercentSamples, true), quiet = m.spike;
  quiet.flip();
  m.joint = FindJointMisalignment(exo, m.spike, {.replacement_sd_mm = options.replacement_sd_mm, .intervals = false});
  m.joint_moved = MoveJoint(m);
  m.metrics = ComputeMetrics(m.human, m.exo, all);
  m.metrics_without_spikes = ComputeMetrics(m.human, m.exo, quiet);
  if (!with_parts) return m;
  m.decomposition = m.joint ? DecomposeBesideKnee(m.human, m.exo, m.joint->mean_mm, options.decomposition)
                            : Decompose(m.human, m.exo, options.decomposition);
  return m;
}

// What has an interval, and where that stands; nullptr: not of this comparison.
struct Quantity {
  std::function<double(const Misalignment& m)> value;
  std::function<Interval*(Misalignment& m)> interval;
  bool is_size = true;  // and so not below 0
};

template <Interval MisalignmentIntervals::*kInterval>
Interval* Among(Misalignment& m) {
  return &((*m.intervals).*kInterval);
}

template <Interval PartIntervals::*kInterval>
Interval* AmongParts(Misalignment& m) {
  return m.part_intervals ? &((*m.part_intervals).*kInterval) : nullptr;
}

template <Interval JointMoved::Intervals::*kInterval>
Interval* AmongMoved(Misalignment& m) {
  return m.joint_moved ? &((*m.joint_moved->intervals).*kInterval) : nullptr;
}

using All = MisalignmentIntervals;
using Parts = PartIntervals;
using Moved = JointMoved::Intervals;
using M = Misalignment;
std::vector<Quantity> Quantities() {
  std::vector<Quantity> quantities = {
      {[](const M& m) { return m.metrics.rms_mm; }, Among<&All::rms_mm>},
      {[](const M& m) { return m.metrics.max_mm; }, Among<&All::max_mm>},
      {[](const M& m) { return m.metrics.relative_rms; }, Among<&All::relative_rms>},
      {[](const M& m) { return m.metrics.relative_max; }, Among<&All::relative_max>},
      {[](const M& m) { return m.metrics.knee_rmse_deg; }, Among<&All::knee_rmse_deg>},
      {[](const M& m) { return m.joint_moved->rms_mm; }, AmongMoved<&Moved::rms_mm>},
      {[](const M& m) { return m.joint_moved->relative_rms; }, AmongMoved<&Moved::relative_rms>},
      {[](const M& m) { return m.decomposition.offset_mm.x(); }, AmongParts<&Parts::offset_x_mm>, false},
      {[](const M& m) { return m.decomposition.offset_mm.y(); }, AmongParts<&Parts::offset_y_mm>, false}};
  for (std::size_t k = 0; k < kParts.size(); ++k) {
    const auto among = [k](std::array<Interval, kParts.size()> PartIntervals::*intervals) {
      return [k, intervals](M& m) { return m.part_intervals ? &((*m.part_intervals).*intervals)[k] : nullptr; };
    };
    quantities.push_back(
        {[k](const M& m) { return m.decomposition.*kParts[k].fraction; }, among(&Parts::fraction), false});
    quantities.push_back({[k](const M& m) { return std::sqrt(MeanSquare(m.decomposition.*kParts[k].vectors_mm)); },
                          among(&Parts::rms_mm)});
  }
  return quantities;
}

void SetIntervals(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options,
                  Misalignment& m) {
  m.intervals.emplace();
  if (m.joint_moved) m.joint_moved->intervals.emplace();
  if (std::min(m.human_repetitions, m.exo_repetitions) >= kLeastRepetitionsOfParts &&
      std::isfinite(m.decomposition.placement))
    m.part_intervals.emplace();
  std::vector<Quantity> quantities = Quantities();
  std::erase_if(quantities, [&](const Quantity& quantity) { return !quantity.interval(m); });
  const auto n = static_cast<Eigen::Index>(quantities.size());
  // The human's mean knee angle stands behind the quantities.
  const Estimate estimate = [&](const RegisteredTrial& h, const RegisteredTrial& e) {
    const Misalignment of = CompareMeans(h, e, options, m.part_intervals.has_value());
    Eigen::ArrayXd values(n + kPercentSamples);
    for (Eigen::Index k = 0; k < n; ++k) values[k] = quantities[static_cast<std::size_t>(k)].value(of);
    for (Eigen::Index i = 0; i < kPercentSamples; ++i) values[n + i] = of.human.knee_deg[static_cast<std::size_t>(i)];
    return values;
  };
  const StandardErrors errors = FindStandardErrors(estimate, human, exo, options);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Quantity& quantity = quantities[static_cast<std::size_t>(k)];
    Interval& interval = *quantity.interval(m);
    interval = errors.Around(quantity.value(m), k);
    if (quantity.is_size) interval.low = std::max(0.0, interval.low);
  }
  const double angle_variance = errors.error.variance.tail(kPercentSamples).mean();
  m.human_angle_strays_deg = StudentInterval(0, angle_variance, errors.freedom.tail(kPercentSamples).minCoeff()).high;
}

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
  if (human.movement != exo.movement)
    throw Fail("the human trial is of {} and the exoskeleton trial of {}: trials of one movement can be compared",
               gait::MovementOf(human.movement).name, gait::MovementOf(exo.movement).name);
  Misalignment m = CompareMeans(human, exo, options);
  m.movement = human.movement;
  m.misalignment_ratio_sd = ErrorDeviations(human, exo);
  if (options.intervals) {
    m.joint = FindJointMisalignment(exo, m.spike, {.replacement_sd_mm = options.replacement_sd_mm});
    SetNoiseFloor(human, exo, options, m);
    SetIntervals(human, exo, options, m);
  }
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
