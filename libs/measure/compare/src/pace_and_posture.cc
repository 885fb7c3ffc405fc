#include "lake/compare/pace_and_posture.h"

#include <algorithm>
#include <cmath>

#include "lake/core/statistics.h"

namespace lake::compare {
namespace {

// By Student's t.
std::optional<Interval> IntervalOfMean(const std::vector<double>& values) {
  if (values.size() < 2) return std::nullopt;
  const auto n = static_cast<double>(values.size());
  return StudentInterval(Mean(values), std::pow(StandardDeviation(values), 2) / n, n - 1);
}

// By Welch's t with Satterthwaite's degrees of freedom.
std::optional<Interval> IntervalOfDifference(const std::vector<double>& human, const std::vector<double>& exo) {
  if (human.size() < 2 || exo.size() < 2) return std::nullopt;
  const auto variance_of_mean = [](const std::vector<double>& values) {
    return std::pow(StandardDeviation(values), 2) / static_cast<double>(values.size());
  };
  const double of_human = variance_of_mean(human), of_exo = variance_of_mean(exo), both = of_human + of_exo,
               difference = Mean(exo) - Mean(human);
  if (!(both > 0)) return Interval{difference, difference};
  const double freedom = both * both /
                         (of_human * of_human / static_cast<double>(human.size() - 1) +
                          of_exo * of_exo / static_cast<double>(exo.size() - 1));
  return StudentInterval(difference, both, freedom);
}

Difference Compare(const std::vector<double>& human, const std::vector<double>& exo) {
  return {.human = Mean(human),
          .exo = Mean(exo),
          .interval = IntervalOfDifference(human, exo),
          .human_interval = IntervalOfMean(human),
          .exo_interval = IntervalOfMean(exo)};
}

// A value of each repetition; empty if one has none.
template <typename Value>
std::vector<double> OfEach(const RegisteredTrial& trial, Value value) {
  std::vector<double> values;
  for (const StsCurve& curve : trial.repetitions) {
    const std::optional<double> own = value(curve);
    if (!own) return {};
    values.push_back(*own);
  }
  return values;
}

template <typename Value>
std::optional<Difference> CompareEach(const RegisteredTrial& human, const RegisteredTrial& exo, Value value) {
  const std::vector<double> of_human = OfEach(human, value), of_exo = OfEach(exo, value);
  return of_human.empty() || of_exo.empty() ? std::nullopt : std::optional(Compare(of_human, of_exo));
}

// nullopt where a repetition does not show the angle.
std::optional<AngleDifference> CompareAngle(const RegisteredTrial& human, const RegisteredTrial& exo,
                                            std::vector<double> StsCurve::*angle_deg) {
  const auto mean_deg = CompareEach(human, exo, [&](const StsCurve& curve) {
    const std::vector<double>& angle = curve.*angle_deg;
    const bool is_shown = !angle.empty() && std::ranges::all_of(angle, [](double deg) { return std::isfinite(deg); });
    return is_shown ? std::optional(Mean(angle)) : std::nullopt;
  });
  if (!mean_deg) return std::nullopt;
  AngleDifference difference{*mean_deg};
  const StsCurve human_mean = MeanCurve(human.repetitions), exo_mean = MeanCurve(exo.repetitions);
  std::vector<double> off_deg;
  for (std::size_t i = 0; i < kPercentSamples; ++i) {
    off_deg.push_back((exo_mean.*angle_deg)[i] - (human_mean.*angle_deg)[i]);
    difference.max_deg = std::max(difference.max_deg, std::abs(off_deg.back()));
  }
  difference.rms_deg = RootMeanSquare(off_deg);
  return difference;
}

}  // namespace

Pace ComparePace(const RegisteredTrial& human, const RegisteredTrial& exo) {
  return {*CompareEach(human, exo, [](const StsCurve& curve) { return std::optional(curve.duration_s); }),
          CompareEach(human, exo, [](const StsCurve& curve) { return curve.seat_off_s; }),
          CompareEach(human, exo, [](const StsCurve& curve) {
            return curve.seat_off_s ? std::optional(curve.duration_s - *curve.seat_off_s) : std::nullopt;
          })};
}

Posture ComparePosture(const RegisteredTrial& human, const RegisteredTrial& exo) {
  return {CompareAngle(human, exo, &StsCurve::shank_deg), CompareAngle(human, exo, &StsCurve::trunk_deg)};
}

}  // namespace lake::compare
