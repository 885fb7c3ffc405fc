#include "lake/gait/sts_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>

#include "lake/core/statistics.h"
#include "monotone_phases.h"

namespace lake::gait {

std::vector<MonotonePhase> FindMonotonePhases(const std::vector<double>& height, double threshold) {
  std::vector<MonotonePhase> phases;
  if (height.empty()) return phases;
  std::size_t low = 0, high = 0, start = 0;
  int direction = 0;  // of the phase that is open: 0 not known yet
  for (std::size_t i = 1; i < height.size(); ++i) {
    if (height[i] < height[low]) low = i;
    if (height[i] >= height[high]) high = i;
    if (direction <= 0 && height[i] - height[low] >= threshold) {
      phases.push_back({{start, low}, false});
      start = low;
      high = i;
      direction = 1;
    } else if (direction >= 0 && height[high] - height[i] >= threshold) {
      phases.push_back({{start, high}, true});
      start = high;
      low = i;
      direction = -1;
    }
    if (direction > 0) low = high;
    if (direction < 0) high = low;
  }
  if (direction != 0) phases.push_back({{start, direction > 0 ? high : low}, direction > 0});
  std::erase_if(phases, [&](const MonotonePhase& s) { return std::abs(height[s.end] - height[s.begin]) < threshold; });
  return phases;
}

namespace {

using Values = std::vector<double>;

// The signals without the frames in which one is not known; the trunk's is bridged there.
struct KnownSignals : StsSignals {
  std::vector<char> has_trunk;  // 0 or 1 per frame
};

// A cubic between two frames, with their speeds (Hermite).
void Bridge(std::size_t from, std::size_t to, KnownSignals& s) {
  const double duration_s = s.time_s[to] - s.time_s[from], step = s.trunk_deg[to] - s.trunk_deg[from];
  const double begin = s.trunk_deg_s[from] * duration_s, end = s.trunk_deg_s[to] * duration_s;
  const double square = 3 * step - 2 * begin - end, cube = begin + end - 2 * step;
  for (std::size_t i = from + 1; i < to; ++i) {
    const double u = (s.time_s[i] - s.time_s[from]) / duration_s;
    s.trunk_deg[i] = s.trunk_deg[from] + u * (begin + u * (square + u * cube));
    s.trunk_deg_s[i] = (begin + u * (2 * square + u * 3 * cube)) / duration_s;
  }
}

// Where no marker shows it, the trunk is taken to keep the lean in which it is first or last seen, and to turn smoothly
// from one to the next. Without any it says nothing: rest is left by the hip alone.
void BridgeTrunk(KnownSignals& s) {
  const auto hold = [&](std::size_t i, std::size_t as) {
    s.trunk_deg[i] = s.trunk_deg[as];
    s.trunk_deg_s[i] = 0;
  };
  const auto is_known = [&](std::size_t i) { return s.has_trunk[i] != 0; };
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < s.frame.size(); ++i) {
    if (!is_known(i)) continue;
    for (std::size_t k = 0; !last && k < i; ++k) hold(k, i);
    if (last) Bridge(*last, i, s);
    last = i;
  }
  for (std::size_t i = last ? *last + 1 : 0; i < s.frame.size(); ++i)
    if (last)
      hold(i, *last);
    else
      s.trunk_deg[i] = s.trunk_deg_s[i] = 0;
}

KnownSignals KnownOnly(const StsSignals& s) {
  KnownSignals known;
  known.leg_length = s.leg_length;
  for (std::size_t i = 0; i < s.frame.size(); ++i) {
    if (!std::isfinite(s.hip_height[i] + s.hip_up_speed[i] + s.hip_behind[i] + s.knee_deg[i] + s.knee_deg_s[i]))
      continue;
    known.frame.push_back(s.frame[i]);
    known.time_s.push_back(s.time_s[i]);
    known.hip_height.push_back(s.hip_height[i]);
    known.hip_up_speed.push_back(s.hip_up_speed[i]);
    known.hip_behind.push_back(s.hip_behind[i]);
    known.knee_deg.push_back(s.knee_deg[i]);
    known.knee_deg_s.push_back(s.knee_deg_s[i]);
    known.trunk_deg.push_back(s.trunk_deg[i]);
    known.trunk_deg_s.push_back(s.trunk_deg_s[i]);
    known.has_trunk.push_back(std::isfinite(s.trunk_deg[i] + s.trunk_deg_s[i]));
    if (s.sd.hip_height.empty()) continue;
    known.sd.hip_height.push_back(s.sd.hip_height[i]);
    known.sd.hip_up_speed.push_back(s.sd.hip_up_speed[i]);
    known.sd.knee_deg_s.push_back(s.sd.knee_deg_s[i]);
    known.sd.trunk_deg_s.push_back(s.sd.trunk_deg_s[i]);
  }
  BridgeTrunk(known);
  return known;
}

Values Negative(Values values) {
  for (double& value : values) value = -value;
  return values;
}

double Least(const Values& values, Span span) {
  return *std::min_element(values.begin() + static_cast<std::ptrdiff_t>(span.begin),
                           values.begin() + static_cast<std::ptrdiff_t>(span.end) + 1);
}

double Most(const Values& values, Span span) {
  return *std::max_element(values.begin() + static_cast<std::ptrdiff_t>(span.begin),
                           values.begin() + static_cast<std::ptrdiff_t>(span.end) + 1);
}

double Range(const Values& values, Span span) {
  return Most(values, span) - Least(values, span);
}

Values Part(const Values& values, Span span) {
  return {values.begin() + static_cast<std::ptrdiff_t>(span.begin),
          values.begin() + static_cast<std::ptrdiff_t>(span.end) + 1};
}

std::size_t FastestIn(const Values& speed, Span span) {
  const auto first = speed.begin() + static_cast<std::ptrdiff_t>(span.begin);
  return static_cast<std::size_t>(std::max_element(first, speed.begin() + static_cast<std::ptrdiff_t>(span.end) + 1) -
                                  speed.begin());
}

// One quantity of a rise or a lowering, in the direction in which it goes there. `speed_sd`: empty if not known.
struct Course {
  Values value, speed, speed_sd;
};

class EventFinder {
 public:
  EventFinder(const KnownSignals& signals, const StsOptions& options)
      : s_(signals),
        o_(options),
        hip_up_{s_.hip_height, s_.hip_up_speed, s_.sd.hip_up_speed},
        hip_down_{Negative(s_.hip_height), Negative(s_.hip_up_speed), s_.sd.hip_up_speed},
        flexion_{s_.knee_deg, s_.knee_deg_s, s_.sd.knee_deg_s},
        extension_{Negative(s_.knee_deg), Negative(s_.knee_deg_s), s_.sd.knee_deg_s} {}

