#include "lake/gait/walking.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "lake/core/statistics.h"
#include "lake/gait/butterworth.h"
#include "lake/gait/leg_fit.h"
#include "monotone_phases.h"

namespace lake::gait {
namespace {

using motion::StsEventKind;
using Values = std::vector<double>;

constexpr double kCutoff_hz = 8;   // O'Connor et al. filter at 7 Hz
constexpr double kGrid_s = 0.005;  // of the filtered signals, whatever the frame rate
constexpr double kLongestGap_s = 0.15;
constexpr double kLeastTravel = 0.2;    // of the foot relative to the hip, and over the ground, of the leg's length
constexpr double kMostRise = 0.15;      // of the hip from one turn of the foot to the next; 0.03 to 0.07 in walking
constexpr double kLeastLift = 0.01;     // of the foot in swing over the foot in stance, likewise
constexpr double kHipInSwing = 0.6;     // the hip goes on in a swing, over the way of the foot relative to it, roughly
constexpr double kUsualStride_s = 1.1;  // windows below scale with the stride

// How one event shows in one signal: an extremum in a window about the foot's turn before or behind the hip.
struct Estimator {
  StsEventKind kind;
  bool of_foot;           // of heel and toe, else of the ankle
  bool of_velocity;       // vertical, of the middle of heel and toe; else forward position relative to the hip
  double sign;            // 1: a maximum
  double from_s, to_s;    // the window
  double offset_s, sd_s;  // of force plates' 20 N after the extremum, and its scatter between persons
};
constexpr std::array kEstimators = {Estimator{StsEventKind::kHeelStrike, true, false, 1, -0.08, 0.08, 0.041, 0.015},
                                    Estimator{StsEventKind::kHeelStrike, true, true, -1, -0.02, 0.14, 0, 0.009},
                                    Estimator{StsEventKind::kToeOff, true, false, -1, -0.05, 0.12, -0.006, 0.008},
                                    Estimator{StsEventKind::kToeOff, true, true, 1, -0.06, 0.08, 0.014, 0.007},
                                    Estimator{StsEventKind::kHeelStrike, false, false, 1, -0.04, 0.04, 0.043, 0.015},
                                    Estimator{StsEventKind::kHeelStrike, false, true, -1, -0.02, 0.12, 0.006, 0.011},
                                    Estimator{StsEventKind::kToeOff, false, false, -1, -0.04, 0.04, 0.034, 0.010},
                                    Estimator{StsEventKind::kToeOff, false, true, 1, -0.06, 0.08, 0.020, 0.008}};

// Frames over which markers are seen without a long gap.
using Run = std::vector<std::size_t>;

// Of the foot relative to the hip.
struct Turn {
  std::size_t at;
  bool is_front, is_edge;  // edge: the recording's, no turn is seen
};

// Signals of one foot over a run, on a grid of kGrid_s from begin_s; forward is where the subject faces.
struct Foot {
  bool of_foot = false, is_other = false;
  double begin_s = 0;
  Values front = {}, back = {};  // forward of the hip: heel and toe, or the ankle twice
  Values up = {};                // of the middle of heel and toe, or of the ankle
  Values relative = {};          // the same's place forward of the hip
  std::vector<Turn> turns = {};  // of that
  Values hip = {};               // its place
  Values hip_up = {};
  double position_sd = 0;  // of front and back after the filter's derivative: of their velocity
  double velocity_sd = 0;  // of the vertical acceleration
  std::size_t Size() const { return up.size(); }
  double Time(double at) const { return begin_s + kGrid_s * at; }
};

// One signal's extremum in a window, between grid points; nullopt without one inside.
std::optional<double> Extremum(const Values& values, double from, double to, double sign) {
  // Nearer to the recording's ends the filter's continuation makes extrema of its own.
  constexpr std::size_t kEdge = 6;
  std::optional<std::size_t> best;
  for (auto i = static_cast<std::size_t>(std::max<double>(from, kEdge)); i + kEdge < values.size(); ++i) {
    if (static_cast<double>(i) > to) break;
    if (sign * values[i] >= sign * values[i - 1] && sign * values[i] > sign * values[i + 1] &&
        (!best || sign * values[i] > sign * values[*best]))
      best = i;
  }
  if (!best) return std::nullopt;
  const double before = values[*best - 1], at = values[*best], after = values[*best + 1];
  return static_cast<double>(*best) + (before - after) / (2 * (before - 2 * at + after));
}

Values Derivative(const Values& values) {
  Values slope(values.size(), 0.0);
  for (std::size_t i = 1; i + 1 < values.size(); ++i) slope[i] = (values[i + 1] - values[i - 1]) / (2 * kGrid_s);
  return slope;
}

double Curvature(const Values& values, double at) {
  const auto i = static_cast<std::size_t>(std::round(at));
  return (values[i + 2] - 2 * values[i] + values[i - 2]) / std::pow(2 * kGrid_s, 2);
}

// Of white noise of this deviation per frame, in the filtered signal's first or second derivative: the integral of
// 2 σ² Δt (2πf)^2n / (1 + (f/c)⁴)² over f, with c the cutoff of one pass.
double DerivativeDeviation(double sigma, double step_s, int order) {
  const double c = 2 * std::numbers::pi * kCutoff_hz / std::pow(std::numbers::sqrt2 - 1, 0.25);
  constexpr double kIntegral = 0.27768;  // Γ(3/4) Γ(5/4) / 4
  return sigma * std::sqrt(2 * step_s * kIntegral * std::pow(c, 2 * order + 1) / (2 * std::numbers::pi));
}

class WalkFinder {
 public:
  WalkFinder(const LegFitResult& leg, const WalkingOptions& options) : leg_(leg), o_(options) {}

