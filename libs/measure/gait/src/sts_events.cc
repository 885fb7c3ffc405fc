#include "lake/gait/sts_events.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>

#include "lake/core/statistics.h"

namespace lake::gait {
namespace {

// A monotone stretch of the hip's height between two turning points.
struct Stretch {
  std::size_t begin, end;  // indices of the turning points, both included
  bool rising;
};

// Turning points that differ by at least `threshold`, smaller wiggles skipped; the stretches between them.
std::vector<Stretch> FindStretches(const std::vector<double>& height, double threshold) {
  std::vector<Stretch> stretches;
  if (height.empty()) return stretches;
  std::size_t low = 0, high = 0, start = 0;
  int direction = 0;  // of the stretch that is open: 0 not known yet
  for (std::size_t i = 1; i < height.size(); ++i) {
    if (height[i] < height[low]) low = i;
    if (height[i] >= height[high]) high = i;
    if (direction <= 0 && height[i] - height[low] >= threshold) {
      stretches.push_back({start, low, false});
      start = low, high = i, direction = 1;
    } else if (direction >= 0 && height[high] - height[i] >= threshold) {
      stretches.push_back({start, high, true});
      start = high, low = i, direction = -1;
    }
    if (direction > 0) low = high;
    if (direction < 0) high = low;
  }
  if (direction != 0) stretches.push_back({start, direction > 0 ? high : low, direction > 0});
  std::erase_if(stretches, [&](const Stretch& s) { return std::abs(height[s.end] - height[s.begin]) < threshold; });
  return stretches;
}

// The signals without the frames in which one is not known.
StsSignals KnownOnly(const StsSignals& s) {
  StsSignals known;
  known.leg_length = s.leg_length, known.units_per_mm = s.units_per_mm;
  for (std::size_t i = 0; i < s.frame.size(); ++i) {
    if (!std::isfinite(s.hip_height[i] + s.hip_speed[i] + s.hip_up_speed[i] + s.knee_deg_s[i])) continue;
    known.frame.push_back(s.frame[i]), known.time_s.push_back(s.time_s[i]);
    known.hip_height.push_back(s.hip_height[i]), known.hip_speed.push_back(s.hip_speed[i]);
    known.hip_up_speed.push_back(s.hip_up_speed[i]), known.knee_deg_s.push_back(s.knee_deg_s[i]);
    if (!s.hip_behind.empty()) known.hip_behind.push_back(s.hip_behind[i]);
    // Without a trunk, its speed says nothing: rest is left by the hip alone.
    const double trunk = i < s.trunk_deg_s.size() ? s.trunk_deg_s[i] : 0;
    known.trunk_deg_s.push_back(std::isfinite(trunk) ? trunk : 0);
  }
  return known;
}

class EventFinder {
 public:
  EventFinder(const StsSignals& signals, const StsOptions& options) : s_(signals), o_(options) {}

  FoundStsEvents Find() {
    const std::vector<Stretch> stretches = FindStretches(s_.hip_height, o_.least_rise * s_.leg_length);
    if (!s_.hip_behind.empty()) FindSeats(stretches);
    std::size_t rest_from = 0;  // the earliest frame at which the rest before the next rise can begin
    bool is_standing = false;   // since a rise that counts: the next lowering is that repetition's
    for (const Stretch& stretch : stretches) {
      if (stretch.rising) {
        is_standing = AddIfRepetition(rest_from, stretch);
      } else {
        rest_from = RestFrom(stretch);
        if (is_standing) AddLowering(stretch);
        is_standing = false;
      }
    }
    return std::move(found_);
  }

 private:
  // The earliest frame at which the rest after a lowering can begin.
  std::size_t RestFrom(const Stretch& fall) const { return Extreme(s_.hip_up_speed, fall, false); }

  // The hip's heights on seats: where it is before a rise in which nobody could balance on the feet, or rests.
  void FindSeats(const std::vector<Stretch>& stretches) {
    std::size_t rest_from = 0;
    for (const Stretch& stretch : stretches) {
      if (!stretch.rising)
        rest_from = RestFrom(stretch);
      else if (IsOnSeat(rest_from, SeatOff(rest_from, stretch)))
        seat_heights_.push_back(s_.hip_height[stretch.begin]);
    }
  }