  FoundStsEvents Find() {
    const std::vector<MonotonePhase> phases = FindMonotonePhases(s_.hip_height, o_.least_rise * s_.leg_length);
    FindSeats(phases);
    std::size_t rest_from = 0;  // the earliest frame at which the rest before the next rise can begin
    bool is_standing = false;   // since a rise that counts: the next lowering is that repetition's
    for (std::size_t k = 0; k < phases.size(); ++k) {
      const std::size_t until = k + 1 < phases.size() ? Fastest(phases[k + 1]) : s_.frame.size() - 1;
      if (phases[k].rising) {
        is_standing = AddIfRepetition(rest_from, phases[k], until);
        if (!is_standing && k > 0) AddSquat(phases[k - 1], phases[k], until);
      } else {
        rest_from = Fastest(phases[k]);
        if (is_standing) AddLowering(phases[k], until);
        is_standing = false;
      }
    }
    return std::move(found_);
  }

 private:
  // Where the hip rises or falls fastest.
  std::size_t Fastest(const MonotonePhase& phase) const {
    return FastestIn(phase.rising ? hip_up_.speed : hip_down_.speed, phase);
  }

  // The hip's heights on seats: where it is before a rise in which nobody could balance on the feet, or rests.
  void FindSeats(const std::vector<MonotonePhase>& phases) {
    std::size_t rest_from = 0;
    for (const MonotonePhase& phase : phases) {
      if (!phase.rising)
        rest_from = Fastest(phase);
      else if (IsOnSeat({rest_from, SeatOff(phase)}, phase))
        seat_heights_.push_back(s_.hip_height[phase.begin]);
    }
  }

  bool IsOnSeat(Span before, const MonotonePhase& rise) const {
    before.begin = std::min(before.begin, before.end);
    if (Most(s_.hip_behind, before) >= o_.least_behind * s_.leg_length) return true;
    const double hip = o_.seat_still * Range(s_.hip_height, rise);
    return LastStill(before, LongestPause(o_.seat_rest_s, rise), 1, {{&s_.hip_height, hip}, {&s_.hip_behind, hip}})
        .has_value();
  }

  bool HasSeat(const MonotonePhase& rise) const {
    return std::any_of(seat_heights_.begin(), seat_heights_.end(), [&](double height) {
      return std::abs(s_.hip_height[rise.begin] - height) <= o_.same_seat_height * s_.leg_length;
    });
  }

