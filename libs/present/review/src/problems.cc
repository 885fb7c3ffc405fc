#include "lake/review/problems.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "lake/core/statistics.h"

namespace lake::review {
namespace {

using motion::SampleStatus;

// Whether a row has the problem, and its value.
using Rate = std::function<std::optional<double>(std::size_t row)>;

// Of a problem, whether the first value is worse than the second.
using IsWorse = std::function<bool(double, double)>;

bool IsLarger(double a, double b) {
  return a > b;
}

// Of ratios, which may be too large or too small.
bool IsFartherFromOne(double a, double b) {
  return std::abs(a - 1) > std::abs(b - 1);
}

// Runs of rows that have it, as one problem each with its worst value; a few rows without it do not end a run.
void AddRuns(const motion::MarkerRecording& recording, const Problem& like, const Rate& rate, const IsWorse& is_worse,
             std::vector<Problem>& problems) {
  constexpr std::int64_t kBridged = 3;
  bool is_open = false;
  for (std::size_t row = 0; row < recording.Frames(); ++row) {
    const std::optional<double> value = rate(row);
    if (!value) continue;
    const std::int64_t frame = recording.frame[row];
    if (!is_open || frame > problems.back().last + kBridged) {
      problems.push_back(like);
      problems.back().first = frame;
      problems.back().value = *value;
      is_open = true;
    }
    Problem& run = problems.back();
    run.last = frame;
    if (is_worse(*value, run.value)) run.value = *value;
  }
}

double MedianOf(std::vector<double> values) {
  return values.empty() ? 0 : Median(std::move(values));
}

void AddUncertain(const motion::MarkerRecording& measured, const motion::MarkerTrack& marker,
                  std::vector<Problem>& problems) {
  constexpr double kUnusual = 4;  // times the marker's median
  std::vector<double> sigmas;
  for (const motion::MarkerSample& sample : marker.samples)
    if (sample.IsKnown()) sigmas.push_back(sample.sigma);
  const double limit = kUnusual * MedianOf(sigmas);
  AddRuns(
      measured, {ProblemKind::kUncertain, marker.name},
      [&](std::size_t row) -> std::optional<double> {
        const motion::MarkerSample& sample = marker.samples[row];
        return sample.IsKnown() && sample.sigma > limit ? std::optional(sample.sigma) : std::nullopt;
      },
      IsLarger, problems);
}

// Of the leg's segments: their length over its median.
void AddLengths(const motion::MarkerRecording& measured, const motion::MarkerTrack& lower,
                const motion::MarkerTrack& upper, std::vector<Problem>& problems) {
  constexpr double kUnusual = 0.2;  // skin and perspective make up to 0.14, exchanged names 0.5 and more
  const auto length = [&](std::size_t row) -> std::optional<double> {
    const auto &a = lower.samples[row], &b = upper.samples[row];
    return a.IsKnown() && b.IsKnown() ? std::optional((a.position - b.position).norm()) : std::nullopt;
  };
  std::vector<double> lengths;
  for (std::size_t row = 0; row < measured.Frames(); ++row)
    if (const auto here = length(row)) lengths.push_back(*here);
  const double usual = MedianOf(lengths);
  if (!(usual > 0)) return;
  AddRuns(
      measured, {ProblemKind::kLength, upper.name},
      [&](std::size_t row) -> std::optional<double> {
        const auto here = length(row);
        return here && std::abs(*here / usual - 1) > kUnusual ? std::optional(*here / usual) : std::nullopt;
      },
      IsFartherFromOne, problems);
}

}  // namespace

std::string_view ToString(ProblemKind kind) {
  constexpr std::array<std::string_view, 4> kNames = {"gap", "outlier", "uncertain", "length"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::vector<Problem> FindProblems(const motion::MarkerRecording& measured, const gait::LegFitResult* leg,
                                  const std::vector<std::int64_t>& repeated) {
  std::vector<Problem> problems;
  for (const motion::MarkerTrack& marker : measured.markers) {
    AddRuns(
        measured, {ProblemKind::kGap, marker.name},
        [&](std::size_t row) -> std::optional<double> {
          const bool is_missed = !marker.samples[row].IsKnown() &&
                                 !std::binary_search(repeated.begin(), repeated.end(), measured.frame[row]);
          return is_missed ? std::optional(0.0) : std::nullopt;
        },
        IsLarger, problems);
    AddUncertain(measured, marker, problems);
  }
  constexpr std::array<const char*, 3> kLeg = {"ankle", "knee", "hip"};
  for (std::size_t m = 0; m + 1 < kLeg.size(); ++m) {
    const motion::MarkerTrack *lower = measured.Find(kLeg[m]), *upper = measured.Find(kLeg[m + 1]);
    if (lower && upper) AddLengths(measured, *lower, *upper, problems);
  }
  if (leg)
    for (const gait::OutlierReport& outlier : leg->outliers)
      problems.push_back({ProblemKind::kOutlier, outlier.marker, outlier.frame, outlier.frame, outlier.residual});
  std::stable_sort(problems.begin(), problems.end(),
                   [](const Problem& a, const Problem& b) { return a.first < b.first; });
  return problems;
}

}  // namespace lake::review