  bool IsOnSeat(std::size_t rest_from, std::size_t seat_off) const {
    const auto behind = s_.hip_behind.begin();
    return *std::max_element(behind + static_cast<std::ptrdiff_t>(rest_from),
                             behind + static_cast<std::ptrdiff_t>(seat_off) + 1) >= o_.least_behind * s_.leg_length ||
           HipRests(rest_from, seat_off, o_.seat_rest_s).has_value();
  }

  bool HasSeat(const Stretch& rise) const {
    return std::any_of(seat_heights_.begin(), seat_heights_.end(), [&](double height) {
      return std::abs(s_.hip_height[rise.begin] - height) <= o_.same_seat_height * s_.leg_length;
    });
  }

  // Adds the events of a rise if it is one that counts.
  bool AddIfRepetition(std::size_t rest_from, const Stretch& rise) {
    if (Extension(rise) < o_.least_extension_deg) return false;
    const std::size_t seat_off = SeatOff(rest_from, rise);
    found_.begins_during_rise |= seat_off == 0;
    if (seat_off == 0) return false;
    const bool has_seat = s_.hip_behind.empty() || HasSeat(rise);
    if (!has_seat)
      found_.without_seat.push_back({0, motion::StsEventKind::kSeatOff, s_.frame[seat_off], s_.time_s[seat_off]});
    if (!has_seat) return false;
    const bool begins_during_lean = rest_from == 0 && !RestsBefore(seat_off);
    found_.begins_during_lean |= begins_during_lean;
    ++repetition_;
    if (!begins_during_lean) Add(motion::StsEventKind::kOnset, std::min(FindOnset(rest_from, seat_off), seat_off));
    AddRise(seat_off, rise);
    return true;
  }

  // Whether hip and trunk are still for a while somewhere before a frame.
  bool RestsBefore(std::size_t seat_off) const {
    const double limit = o_.rest_speed_mm_s * s_.units_per_mm;
    const auto is_still = [&](std::size_t i) {
      return s_.hip_speed[i] < limit && std::abs(s_.trunk_deg_s[i]) < o_.rest_trunk_deg_s;
    };
    return LastRun(0, seat_off, o_.first_rest_duration_s, is_still).has_value();
  }

  // The knee's extension over a stretch, from its speed.
  double Extension(const Stretch& stretch) const {
    double extension_deg = 0;
    for (std::size_t i = stretch.begin + 1; i <= stretch.end; ++i)
      extension_deg -= 0.5 * (s_.knee_deg_s[i] + s_.knee_deg_s[i - 1]) * (s_.time_s[i] - s_.time_s[i - 1]);
    return extension_deg;
  }

  std::size_t Extreme(const std::vector<double>& values, const Stretch& stretch, bool largest) const {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(stretch.begin);
    const auto last = values.begin() + static_cast<std::ptrdiff_t>(stretch.end) + 1;
    return static_cast<std::size_t>((largest ? std::max_element(first, last) : std::min_element(first, last)) -
                                    values.begin());
  }

  void Add(motion::StsEventKind kind, std::size_t i) {
    found_.events.push_back({repetition_, kind, s_.frame[i], s_.time_s[i]});
  }

  // The first frame of the run above the threshold that leads to the fastest rise.
  std::size_t SeatOff(std::size_t rest_from, const Stretch& rise) const {
    const std::size_t fastest_rise = Extreme(s_.hip_up_speed, rise, true);
    std::size_t seat_off = fastest_rise;
    while (seat_off > rest_from && s_.hip_up_speed[seat_off - 1] > o_.seat_off_fraction * s_.hip_up_speed[fastest_rise])
      --seat_off;
    return seat_off;
  }

  void AddRise(std::size_t seat_off, const Stretch& rise) {
    Add(motion::StsEventKind::kSeatOff, seat_off);
    const std::size_t fastest_extension = Extreme(s_.knee_deg_s, rise, false);
    for (std::size_t i = fastest_extension; i < s_.frame.size(); ++i)
      if (s_.knee_deg_s[i] > o_.standing_fraction * s_.knee_deg_s[fastest_extension])
        return Add(motion::StsEventKind::kStanding, i);
  }

  void AddLowering(const Stretch& fall) {
    const std::size_t fastest_flexion = Extreme(s_.knee_deg_s, fall, true);
    std::size_t descent = fastest_flexion;
    while (descent > fall.begin && s_.knee_deg_s[descent - 1] > o_.standing_fraction * s_.knee_deg_s[fastest_flexion])
      --descent;
    Add(motion::StsEventKind::kDescent, descent);
    const std::size_t fastest_fall = Extreme(s_.hip_up_speed, fall, false);
    for (std::size_t i = fastest_fall; i < s_.frame.size(); ++i)
      if (s_.hip_up_speed[i] > o_.seat_off_fraction * s_.hip_up_speed[fastest_fall])
        return Add(motion::StsEventKind::kSeated, i);
  }