  // Adds the events of a rise if it is one that counts. `until`: the last frame that can be of it.
  bool AddIfRepetition(std::size_t rest_from, const MonotonePhase& rise, std::size_t until) {
    if (s_.knee_deg[rise.begin] - s_.knee_deg[rise.end] < o_.least_extension_deg) return false;
    const std::size_t seat_off = SeatOff(rise);
    found_.begins_during_rise |= seat_off == 0;
    if (seat_off == 0) return false;
    const motion::StsEvent left_seat = Crossing(motion::StsEventKind::kSeatOff, hip_up_.speed, hip_up_.speed_sd,
                                                o_.seat_off_fraction * Most(hip_up_.speed, rise), seat_off);
    if (!HasSeat(rise)) {
      found_.without_seat.push_back(left_seat);
      return false;
    }
    ++repetition_;
    if (std::optional<motion::StsEvent> onset = FindOnset({std::min(rest_from, seat_off), seat_off}, rise)) {
      if (onset->time_s > left_seat.time_s) {
        onset->frame = left_seat.frame;
        onset->time_s = left_seat.time_s;
      }
      Add(*onset);
    } else {
      found_.begins_during_lean = true;
    }
    Add(left_seat);
    Add(End(motion::StsEventKind::kStanding, extension_, o_.standing_fraction, rise, until));
    return true;
  }

  void AddLowering(const MonotonePhase& fall, std::size_t until) {
    const double limit = o_.standing_fraction * Most(flexion_.speed, fall);
    Add(Crossing(motion::StsEventKind::kDescent, flexion_.speed, flexion_.speed_sd, limit,
                 FirstMovement(flexion_, limit, fall)));
    Add(End(motion::StsEventKind::kSeated, hip_down_, o_.seat_off_fraction, fall, until));
  }

  // Down and up again, if both are recorded.
  void AddSquat(const MonotonePhase& fall, const MonotonePhase& rise, std::size_t until) {
    if (found_.without_seat.empty() || found_.without_seat.back().time_s < s_.time_s[rise.begin]) return;
    const double limit = o_.standing_fraction * Most(hip_down_.speed, fall);
    const std::size_t descent = FirstMovement(hip_down_, limit, fall);
    const auto standing = End(motion::StsEventKind::kStanding, hip_up_, o_.standing_fraction, rise, until);
    if (descent == 0 || !standing) return;
    std::size_t turned = rise.begin;
    while (turned < rise.end && hip_up_.speed[turned] <= 0) ++turned;
    for (motion::StsEvent event :
         {Crossing(motion::StsEventKind::kDescent, hip_down_.speed, hip_down_.speed_sd, limit, descent),
          Crossing(motion::StsEventKind::kBottom, hip_up_.speed, hip_up_.speed_sd, 0, turned), *standing}) {
      event.repetition = static_cast<int>(found_.squats.size() / 3) + 1;
      found_.squats.push_back(event);
    }
  }

  // The end of a movement, if it is recorded. Where it stops for long and then goes on a little, one of the two stops
  // is it.
  std::optional<motion::StsEvent> End(motion::StsEventKind kind, const Course& course, double fraction,
                                      const MonotonePhase& phase, std::size_t until) const {
    const double limit = fraction * Most(course.speed, phase);
    const std::size_t after = LastMovement(course, limit, phase, until, kLikely) + 1,
                      latest = LastMovement(course, limit, phase, until, kPossible) + 1;
    if (after == s_.frame.size()) return std::nullopt;
    motion::StsEvent end = Crossing(kind, course.speed, course.speed_sd, limit, after);
    if (latest > after) end.sd_s = std::hypot(end.sd_s, (s_.time_s[latest - 1] - end.time_s) / std::sqrt(2));
    return end;
  }

  void Add(std::optional<motion::StsEvent> event) {
    if (!event) return;
    event->repetition = repetition_;
    found_.events.push_back(*event);
  }

  // Where the values cross a limit in the step that ends at frame i; its middle, of unknown SD, if they do not. `sway`:
  // the standard deviation that they have beside the fit's.
  motion::StsEvent Crossing(motion::StsEventKind kind, const Values& values, const Values& sd, double limit,
                            std::size_t i, double sway = 0) const {
    const std::size_t before = i == 0 ? 0 : i - 1;
    const double step = values[i] - values[before], to_limit = limit - values[before];
    const double duration_s = s_.time_s[i] - s_.time_s[before];
    const bool crosses = step != 0 && to_limit / step >= 0 && to_limit / step <= 1;
    const double share = crosses ? to_limit / step : 0.5;
    motion::StsEvent event{
        .kind = kind, .frame = s_.frame[share < 0.5 ? before : i], .time_s = s_.time_s[before] + share * duration_s};
    if (crosses && !sd.empty()) event.sd_s = std::hypot(sd[i], sway) * duration_s / std::abs(step);
    return event;
  }