  Walk Find() {
    const LegMarkers& names = leg_.leg_markers;
    FindEvents(names.ankle, o_.heel, o_.toe, false);
    FindEvents(o_.other_ankle, o_.other_heel, o_.other_toe, true);
    TakePlates();
    std::ranges::sort(found_, {}, [](const Found& found) { return found.event.time_s; });
    ChooseGround();
    LeaveOutSingleSteps();
    Number();
    LeaveOutRunning();
    CountStrides(walk_.events, walk_);
    SayWhatElse();
    return std::move(walk_);
  }

 private:
  struct Found {
    motion::StsEvent event = {};
    bool by_foot = false;
    bool is_edge = false;
    double speed = NAN;  // of the foot, vertical, at the extremum
    double travel = 0;   // of the hip over that of the foot relative to it: 1 in stance overground, 0 on a treadmill
    bool by_plate = false;
  };

  // A marker's coordinates with x forward and y up, NaN where not known.
  const Values& Coordinate(const std::string& name, int axis) {
    auto& values = coordinates_[{name, axis}];
    const motion::MarkerTrack* track = leg_.trajectory.Find(name);
    if (!values.empty() || !track) return values;
    for (const motion::MarkerSample& sample : track->samples)
      values.push_back(sample.IsKnown() ? LegFromPlane(sample.position, leg_.motion.facing, leg_.up)[axis] : NAN);
    return values;
  }

  // Of one detection: what the fit leaves of it and the fit's own deviation add up to it.
  double NoiseOf(const std::string& name) const {
    const motion::MarkerTrack *fit = leg_.trajectory.Find(name), *seen = leg_.measured.Find(name);
    double square = 0;
    int count = 0;
    for (std::size_t i = 0; i < fit->samples.size(); ++i)
      if (fit->samples[i].IsKnown() && seen && seen->samples[i].status == motion::SampleStatus::kDetected) {
        square += (fit->samples[i].position - seen->samples[i].position).squaredNorm() / 2 +
                  std::pow(fit->samples[i].sigma, 2);
        ++count;
      }
    return count > 0 ? std::sqrt(square / count) : 0;
  }

  bool Has(const std::string& name) const { return leg_.trajectory.Find(name) != nullptr; }