  // The last run of at least a duration in [from, to] in which `holds`; its first and last frame.
  template <typename Predicate>
  std::optional<Stretch> LastRun(std::size_t from, std::size_t to, double least_s, const Predicate& holds) const {
    for (std::size_t end = to + 1; end-- > from;) {
      if (!holds(end)) continue;
      std::size_t begin = end;
      while (begin > from && holds(begin - 1)) --begin;
      if (s_.time_s[end] - s_.time_s[begin] >= least_s) return Stretch{begin, end, false};
      end = begin;
      if (begin == from) break;
    }
    return std::nullopt;
  }

  // The last run of frames in [from, to], of at least a duration, in which the hip is slow.
  std::optional<Stretch> HipRests(std::size_t from, std::size_t to, double least_s) const {
    const double limit = o_.rest_speed_mm_s * s_.units_per_mm;
    return LastRun(from, to, least_s, [&](std::size_t i) { return s_.hip_speed[i] < limit; });
  }

  // The rest before a rise: the last run of slow frames, else the slowest frame.
  Stretch FindRest(std::size_t from, std::size_t seat_off) const {
    if (const auto run = HipRests(from, seat_off, o_.rest_duration_s)) return *run;
    const std::size_t slowest = Extreme(s_.hip_speed, {from, seat_off, false}, false);
    return {slowest, slowest, false};
  }

  static std::vector<double> Part(const std::vector<double>& values, const Stretch& stretch) {
    return {values.begin() + static_cast<std::ptrdiff_t>(stretch.begin),
            values.begin() + static_cast<std::ptrdiff_t>(stretch.end) + 1};
  }

  std::size_t FindOnset(std::size_t from, std::size_t seat_off) const {
    const Stretch rest = FindRest(from, seat_off);
    const std::vector<double> heights = Part(s_.hip_height, rest), turns = Part(s_.trunk_deg_s, rest);
    const double height = Median(heights), turn = Median(turns);
    const double height_limit =
        std::max(o_.onset_deviations * RobustDeviation(heights), o_.onset_height_mm * s_.units_per_mm);
    const double turn_limit = std::max(o_.onset_deviations * RobustDeviation(turns), o_.onset_trunk_deg_s);
    const auto at_rest = [&](std::size_t i) {
      return std::abs(s_.hip_height[i] - height) <= height_limit && std::abs(s_.trunk_deg_s[i] - turn) <= turn_limit;
    };
    // Backward from the rise, so that fidgeting and the end of the last lowering do not count.
    if (const auto quiet = LastRun(rest.begin, seat_off, o_.rest_duration_s, at_rest)) return quiet->end + 1;
    for (std::size_t i = seat_off; i > rest.begin; --i)
      if (at_rest(i - 1)) return i;
    return rest.begin;
  }

  const StsSignals& s_;
  const StsOptions& o_;
  std::vector<double> seat_heights_;
  FoundStsEvents found_;
  int repetition_ = 0;
};

}  // namespace

FoundStsEvents FindStsEvents(const StsSignals& signals, const StsOptions& options) {
  const StsSignals known = KnownOnly(signals);
  return EventFinder(known, options).Find();
}

void SetRepetitions(const std::vector<motion::StsEvent>& events, motion::LegMotion& motion) {
  for (motion::LegSample& sample : motion.samples)
    sample.repetition.reset(), sample.percent = motion::LegSample::kUnknown;
  std::map<int, double> onset_s;
  for (const motion::StsEvent& event : events) {
    if (event.kind == motion::StsEventKind::kOnset) onset_s[event.repetition] = event.time_s;
    if (event.kind != motion::StsEventKind::kStanding || !onset_s.contains(event.repetition)) continue;
    const double begin_s = onset_s.at(event.repetition), duration_s = event.time_s - begin_s;
    for (std::size_t i = 0; i < motion.samples.size(); ++i) {
      if (motion.time_s[i] < begin_s || motion.time_s[i] > event.time_s) continue;
      motion.samples[i].repetition = event.repetition;
      motion.samples[i].percent = duration_s > 0 ? 100 * (motion.time_s[i] - begin_s) / duration_s : 100;
    }
  }
}

}  // namespace lake::gait