  std::size_t SeatOff(const MonotonePhase& rise) const {
    return FirstMovement(hip_up_, o_.seat_off_fraction * Most(hip_up_.speed, rise), rise);
  }

  // The first frame of the run faster than the limit that ends at `i`; not before `from`.
  static std::size_t RunBegin(const Values& speed, double limit, std::size_t from, std::size_t i) {
    while (i > from && speed[i - 1] > limit) --i;
    return i;
  }

  static std::size_t RunEnd(const Values& speed, double limit, std::size_t to, std::size_t i) {
    while (i < to && speed[i + 1] > limit) ++i;
    return i;
  }

  double LeastMovement(const Course& course, const MonotonePhase& phase) const {
    return (phase.rising ? o_.least_of_rise : o_.least_of_lowering) * Range(course.value, phase);
  }

  // The first frame of the first movement that belongs to the phase: faster than the limit, and not undone later.
  std::size_t FirstMovement(const Course& course, double limit, const MonotonePhase& phase) const {
    const double least = LeastMovement(course, phase);
    std::size_t first = RunBegin(course.speed, limit, 0, FastestIn(course.speed, phase));
    double lowest_later = course.value[first];
    for (std::size_t i = first; i-- > phase.begin;) {
      const std::size_t begin = course.speed[i] > limit ? RunBegin(course.speed, limit, phase.begin, i) : i;
      const double gain = course.value[i] - course.value[begin];
      if (gain >= least && lowest_later >= course.value[begin] + o_.kept * gain) first = begin;
      lowest_later = std::min(lowest_later, Least(course.value, {begin, i}));
      i = begin;
    }
    return first;
  }

  // A longer stop than a pause belongs to a movement that brings this fraction afterwards, if it is no longer than so
  // many times what the movement took until then.
  struct LongStop {
    double left, times;
  };
  static constexpr LongStop kLikely{0.05, 1}, kPossible{0.02, 2};

  // The last frame of the last movement that belongs to the phase: faster than the limit, not undone, and after a
  // pause at most, unless much is still to come.
  std::size_t LastMovement(const Course& course, double limit, const MonotonePhase& phase, std::size_t until,
                           const LongStop& longest) const {
    const double travel = Range(course.value, phase), pause_s = LongestPause(o_.rest_s, phase);
    std::size_t last = RunEnd(course.speed, limit, until, FastestIn(course.speed, phase));
    const double begin_s = s_.time_s[FirstMovement(course, limit, phase)];
    for (std::size_t i = last + 1; i <= until; ++i) {
      const double left = (course.value[phase.end] - course.value[last]) / travel;
      const double longest_s =
          left < longest.left ? pause_s : std::max(pause_s, longest.times * (s_.time_s[last] - begin_s));
      if (s_.time_s[i] - s_.time_s[last] > longest_s && left < o_.standing_left) break;
      if (course.speed[i] <= limit) continue;
      const std::size_t end = RunEnd(course.speed, limit, until, i);
      const double gain = course.value[end] - course.value[i];
      const Span after = {end, FrameAt(s_.time_s[end] + pause_s, until)};
      if (gain >= LeastMovement(course, phase) && Least(course.value, after) >= course.value[i] + o_.kept * gain)
        last = end;
      i = end;
    }
    return last;
  }

  // The last frame up to `last` that is not after a time.
  std::size_t FrameAt(double time_s, std::size_t last) const {
    const auto begin = s_.time_s.begin();
    const auto after = std::upper_bound(begin, begin + static_cast<std::ptrdiff_t>(last) + 1, time_s);
    return after == begin ? 0 : static_cast<std::size_t>(after - begin) - 1;
  }

  // What stops for less than this may be a pause in the movement.
  double LongestPause(double least_s, const MonotonePhase& phase) const {
    const double low = Least(s_.hip_height, phase), margin = 0.05 * Range(s_.hip_height, phase);
    const double high = Most(s_.hip_height, phase);
    const auto is_at_end = [&](std::size_t i) {
      return s_.hip_height[i] < low + margin || s_.hip_height[i] > high - margin;
    };
    Span middle = phase;
    while (middle.begin < middle.end && is_at_end(middle.begin)) ++middle.begin;
    while (middle.end > middle.begin && is_at_end(middle.end)) --middle.end;
    return std::max(least_s, o_.rest_fraction * (s_.time_s[middle.end] - s_.time_s[middle.begin]));
  }