  std::vector<Run> RunsOf(const std::vector<std::string>& names) {
    std::vector<Run> runs;
    const std::vector<double>& time_s = leg_.motion.time_s;
    for (std::size_t i = 0; i < time_s.size(); ++i) {
      if (!std::ranges::all_of(names, [&](const auto& name) { return std::isfinite(Coordinate(name, 0)[i]); }))
        continue;
      if (runs.empty() || time_s[i] - time_s[runs.back().back()] > std::max(kLongestGap_s, 2 * step_s_))
        runs.emplace_back();
      runs.back().push_back(i);
    }
    constexpr double kShortest_s = 0.3;
    std::erase_if(
        runs, [&](const Run& run) { return run.size() < 4 || time_s[run.back()] - time_s[run.front()] < kShortest_s; });
    return runs;
  }

  Values OnGrid(const Run& run, const Values& values) const {
    Values known, time_s, grid;
    for (const std::size_t i : run) {
      known.push_back(values[i]);
      time_s.push_back(leg_.motion.time_s[i]);
    }
    const auto cells = static_cast<std::size_t>((time_s.back() - time_s.front()) / kGrid_s);
    for (std::size_t i = 0; i <= cells; ++i) grid.push_back(time_s.front() + kGrid_s * static_cast<double>(i));
    return ZeroPhaseButterworth(InterpolateCubic(known, time_s, grid), 1 / kGrid_s, kCutoff_hz);
  }

  Foot SignalsOf(const Run& run, const std::string& front, const std::string& back, bool is_other) {
    Foot foot{.of_foot = front != back, .is_other = is_other, .begin_s = leg_.motion.time_s[run.front()]};
    const std::string& hip = leg_.leg_markers.hip;
    foot.hip = OnGrid(run, Coordinate(hip, 0));
    foot.hip_up = OnGrid(run, Coordinate(hip, 1));
    foot.front = OnGrid(run, Coordinate(front, 0));
    foot.back = OnGrid(run, Coordinate(back, 0));
    const Values up_front = OnGrid(run, Coordinate(front, 1)), up_back = OnGrid(run, Coordinate(back, 1));
    for (std::size_t i = 0; i < foot.hip.size(); ++i) {
      foot.front[i] -= foot.hip[i];
      foot.back[i] -= foot.hip[i];
      foot.relative.push_back((foot.front[i] + foot.back[i]) / 2);
      foot.up.push_back((up_front[i] + up_back[i]) / 2);
    }
    const double noise = std::max(NoiseOf(front), NoiseOf(back));
    foot.position_sd = DerivativeDeviation(std::hypot(noise, NoiseOf(hip)), step_s_, 1);
    foot.velocity_sd = DerivativeDeviation(foot.of_foot ? noise / std::numbers::sqrt2 : noise, step_s_, 2);
    const auto add_turn = [&](std::size_t at, bool is_front) {
      foot.turns.push_back({at, is_front, at == 0 || at + 1 == foot.Size()});
    };
    for (const MonotonePhase& phase : FindMonotonePhases(foot.relative, kLeastTravel * leg_.signals.leg_length)) {
      if (foot.turns.empty()) add_turn(phase.begin, !phase.rising);
      add_turn(phase.end, phase.rising);
    }
    return foot;
  }

  // By heel and toe where both are seen, else by the ankle.
  void FindEvents(const std::string& ankle, const std::string& heel, const std::string& toe, bool is_other) {
    const std::string& hip = leg_.leg_markers.hip;
    if (!Has(hip)) return;
    std::vector<Found> by_foot, by_ankle;
    if (Has(heel) && Has(toe))
      for (const Run& run : RunsOf({hip, heel, toe})) FindIn(SignalsOf(run, heel, toe, is_other), by_foot);
    if (Has(ankle))
      for (const Run& run : RunsOf({hip, ankle})) FindIn(SignalsOf(run, ankle, ankle, is_other), by_ankle);
    constexpr double kSame_s = 0.2;
    for (const Found& found : by_ankle)
      if (std::ranges::none_of(by_foot, [&](const Found& other) {
            return other.event.kind == found.event.kind && std::abs(other.event.time_s - found.event.time_s) < kSame_s;
          }))
        by_foot.push_back(found);
    found_.insert(found_.end(), by_foot.begin(), by_foot.end());
  }

