#include "repeated_frames.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lake/core/statistics.h"
#include "local_path.h"

namespace lake::tracking {
namespace {

// Whether a step knows of every marker that another one knows of.
bool SeesAll(const JointStep& step, const JointStep& other) {
  for (std::size_t m = 0; m < step.markers.size(); ++m)
    if (other.markers[m] && !step.markers[m]) return false;
  return true;
}

bool IsSameWay(const JointStep& a, const JointStep& b) {
  constexpr double kCosine = 0.7;
  double product = 0, a_square = 0, b_square = 0;
  for (std::size_t m = 0; m < a.markers.size(); ++m) {
    if (!a.markers[m] || !b.markers[m]) continue;
    product += a.markers[m]->dot(*b.markers[m]);
    a_square += a.markers[m]->squaredNorm(), b_square += b.markers[m]->squaredNorm();
  }
  return product > kCosine * std::sqrt(a_square * b_square);
}

}  // namespace

JointStep StepBetween(const motion::MarkerRecording& recording, std::size_t from, std::size_t to) {
  JointStep step;
  double squares = 0;
  for (const motion::MarkerTrack& marker : recording.markers) {
    step.markers.emplace_back();
    if (!marker.samples[from].IsKnown() || !marker.samples[to].IsKnown()) continue;
    step.markers.back() = marker.samples[to].position - marker.samples[from].position;
    squares += step.markers.back()->squaredNorm();
    ++step.seen;
  }
  if (step.seen > 0) step.rms_px = std::sqrt(squares / step.seen);
  return step;
}

double UsualInterval(const motion::MarkerRecording& recording, const std::vector<std::size_t>& frames) {
  std::vector<double> time_s;
  time_s.reserve(frames.size());
  for (const std::size_t i : frames) time_s.push_back(recording.time_s[i]);
  return MedianInterval(time_s);
}

RepeatedFrames::RepeatedFrames(const std::vector<std::int64_t>& known, motion::MarkerRecording& recording)
    : recording_(recording), frame_s_(MedianInterval(recording.time_s)), repeated_(recording.Frames(), 0) {
  for (std::size_t i = 0; i < repeated_.size(); ++i)
    repeated_[i] = std::binary_search(known.begin(), known.end(), recording.frame[i]);
}

void RepeatedFrames::FindStandstills() {
  for (std::size_t i = 2; i < repeated_.size(); ++i)
    if (!repeated_[i]) MarkStandstillFrom(i);
}

double RepeatedFrames::LowerRate::Source(std::size_t i) const {
  return std::floor(ratio * static_cast<double>(i) + phase);
}

std::vector<std::size_t> RepeatedFrames::Fresh() const {
  std::vector<std::size_t> fresh;
  for (std::size_t i = 0; i < repeated_.size(); ++i)
    if (!repeated_[i]) fresh.push_back(i);
  return fresh;
}

std::optional<std::size_t> RepeatedFrames::NewBefore(std::size_t i) const {
  while (i-- > 0)
    if (!repeated_[i]) return i;
  return std::nullopt;
}

// Marks the frames from `first` on in which nothing moves, if everything moves before and after them alike.
void RepeatedFrames::MarkStandstillFrom(std::size_t first) {
  constexpr double kStill = 0.2;  // of what a step would be
  const auto last_new = NewBefore(first);
  const auto one_before = last_new ? NewBefore(*last_new) : std::nullopt;
  if (!one_before) return;
  const JointStep before = StepBetween(recording_, *one_before, *last_new);
  const double elapsed_s = recording_.time_s[*last_new] - recording_.time_s[*one_before];
  const double usual_px = before.rms_px / elapsed_s * frame_s_;
  if (before.seen < 2 || usual_px < kLeastStepPx) return;
  const auto is_still = [&](std::size_t from, std::size_t to) {
    const JointStep step = StepBetween(recording_, from, to);
    return SeesAll(step, before) && step.rms_px < kStill * usual_px;
  };
  std::size_t resumed = first;
  while (resumed < repeated_.size() && (repeated_[resumed] || is_still(*last_new, resumed))) ++resumed;
  if (resumed == first || resumed >= repeated_.size()) return;
  std::size_t next = resumed + 1;
  while (next < repeated_.size() && (repeated_[next] || is_still(resumed, next))) ++next;
  if (next >= repeated_.size()) return;
  const JointStep over = StepBetween(recording_, *last_new, resumed), after = StepBetween(recording_, resumed, next);
  const double after_s = recording_.time_s[next] - recording_.time_s[resumed];
  if (after.seen < 2 || after.rms_px / after_s * frame_s_ < kLeastStepPx) return;
  if (!IsSameWay(before, over) || !IsSameWay(over, after)) return;
  for (std::size_t i = first; i < resumed; ++i) repeated_[i] = 1;
}

// Frames of which it can be told whether they are new.
std::vector<std::size_t> RepeatedFrames::TellingFrames() const {
  std::vector<std::size_t> telling;
  for (std::size_t i = 1; i < repeated_.size(); ++i) {
    const JointStep step = StepBetween(recording_, NewBefore(i).value_or(i), i);
    if (repeated_[i] || (step.seen >= 2 && step.rms_px >= kLeastStepPx)) telling.push_back(i);
  }
  return telling;
}

// The rate whose repetitions are those that were found; of all that agree, the simplest ratio.
std::optional<RepeatedFrames::LowerRate> RepeatedFrames::FindLowerRate() const {
  constexpr std::size_t kFewest = 6;
  constexpr double kMayDisagree = 0.03, kReach = 0.04;
  constexpr int kLargestDenominator = 60, kPhases = 24;
  const std::vector<std::size_t> telling = TellingFrames();
  const auto found = static_cast<std::size_t>(
      std::count_if(telling.begin(), telling.end(), [&](std::size_t i) { return repeated_[i]; }));
  if (found < kFewest || 25 * found < telling.size()) return std::nullopt;
  const double about = 1 - static_cast<double>(found) / static_cast<double>(telling.size());
  const auto most = static_cast<std::size_t>(kMayDisagree * static_cast<double>(telling.size()));
  for (int denominator = 2; denominator <= kLargestDenominator; ++denominator)
    for (int numerator = 1; numerator < denominator; ++numerator) {
      if (std::gcd(numerator, denominator) != 1) continue;
      LowerRate rate{static_cast<double>(numerator) / denominator};
      if (std::abs(rate.ratio - about) > kReach) continue;
      std::size_t least = most + 1;  // what disagrees more is not looked through
      double best_phase = 0;
      for (int step = 0; step < kPhases * denominator; ++step) {
        // Halfway between the phases at which the pattern changes, so that rounding decides nothing.
        rate.phase = (step + 0.5) / (kPhases * denominator);
        std::size_t disagree = 0;
        for (const std::size_t i : telling)
          if ((disagree += rate.Repeats(i) != static_cast<bool>(repeated_[i])) >= least) break;
        if (disagree < least) least = disagree, best_phase = rate.phase;
      }
      rate.phase = best_phase;
      if (least <= most) return rate;
    }
  return std::nullopt;
}

// How far the new frames' positions are from smooth paths at these times.
double RepeatedFrames::Roughness(const std::vector<double>& time_s) const {
  constexpr int kDegree = 3;
  constexpr std::size_t kReach = 3;
  const std::vector<std::size_t> fresh = Fresh();
  std::vector<double> off;
  for (const motion::MarkerTrack& marker : recording_.markers)
    for (std::size_t k = kReach; k + kReach < fresh.size(); ++k) {
      LocalPath path(kDegree, time_s[fresh[k]]);
      bool whole = true;
      for (std::size_t j = k - kReach; j <= k + kReach && whole; ++j) {
        const motion::MarkerSample& sample = marker.samples[fresh[j]];
        whole = sample.IsKnown();
        if (whole) path.Add(time_s[fresh[j]], sample.position);
      }
      const Eigen::Vector2d moved = marker.samples[fresh[k]].position - marker.samples[fresh[k - 1]].position;
      if (!whole || moved.norm() < kLeastStepPx) continue;
      off.push_back((marker.samples[fresh[k]].position - path.Fit().position).norm());
    }
  return off.empty() ? INFINITY : Median(std::move(off));
}

// Every repetition of the rate is one, also where nothing moves that would tell. Its times are taken if its frames are
// equally far apart.
double RepeatedFrames::TakeLowerRate() {
  const std::optional<LowerRate> found = FindLowerRate();
  if (!found) return 0;
  const LowerRate& rate = *found;
  constexpr double kClearlySmoother = 0.7;
  for (std::size_t i = 0; i < repeated_.size(); ++i) repeated_[i] |= static_cast<char>(rate.Repeats(i));
  std::vector<double> captured = recording_.time_s;
  double shift = 0;
  int fresh = 0;
  for (std::size_t i = 0; i < captured.size(); ++i) {
    captured[i] = recording_.time_s.front() + (rate.Source(i) - rate.phase) / rate.ratio * frame_s_;
    if (!repeated_[i]) shift += recording_.time_s[i] - captured[i], ++fresh;
  }
  for (double& time : captured) time += shift / fresh;
  if (Roughness(captured) > kClearlySmoother * Roughness(recording_.time_s)) return 0;
  recording_.time_s = std::move(captured);
  SpreadTimes();
  return rate.ratio / frame_s_;
}

void RepeatedFrames::SpreadTimes() {
  std::vector<double>& time_s = recording_.time_s;
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    if (!repeated_[i]) continue;
    std::size_t end = i;
    while (end < time_s.size() && repeated_[end]) ++end;
    const double from = time_s[i - 1],
                 step = end < time_s.size() ? (time_s[end] - from) / static_cast<double>(end - i + 1) : frame_s_;
    for (std::size_t k = i; k < end; ++k) time_s[k] = from + static_cast<double>(k - i + 1) * step;
    i = end;
  }
}

std::vector<std::int64_t> RepeatedFrames::Remove() {
  std::vector<std::int64_t> removed;
  for (std::size_t i = 0; i < repeated_.size(); ++i) {
    if (!repeated_[i]) continue;
    removed.push_back(recording_.frame[i]);
    for (motion::MarkerTrack& marker : recording_.markers) marker.samples[i] = {};
  }
  return removed;
}

}  // namespace lake::tracking