  struct Band {
    const Values* values;
    double width;
  };

  // The last frames, for at least a duration, in which nothing leaves its band; nullopt if there are none.
  std::optional<Span> LastStill(Span in, double least_s, double narrowing, const std::vector<Band>& bands) const {
    for (std::size_t end = in.end + 1; end-- > in.begin;) {
      const std::size_t begin = StillFrom(in.begin, end, narrowing, bands);
      if (begin <= end && Seconds({begin, end}) >= least_s) return Span{begin, end};
      if (begin == in.begin) break;
    }
    return std::nullopt;
  }

  // The first frame from which nothing leaves its band until `end`.
  static std::size_t StillFrom(std::size_t from, std::size_t end, double narrowing, const std::vector<Band>& bands) {
    std::vector<Extent> extents(bands.size());
    std::size_t begin = end + 1;
    while (begin > from && Widen(extents, bands, narrowing, begin - 1)) --begin;
    return begin;
  }

  struct Extent {
    double low = INFINITY, high = -INFINITY;
  };

  // Whether the values of one more frame are still within their bands.
  static bool Widen(std::vector<Extent>& extents, const std::vector<Band>& bands, double narrowing, std::size_t frame) {
    for (std::size_t k = 0; k < bands.size(); ++k) {
      const double value = (*bands[k].values)[frame];
      extents[k] = {std::min(extents[k].low, value), std::max(extents[k].high, value)};
      if (extents[k].high - extents[k].low > narrowing * bands[k].width) return false;
    }
    return true;
  }

  // The values at rest, and how much they vary there.
  struct Rest {
    double middle, deviation;
  };

  static Rest RestOf(const Values& quiet) { return {Median(quiet), RobustDeviation(quiet)}; }

  // The quietest last part of a rest, and the frame from which the rest lasts.
  struct Stillness : Span {
    std::size_t from;
  };

  // Where hip, knee and trunk are still before a rise: in the narrowest bands in which they are for long enough, which
  // sway widens, else for the longest time, else in the frame in which they move least.
  Stillness FindRest(Span before, const MonotonePhase& rise) const {
    const double travel = Range(s_.hip_height, rise), pause_s = LongestPause(o_.rest_s, rise);
    const std::vector<Band> bands = {{&s_.hip_height, o_.rest_hip * travel},
                                     {&s_.hip_behind, o_.rest_hip * travel},
                                     {&s_.knee_deg, o_.rest_knee * Range(s_.knee_deg, rise)},
                                     {&s_.trunk_deg, o_.rest_trunk * Range(s_.trunk_deg, rise)}};
    for (const double widening : {1.0, 2.0, 4.0})
      if (const auto still = LastStill(before, pause_s, widening, bands)) return QuietestOf(*still, pause_s, bands);
    const Span longest = LongestStill(before, bands);
    if (Seconds(longest) >= o_.first_rest_s) return {longest, longest.begin};
    const std::size_t turn = Slowest(before, bands);
    return {{turn, turn}, turn};
  }

  Stillness QuietestOf(Span still, double least_s, const std::vector<Band>& bands) const {
    Span rest = still;
    for (const double narrowing : {1.0 / 4, 1.0 / 16})
      if (const auto narrower = LastStill(rest, least_s, narrowing, bands)) rest = *narrower;
    return {{std::max(rest.begin, FrameAt(s_.time_s[rest.end] - least_s, rest.end)), rest.end}, still.begin};
  }

  Span LongestStill(Span in, const std::vector<Band>& bands) const {
    Span longest = {in.begin, in.begin};
    for (std::size_t end = in.begin + 1; end <= in.end; ++end)
      if (const Span still = {StillFrom(in.begin, end, 1, bands), end}; Seconds(still) > Seconds(longest))
        longest = still;
    return longest;
  }

  double Seconds(Span span) const { return s_.time_s[span.end] - s_.time_s[span.begin]; }

  // The frame in which everything together moves least.
  static std::size_t Slowest(Span span, const std::vector<Band>& bands) {
    std::size_t slowest = span.begin;
    double least = INFINITY;
    for (std::size_t i = span.begin + 1; i < span.end; ++i) {
      double moved = 0;
      for (const Band& band : bands) moved += std::pow(((*band.values)[i + 1] - (*band.values)[i - 1]) / band.width, 2);
      if (moved < least) {
        slowest = i;
        least = moved;
      }
    }
    return slowest;
  }