  enum class Seen { kForward, kBackward, kFootStays, kNotLevel };

  void FindIn(const Foot& foot, std::vector<Found>& all) {
    std::vector<Found> here;
    const std::vector<Turn>& turns = foot.turns;
    std::vector<Seen> phases;
    for (std::size_t k = 0; k + 1 < turns.size(); ++k) {
      phases.push_back(SeenBetween(foot, k));
      const Interval seen{phases.back(), foot.Time(static_cast<double>(turns[k].at)),
                          foot.Time(static_cast<double>(turns[k + 1].at))};
      const auto is_same = [&](const Interval& other) {
        return other.what == seen.what && other.from_s < seen.to_s && other.to_s > seen.from_s;
      };
      if (!foot.is_other && std::ranges::none_of(seen_, is_same)) seen_.push_back(seen);
    }
    const double scale = StrideOf(turns) / kUsualStride_s;
    const Values velocity = Derivative(foot.up);
    for (std::size_t k = 0; k < turns.size(); ++k) {
      const bool has_before = k > 0, has_after = k < phases.size();
      if ((has_before && phases[k - 1] != Seen::kForward) || (has_after && phases[k] != Seen::kForward) ||
          phases.empty())
        continue;
      // What the recording's edge hides is the turn, not always the event.
      if (turns[k].is_edge && (turns[k].is_front != (turns[k].at == 0) || !IsNearTurn(foot, k))) continue;
      std::optional<Found> found = Estimate(foot, velocity, turns[k], scale);
      if (!found) continue;
      found->is_edge = turns[k].is_edge;
      // In stance, or at an edge in the swing beside it.
      const bool is_stance = turns[k].is_front ? has_after : has_before;
      const std::size_t phase = turns[k].is_front == is_stance ? k : k - 1;
      const std::size_t from = turns[phase].at, to = turns[phase + 1].at;
      found->travel = (foot.hip[to] - foot.hip[from]) / std::abs(foot.relative[to] - foot.relative[from]);
      if (!is_stance) found->travel /= kHipInSwing;
      here.push_back(*found);
    }
    // Where the recording begins or ends near an event, a smaller movement of the foot is not taken for it.
    constexpr double kLeastSpeed = 0.5;
    for (const Found& found : here) {
      Values speeds;
      for (const Found& other : here)
        if (!other.is_edge && other.event.kind == found.event.kind) speeds.push_back(std::abs(other.speed));
      if (!found.is_edge || std::abs(found.speed) >= kLeastSpeed * Median(speeds)) all.push_back(found);
    }
  }

  // Whether the foot is at the recording's edge where it turns otherwise.
  static bool IsNearTurn(const Foot& foot, std::size_t edge) {
    std::array<Values, 2> places;
    for (const Turn& turn : foot.turns)
      if (!turn.is_edge) places[turn.is_front ? 1 : 0].push_back(foot.relative[turn.at]);
    constexpr double kNear = 0.15;  // of the way between the turns
    const double back = Median(places[0]), front = Median(places[1]);
    const auto [at, is_front, is_edge] = foot.turns[edge];
    return std::abs(foot.relative[at] - (is_front ? front : back)) < kNear * (front - back);
  }

  // The median time between turns to the same side, or twice that between two turns.
  static double StrideOf(const std::vector<Turn>& turns) {
    Values steps;
    for (std::size_t k = 2; k < turns.size(); ++k)
      if (!turns[k].is_edge && !turns[k - 2].is_edge)
        steps.push_back(kGrid_s * static_cast<double>(turns[k].at - turns[k - 2].at));
    return steps.empty() ? kUsualStride_s : std::clamp(Median(steps), 0.6, 2.5);
  }