  // What of a deviation at rest is not the fit's, by its standard deviations: a person's sway.
  static double BeyondFit(double deviation, const Values& sd, Span rest) {
    Values of_fit = sd.empty() ? Values() : Part(sd, rest);
    std::erase_if(of_fit, [](double value) { return !std::isfinite(value); });
    const double measured = of_fit.empty() ? 0 : Median(std::move(of_fit));
    return std::sqrt(std::max(0.0, deviation * deviation - measured * measured));
  }

  // When the trunk leaves rest, or the hip if it does so before; nullopt if that was before the recording.
  std::optional<motion::StsEvent> FindOnset(Span before, const MonotonePhase& rise) const {
    const Stillness rest = FindRest(before, rise);
    if (before.begin == 0 && Seconds(rest) < o_.first_rest_s) return std::nullopt;
    before.begin = rest.begin;
    const std::optional<Departure> trunk = TrunkLeaves(before, rest, rise);
    if (trunk && trunk->frame == 0) return std::nullopt;
    const Rest hip = RestOf(Part(s_.hip_height, rest));
    const double limit = std::max(o_.onset_height * Range(s_.hip_height, rise), 3 * hip.deviation);
    Values away = s_.hip_height;
    for (double& height : away) height = std::abs(height - hip.middle);
    std::size_t lifted = before.end;
    while (lifted > before.begin && away[lifted - 1] > limit) --lifted;
    if (trunk && trunk->frame <= lifted) {
      motion::StsEvent onset = Crossing(motion::StsEventKind::kOnset, s_.trunk_deg_s, s_.sd.trunk_deg_s,
                                        TrunkLimit(before, rise), trunk->frame);
      const double unseen_s = UnseenBefore(trunk->frame, rise);
      if (trunk->sway_s > 0 || unseen_s > 0)
        onset.sd_s = std::hypot(std::isfinite(onset.sd_s) ? onset.sd_s : 0, trunk->sway_s, unseen_s);
      return onset;
    }
    motion::StsEvent onset = Crossing(motion::StsEventKind::kOnset, away, s_.sd.hip_height, limit, lifted,
                                      BeyondFit(hip.deviation, s_.sd.hip_height, rest));
    // A marker that shows the lean too late to tell its begin: that was before the hip left rest, by about half of what
    // the hip takes to its largest speed.
    const std::size_t fastest = FastestIn(hip_up_.speed, rise);
    const bool begins_unseen = !trunk || UnseenBefore(trunk->frame, rise) > 0;
    if (begins_unseen && fastest > lifted && TrunkFrames({before.begin, fastest}) > 0)
      onset.sd_s = std::hypot(std::isfinite(onset.sd_s) ? onset.sd_s : 0, (s_.time_s[fastest] - s_.time_s[lifted]) / 2);
    // A hip that is away throughout the rest does not tell when it left: it was until the trunk did.
    if (trunk && std::isnan(onset.sd_s)) onset.sd_s = std::hypot(s_.time_s[trunk->frame] - onset.time_s, trunk->sway_s);
    return onset;
  }

  double TrunkLimit(Span before, const MonotonePhase& rise) const {
    return o_.onset_fraction * Most(s_.trunk_deg_s, {before.begin, FastestIn(hip_up_.speed, rise)});
  }

  // For how long the trunk may have been leaning, unseen, before a frame in which it first leans.
  double UnseenBefore(std::size_t frame, const MonotonePhase& rise) const {
    if (s_.has_trunk[frame] && (frame == 0 || s_.has_trunk[frame - 1])) return 0;
    std::size_t seen = frame, before = frame;
    while (seen + 1 < s_.has_trunk.size() && !s_.has_trunk[seen]) ++seen;
    while (before > 0 && (before == frame || !s_.has_trunk[before])) --before;
    const double gap_s = s_.has_trunk[before] ? s_.time_s[seen] - s_.time_s[before] : INFINITY;
    const std::size_t fastest = FastestIn(s_.trunk_deg_s, {seen, std::max(seen, FastestIn(hip_up_.speed, rise))});
    return std::min(gap_s,
                    SinceBegin(s_.trunk_deg_s[seen] / s_.trunk_deg_s[fastest], s_.time_s[fastest] - s_.time_s[seen]));
  }

  // How long ago a movement began that is at this part of its peak speed, and so long before that, if its speed is that
  // of a minimum-jerk movement, 16 u² (1 − u)² (Flash & Hogan 1985). No shape is certain: it is a standard deviation.
  static double SinceBegin(double part_of_peak, double to_peak_s) {
    const double to_peak = std::sqrt(1 - std::sqrt(std::clamp(part_of_peak, 0.0, 0.99)));  // of half the duration
    return to_peak_s * (1 - to_peak) / to_peak;
  }

  // The trunk's values in a span where a marker shows them; those of its end where none does.
  Values SeenOfTrunk(const Values& values, Span span) const {
    Values seen;
    for (std::size_t i = span.begin; i <= span.end; ++i)
      if (s_.has_trunk[i]) seen.push_back(values[i]);
    return seen.empty() ? Values{values[span.end]} : seen;
  }

  // Frames of a span in which a marker shows the trunk.
  std::size_t TrunkFrames(Span span) const {
    std::size_t frames = 0;
    for (std::size_t i = span.begin; i <= span.end; ++i) frames += s_.has_trunk[i] != 0;
    return frames;
  }

  // Whether a marker shows the trunk for half of a span, and before the lean is fastest.
  bool ShowsLean(Span span) const {
    const std::size_t fastest = FastestIn(s_.trunk_deg_s, span);
    return 2 * TrunkFrames(span) > span.end - span.begin &&
           (s_.has_trunk[span.begin] || (fastest > span.begin && s_.has_trunk[fastest - 1]));
  }

  // Where a movement begins, and the standard deviation of its time that the person's sway makes.
  struct Departure {
    std::size_t frame = 0;
    double sway_s = 0;
  };

  // What is seen of a lean that begins in sway.
  struct LeanInSway {
    double limit_deg_s;     // at which the onset is
    double speed_deg_s;     // where it leaves the sway
    double hidden_s;        // before that, by a steady jerk
    double joined_s;        // a swing of the sway runs into the lean so long before that begins
    bool is_mostly_hidden;  // the sway is a twentieth of the lean and more

    // How long a steady jerk takes to the limit.
    double ToLimit() const { return hidden_s * std::sqrt(limit_deg_s / speed_deg_s); }

    // What sway makes of the onset's time, 1 SD. The speed of a movement that begins with a steady jerk comes to the
    // limit with a slope of twice the limit over the time until then; the sway's speed over that slope is the SD, but
    // no more than where the onset may be anywhere in what the sway hides, and that where it hides most of the lean.
    // Where a swing runs into the lean, one beginning or the other is right.
    double DeviationOfOnset(double sway_deg_s) const {
      const double all_deg_s = std::sqrt(2) * sway_deg_s;  // a rest holds a swing or two, which seldom are the largest
      const double anywhere_s = hidden_s / std::sqrt(12.0), over_slope_s = all_deg_s * ToLimit() / (2 * limit_deg_s);
      return std::hypot(is_mostly_hidden ? anywhere_s : std::min(over_slope_s, anywhere_s),
                        std::min(1.0, all_deg_s / limit_deg_s) * joined_s);
    }
  };

  // The first frame in which the trunk turns forward for good; 0 if it does so from the beginning of the recording,
  // nullopt if it does not lean forward.
  std::optional<Departure> TrunkLeaves(Span before, const Stillness& rest, const MonotonePhase& rise) const {
    const Values &angle = s_.trunk_deg, &speed = s_.trunk_deg_s;
    const std::size_t fastest = FastestIn(hip_up_.speed, rise);
    if (!ShowsLean({std::min(rest.end, fastest), fastest})) return std::nullopt;
    const std::size_t deepest = FastestIn(angle, {before.begin, fastest});
    const Rest trunk = RestOf(SeenOfTrunk(angle, rest));
    const double lean = angle[deepest] - trunk.middle, limit = TrunkLimit(before, rise);
    if (!(lean > 0)) return std::nullopt;
    // What sway hides of the lean. Of a lean that it hides nearly all, the last three quarters are looked at.
    const double hidden = std::max(0.005 * lean, 5 * std::max(trunk.deviation, SwayOfTrunk(trunk.middle, rest)));
    const double departed = std::min(hidden, 0.25 * lean);
    const std::size_t i = LastRise(angle, trunk.middle + departed, {before.begin, deepest});
    const std::size_t begin = RunBegin(speed, limit, before.begin, i);
    // A movement that begins with a steady jerk has come so far in three times what it takes at its present speed.
    const Span lean_begins = {i, LastRise(angle, trunk.middle + 2 * departed, {i, deepest})};
    const double lean_deg_s = MeanOfMoving(speed, limit, lean_begins);
    if (!(lean_deg_s > 0)) return Departure{begin, 0};
    const double extrapolated_s = s_.time_s[i] - 3 * departed / lean_deg_s;
    std::size_t begun = std::min(begin, std::max(before.begin, FrameAt(extrapolated_s, i)));
    while (begun < begin && speed[begun] <= limit) ++begun;
    const LeanInSway seen{.limit_deg_s = limit,
                          .speed_deg_s = lean_deg_s,
                          .hidden_s = 3 * hidden / lean_deg_s,
                          .joined_s = std::max(0.0, extrapolated_s - s_.time_s[begin]),
                          .is_mostly_hidden = departed < hidden};
    // The end of a rest may be of the lean, whose speed has not come to the limit yet; where it begins the person may
    // still settle, which a robust deviation bears.
    const std::size_t may_begin = FrameAt(s_.time_s[begun] - seen.ToLimit(), begun);
    const Span still = {rest.from, std::clamp(may_begin, rest.from, rest.end)};
    return Departure{begun, seen.DeviationOfOnset(
                                BeyondFit(RobustDeviation(SeenOfTrunk(speed, still), 0), s_.sd.trunk_deg_s, still))};
  }