  static double MeanUp(const Foot& foot, std::size_t from, std::size_t to) {
    return Mean(std::span(foot.up).subspan(from, to - from + 1));
  }

  // What the subject does from one turn to the next: the foot is carried forward, or pushed back; a swing is higher
  // than the stances beside it.
  Seen SeenBetween(const Foot& foot, std::size_t k) const {
    const std::vector<Turn>& turns = foot.turns;
    const bool is_swing = turns[k + 1].is_front;
    const auto travel = [&](std::size_t from, std::size_t to) {
      return std::abs(foot.hip[to] + foot.relative[to] - foot.hip[from] - foot.relative[from]);
    };
    const std::size_t begin = turns[k].at, end = turns[k + 1].at, last = foot.Size() - 1;
    double lift = 0, farthest = travel(begin, end);
    int neighbours = 0;
    const auto compare_with = [&](std::size_t from, std::size_t to) {
      lift += MeanUp(foot, begin, end) - MeanUp(foot, from, to);
      farthest = std::max(farthest, travel(from, to));
      ++neighbours;
    };
    if (k > 0) compare_with(turns[k - 1].at, begin);
    if (k + 2 < turns.size()) compare_with(end, turns[k + 2].at);
    // A single phase is compared with the parts of its neighbours that are seen.
    constexpr std::size_t kShortest = 10;
    if (neighbours == 0 && begin > kShortest) compare_with(0, begin);
    if (turns.size() == 2 && last > end + kShortest) compare_with(end, last);
    if (neighbours == 0 || farthest < kLeastTravel * leg_.signals.leg_length) return Seen::kFootStays;
    lift *= (is_swing ? 1.0 : -1.0) / neighbours;
    const auto heights = std::span(foot.hip_up).subspan(begin, end - begin + 1);
    const auto [lowest, highest] = std::ranges::minmax(heights);
    if (highest - lowest > kMostRise * leg_.signals.leg_length) return Seen::kNotLevel;
    return lift > kLeastLift * leg_.signals.leg_length ? Seen::kForward : Seen::kBackward;
  }

  std::optional<Found> Estimate(const Foot& foot, const Values& velocity, const Turn& turn, double scale) const {
    const StsEventKind kind = turn.is_front ? StsEventKind::kHeelStrike : StsEventKind::kToeOff;
    double weights = 0, sum = 0, squares = 0, method = 0, noise = 0;
    double speed = NAN;
    bool by_velocity = false;
    for (const Estimator& e : kEstimators) {
      if (e.kind != kind || e.of_foot != foot.of_foot || (turn.is_edge && !e.of_velocity)) continue;
      const Values& signal = e.of_velocity ? velocity : turn.is_front ? foot.front : foot.back;
      const auto at = static_cast<double>(turn.at);
      const auto found = Extremum(signal, at + scale * e.from_s / kGrid_s, at + scale * e.to_s / kGrid_s, e.sign);
      if (!found) continue;
      const double by_noise =
          std::abs((e.of_velocity ? foot.velocity_sd : foot.position_sd) / Curvature(signal, *found));
      const double variance = std::pow(e.sd_s, 2) + std::pow(by_noise, 2), time_s = foot.Time(*found) + e.offset_s;
      by_velocity |= e.of_velocity;
      if (e.of_velocity) speed = signal[static_cast<std::size_t>(*found)];
      weights += 1 / variance;
      sum += time_s / variance;
      squares += time_s * time_s / variance;
      method += e.sd_s / variance;  // what a person does otherwise than others is alike in both
      noise += std::pow(by_noise / variance, 2);
    }
    if (!(weights > 0)) return std::nullopt;
    Found found{.by_foot = foot.of_foot, .speed = speed};
    found.event.time_s = sum / weights;
    // What the turn alone predicts is not seen so near to the end.
    constexpr double kEnd_s = 0.03;
    if (found.event.time_s > leg_.motion.time_s.back() - (by_velocity ? 0 : kEnd_s)) return std::nullopt;
    const double disagreement = std::sqrt(std::max(0.0, squares - sum * sum / weights));  // one degree of freedom
    found.event.sd_s = std::max(1.0, disagreement / 2) * std::hypot(method / weights, std::sqrt(noise) / weights);
    constexpr double kWithinPerson = 0.5;  // of the SD: the part that differs from stride to stride
    found.event.alike_sd_s = std::sqrt(1 - kWithinPerson * kWithinPerson) * found.event.sd_s;
    found.event.kind = !foot.is_other  ? kind
                       : turn.is_front ? StsEventKind::kHeelStrikeOther
                                       : StsEventKind::kToeOffOther;
    return found;
  }

  // By a plate; and the same one by the markers, of those found.
  using Struck = std::pair<motion::StsEvent, std::optional<std::ptrdiff_t>>;

  // A contact's begin or end is this foot's event where the markers show one within 0.15 s (the other foot's is half a
  // stride away), or near an end of the recording if the contact's other event is this foot's.
  std::vector<Struck> EventsOf(const PlateContact& contact, bool is_other) const {
    using enum StsEventKind;
    constexpr double kSame_s = 0.15;
    std::vector<Struck> events;
    bool is_seen = false;
    for (const motion::StsEvent& event :
         {motion::StsEvent{
              .kind = is_other ? kHeelStrikeOther : kHeelStrike, .time_s = contact.begin_s, .sd_s = contact.begin_sd_s},
          {.kind = is_other ? kToeOffOther : kToeOff, .time_s = contact.end_s, .sd_s = contact.end_sd_s}}) {
      const double to_end_s =
          std::min(event.time_s - leg_.motion.time_s.front(), leg_.motion.time_s.back() - event.time_s);
      if (!(to_end_s >= 0)) continue;
      const auto same = std::ranges::find_if(found_, [&](const Found& found) {
        return found.event.kind == event.kind && std::abs(found.event.time_s - event.time_s) < kSame_s;
      });
      if (same == found_.end() && to_end_s > kSame_s) continue;
      is_seen |= same != found_.end();
      events.emplace_back(event, same == found_.end() ? std::nullopt : std::optional(same - found_.begin()));
    }
    return is_seen ? events : std::vector<Struck>();
  }

  void TakePlates() {
    for (const PlateContact& contact : o_.contacts)
      for (const bool is_other : {false, true})
        for (const auto& [event, same] : EventsOf(contact, is_other)) {
          walk_.by_plate.push_back({event, same ? found_[*same].event.time_s - event.time_s : NAN});
          Found& found = same ? found_[*same] : found_.emplace_back(Found{.travel = NAN});
          found.event = event;
          found.by_plate = true;
        }
  }

  // By what most of the events' stances show; what differs, as where somebody stops or turns, is left out.
  void ChooseGround() {
    Values travels;
    for (const Found& found : found_)
      if (std::isfinite(found.travel)) travels.push_back(found.travel);
    const auto ground_of = [](double travel) { return travel > 0.5 ? Ground::kOverground : Ground::kTreadmill; };
    walk_.ground = o_.ground.value_or(travels.empty() ? Ground::kOverground : ground_of(Median(travels)));
    if (o_.ground) return;
    const auto all = std::ssize(found_);
    std::erase_if(found_,
                  [&](const Found& found) { return !found.by_plate && ground_of(found.travel) != walk_.ground; });
    if (const auto left = all - std::ssize(found_); left > 0)
      walk_.left_out.push_back(
          fmt::format("{} left out: the person {} there", left == 1 ? "a step is" : fmt::format("{} steps are", left),
                      walk_.ground == Ground::kOverground ? "stops or turns" : "travels on a treadmill that stands"));
  }

  std::size_t NearestFrame(double time_s) const { return motion::NearestRow(leg_.motion.time_s, time_s); }