  // The trunk's deviation from its angle at rest in all of the rest: of its quietest part alone it would be too small.
  double SwayOfTrunk(double at_rest_deg, const Stillness& rest) const {
    return RobustDeviation(SeenOfTrunk(s_.trunk_deg, {rest.from, rest.end}), at_rest_deg);
  }

  // The first frame of the last run within a span, up to its end, of values above a level.
  static std::size_t LastRise(const Values& values, double level, Span in) {
    std::size_t i = in.end;
    while (i > in.begin && values[i - 1] > level) --i;
    return i;
  }

  // The mean speed without the pauses; NaN if there is nothing else.
  static double MeanOfMoving(const Values& speed, double limit, Span span) {
    Values moving = Part(speed, span);
    std::erase_if(moving, [&](double value) { return std::abs(value) <= limit; });
    return Mean(moving);
  }

  const KnownSignals& s_;
  const StsOptions& o_;
  const Course hip_up_, hip_down_, flexion_, extension_;
  std::vector<double> seat_heights_;
  FoundStsEvents found_;
  int repetition_ = 0;
};

}  // namespace

FoundStsEvents FindStsEvents(const StsSignals& signals, const StsOptions& options) {
  const KnownSignals known = KnownOnly(signals);
  return EventFinder(known, options).Find();
}

std::vector<std::string> UncertainEvents(const std::vector<motion::StsEvent>& events) {
  constexpr double kMost = 0.1;  // of the rise
  std::map<int, double> onset_s, standing_s;
  for (const motion::StsEvent& event : events) {
    if (event.kind == motion::StsEventKind::kOnset) onset_s[event.repetition] = event.time_s;
    if (event.kind == motion::StsEventKind::kStanding) standing_s[event.repetition] = event.time_s;
  }
  std::vector<std::string> sentences;
  for (const motion::StsEvent& event : events) {
    const int rise = event.repetition;
    if (event.kind != motion::StsEventKind::kOnset && event.kind != motion::StsEventKind::kStanding) continue;
    if (!onset_s.contains(rise) || !standing_s.contains(rise)) continue;
    const double duration_s = standing_s.at(rise) - onset_s.at(rise);
    if (!(event.sd_s > kMost * duration_s)) continue;
    sentences.push_back(fmt::format(
        "rise {}: its {} is uncertain by {:.2f} s (1 SD), and it takes {:.2f} s: look at the curves in lake "
        "review, and give the events with --events if you see them better",
        rise, motion::ToString(event.kind), event.sd_s, duration_s));
  }
  return sentences;
}

std::string OnsetsWithoutLean(const StsSignals& signals, const std::vector<motion::StsEvent>& events) {
  const double before_s = StsOptions{}.first_rest_s;
  std::vector<int> rises;
  for (const motion::StsEvent& event : events) {
    if (event.kind != motion::StsEventKind::kOnset || std::isnan(event.sd_s)) continue;
    const auto from = std::ranges::lower_bound(signals.time_s, event.time_s - before_s);
    const auto to = std::ranges::upper_bound(signals.time_s, event.time_s);
    const std::span<const double> lean(signals.trunk_deg.begin() + (from - signals.time_s.begin()), to - from);
    const auto unseen = std::ranges::count_if(lean, [](double angle) { return std::isnan(angle); });
    if (2 * unseen > std::ssize(lean)) rises.push_back(event.repetition);
  }
  if (rises.empty()) return "";
  const bool one = rises.size() == 1;
  return fmt::format(
      "rise{} {}: no marker shows the trunk lean before {}, so {} where the hip leaves its rest, or where one first "
      "shows the lean, which is later: "
      "compare "
      "percents and times only with those of trials without a waist marker too, or give the onset with --events",
      one ? "" : "s", fmt::join(rises, ", "), one ? "it" : "them", one ? "its onset is" : "their onsets are");
}

}  // namespace lake::gait