  // Whether the leg is seen from one heel strike to the next, with one toe-off between.
  bool IsStride(double begin_s, double end_s) {
    constexpr double kShortest_s = 0.4, kLongest_s = 3;
    const auto toe_offs = std::ranges::count_if(found_, [&](const Found& found) {
      return found.event.kind == StsEventKind::kToeOff && found.event.time_s > begin_s && found.event.time_s < end_s;
    });
    if (toe_offs != 1 || end_s - begin_s < kShortest_s || end_s - begin_s > kLongest_s) return false;
    double last_s = begin_s;
    for (std::size_t i = NearestFrame(begin_s); i <= NearestFrame(end_s); ++i) {
      if (!std::isfinite(leg_.motion.samples[i].knee_deg)) continue;
      if (leg_.motion.time_s[i] - last_s > std::max(kLongestGap_s, 2 * step_s_)) return false;
      last_s = leg_.motion.time_s[i];
    }
    return true;
  }

  void Number() {
    int number = 0;
    std::optional<double> last_s;
    for (Found& found : found_) {
      motion::StsEvent& event = found.event;
      if (event.kind == StsEventKind::kHeelStrike) {
        number += last_s && !IsStride(*last_s, event.time_s) ? 2 : 1;
        last_s = event.time_s;
      }
      event.repetition = number;
      event.frame = leg_.motion.frame[NearestFrame(event.time_s)];
      walk_.by_foot |= found.by_foot;
      walk_.events.push_back(event);
    }
  }

  // In running the foot is in the air for more than half of the stride.
  void LeaveOutRunning() {
    Values shares;
    for (const auto& [strike, off, next] : StridesOf(walk_.events))
      shares.push_back((off.time_s - strike.time_s) / (next.time_s - strike.time_s));
    if (shares.empty() || Median(shares) >= 0.5) return;
    walk_.events.clear();
    walk_.left_out.push_back(
        fmt::format("the foot is on the ground for {:.0f} % of a stride: the person runs", 100 * Median(shares)));
  }

  // Of the hip over the recording: forward or up.
  double HipRange(int axis) {
    Values places = Coordinate(leg_.leg_markers.hip, axis);
    std::erase_if(places, [](double place) { return !std::isfinite(place); });
    if (places.empty()) return 0;
    const auto [least, most] = std::ranges::minmax(places);
    return most - least;
  }

  // Whoever walks lifts a foot and puts it down, or has come farther than a step on level ground.
  void LeaveOutSingleSteps() {
    const double leg = leg_.signals.leg_length;
    if (HipRange(0) > leg && HipRange(1) < kMostRise * leg) return;
    const auto has = [&](StsEventKind kind, StsEventKind other) {
      return std::ranges::any_of(
          found_, [&](const Found& found) { return found.event.kind == kind || found.event.kind == other; });
    };
    if (!has(StsEventKind::kHeelStrike, StsEventKind::kHeelStrikeOther) ||
        !has(StsEventKind::kToeOff, StsEventKind::kToeOffOther))
      found_.clear();
  }

  // A sentence for each interval in which the person steps otherwise than forward on level ground.
  void SayWhatElse() {
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      const Interval& first = seen_[k];
      while (k + 1 < seen_.size() && seen_[k + 1].what == first.what) ++k;
      const std::string when = fmt::format("from {:.2f} to {:.2f} s", first.from_s, seen_[k].to_s);
      if (first.what == Seen::kNotLevel)
        walk_.left_out.push_back(when + " the hip rises or falls as on stairs or in a jump");
      if (first.what == Seen::kBackward)
        walk_.left_out.push_back(when + (LargestBend(first.from_s, seen_[k].to_s) > 0
                                             ? " the person walks backward"
                                             : " the person faces the other way (measure that part by itself: lake "
                                               "convert --crop)"));
    }
  }

  // Of the knee, with its sign: negative, or left out, where the person faces away from the side that the fit has.
  double LargestBend(double from_s, double to_s) const {
    double bend_deg = 0;
    for (std::size_t i = NearestFrame(from_s); i <= NearestFrame(to_s); ++i)
      if (const double knee_deg = leg_.motion.samples[i].knee_deg; std::abs(knee_deg) > std::abs(bend_deg))
        bend_deg = knee_deg;
    return bend_deg;
  }

  struct Interval {
    Seen what;
    double from_s, to_s;
  };

  const LegFitResult& leg_;
  const WalkingOptions& o_;
  const double step_s_ = MedianInterval(leg_.motion.time_s);
  std::map<std::pair<std::string, int>, Values> coordinates_;
  std::vector<Found> found_;
  std::vector<Interval> seen_;  // of the measured leg
  Walk walk_;
};

}  // namespace

std::vector<PlateLoad> LoadsOf(const std::vector<double>& force_n, const std::vector<double>& time_s) {
  constexpr double kLeast_n = 20, kShortest_s = 0.1, kShortestGap_s = 0.05, kMostEmpty_n = 100, kLowest = 0.02;
  std::vector<double> empty_n;
  if (force_n.size() < 2) return {};
  const double lowest_n = Quantile(force_n, kLowest);
  std::ranges::copy_if(force_n, std::back_inserter(empty_n), [&](double n) {
    return std::abs(lowest_n) < kMostEmpty_n && std::abs(n - lowest_n) < kLeast_n;
  });
  const double limit_n = (empty_n.empty() ? 0 : Median(empty_n)) + kLeast_n;
  const double noise_n = empty_n.size() > 1 ? RobustDeviation(empty_n) : 0;
  const auto crossing = [&](std::size_t after, double& sd_s) {
    const double step_s = time_s[after] - time_s[after - 1], step_n = force_n[after] - force_n[after - 1];
    sd_s = std::hypot(step_s / 2 / std::sqrt(12), noise_n * step_s / step_n);
    return time_s[after - 1] + (limit_n - force_n[after - 1]) / step_n * step_s;
  };
  std::vector<PlateLoad> loads;
  for (std::size_t i = 0; i < force_n.size();) {
    if (force_n[i] <= limit_n) {
      ++i;
      continue;
    }
    PlateLoad load{NAN, NAN, NAN, NAN};
    if (i > 0) load.begin_s = crossing(i, load.begin_sd_s);
    while (i < force_n.size() && force_n[i] > limit_n) ++i;
    if (i < force_n.size()) load.end_s = crossing(i, load.end_sd_s);
    if (!loads.empty() && load.begin_s - loads.back().end_s < kShortestGap_s) {
      loads.back().end_s = load.end_s;
      loads.back().end_sd_s = load.end_sd_s;
    } else {
      loads.push_back(load);
    }
  }
  std::erase_if(loads, [](const PlateLoad& load) { return load.end_s - load.begin_s < kShortest_s; });
  return loads;
}

std::vector<Stride> StridesOf(const std::vector<motion::StsEvent>& events) {
  std::map<std::pair<motion::StsEventKind, int>, motion::StsEvent> numbered;
  for (const motion::StsEvent& event : events) numbered.try_emplace({event.kind, event.repetition}, event);
  std::vector<Stride> strides;
  for (const auto& [key, strike] : numbered) {
    const auto off = numbered.find({motion::StsEventKind::kToeOff, key.second}),
               next = numbered.find({key.first, key.second + 1});
    if (key.first == motion::StsEventKind::kHeelStrike && off != numbered.end() && next != numbered.end())
      strides.push_back({strike, off->second, next->second});
  }
  return strides;
}

void CountStrides(const std::vector<motion::StsEvent>& events, Walk& walk) {
  const auto strikes = std::ranges::count(events, motion::StsEventKind::kHeelStrike, &motion::StsEvent::kind);
  walk.strides = static_cast<int>(StridesOf(events).size());
  // A stride goes on after each heel strike, and before it.
  walk.incomplete = static_cast<int>(2 * strikes) - 2 * walk.strides;
}

Walk FindWalk(const LegFitResult& leg, const WalkingOptions& options) {
  return WalkFinder(leg, options).Find();
}

}  // namespace lake::gait
