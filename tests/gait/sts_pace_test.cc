// The events of one path, however fast it is gone along: slowly, with a pause anywhere, with sway.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "lake/core/statistics.h"
#include "lake/gait/sts_events.h"
#include "sway.h"
#include "synthetic_leg.h"

namespace lake {
namespace {

using Warp = std::function<double(double)>;  // the time of the original from the time of the played motion

// One rise of 2.8 s after two seconds of rest, as the synthetic leg moves, seen at `rate_hz` from 0 to `length_s`.
constexpr double kRest_s = 2, kRise_s = 2.8;

gait::StsSignals Play(const Warp& original_s, double length_s, double rate_hz, const Sway& sway = {},
                      double slide_mm = 0) {
  std::mt19937 random(sway.seed);
  const SlowNoise trunk(random), knee(random), hip_up(random), hip_behind(random);
  const auto trunk_deg = [&](double t) {
    return RiseAngles((original_s(t) - kRest_s) / kRise_s).trunk_deg + sway.trunk_deg * trunk.At(t);
  };
  const auto leg = [&](double t) { return RiseAngles((original_s(t) - kRest_s) / kRise_s); };
  const auto knee_deg = [&](double t) { return leg(t).shank_deg - leg(t).thigh_deg + sway.knee_deg * knee.At(t); };
  const auto height = [&](double t) {
    return 430 * std::cos(RadiansFromDegrees(leg(t).shank_deg)) + 410 * std::cos(RadiansFromDegrees(leg(t).thigh_deg)) +
           sway.hip_mm * hip_up.At(t);
  };
  const auto behind = [&](double t) {
    const double slide = slide_mm * MinimumJerk((original_s(t) - kRest_s) / (0.3 * kRise_s));
    return -430 * std::sin(RadiansFromDegrees(leg(t).shank_deg)) -
           410 * std::sin(RadiansFromDegrees(leg(t).thigh_deg)) - slide + sway.hip_mm * hip_behind.At(t);
  };
  const auto slope = [&](const auto& value, double t) { return (value(t + 1e-3) - value(t - 1e-3)) / 2e-3; };
  gait::StsSignals signals;
  signals.leg_length = 840;
  for (int i = 0; i / rate_hz < length_s; ++i) {
    const double t = i / rate_hz;
    signals.frame.push_back(i), signals.time_s.push_back(t);
    signals.hip_height.push_back(height(t)), signals.hip_up_speed.push_back(slope(height, t));
    signals.hip_behind.push_back(behind(t));
    signals.knee_deg.push_back(knee_deg(t)), signals.knee_deg_s.push_back(slope(knee_deg, t));
    signals.trunk_deg.push_back(trunk_deg(t)), signals.trunk_deg_s.push_back(slope(trunk_deg, t));
  }
  for (auto* sd : {&signals.sd.hip_height, &signals.sd.hip_up_speed, &signals.sd.knee_deg_s, &signals.sd.trunk_deg,
                   &signals.sd.trunk_deg_s})
    sd->assign(signals.frame.size(), 0);
  return signals;
}

struct Events {
  double onset_s = NAN, seat_off_s = NAN, standing_s = NAN;
};

Events EventsOf(const gait::StsSignals& signals) {
  Events found;
  for (const motion::StsEvent& event : gait::FindStsEvents(signals).events) {
    EXPECT_EQ(event.repetition, 1);
    if (event.kind == motion::StsEventKind::kOnset) found.onset_s = event.time_s;
    if (event.kind == motion::StsEventKind::kSeatOff) found.seat_off_s = event.time_s;
    if (event.kind == motion::StsEventKind::kStanding) found.standing_s = event.time_s;
  }
  return found;
}

motion::StsEvent OnsetOf(const gait::StsSignals& signals) {
  for (const motion::StsEvent& event : gait::FindStsEvents(signals).events)
    if (event.kind == motion::StsEventKind::kOnset) return event;
  ADD_FAILURE() << "no onset";
  return {};
}

constexpr double kLength_s = kRest_s + kRise_s + 2;

// So long a rise after the same rest.
Warp Lasting(double rise_s) {
  return [=](double t) { return kRest_s + (t - kRest_s) * kRise_s / rise_s; };
}

Events Natural() {
  return EventsOf(Play([](double t) { return t; }, kLength_s, 60));
}

// The pace falls to nothing within 0.2 s and comes back within 0.2 s.
Warp PausedAt(double at_s, double pause_s) {
  return [=](double t) {
    constexpr double kRamp_s = 0.2;
    const auto ramp = [](double u) { return u - u * u / 2; };  // integral of 1 - u
    const double halt = at_s + kRamp_s, go = halt + pause_s;
    if (t <= at_s) return t;
    if (t <= halt) return at_s + kRamp_s * ramp((t - at_s) / kRamp_s);
    const double reached = at_s + kRamp_s / 2;
    if (t <= go) return reached;
    if (t <= go + kRamp_s) return reached + kRamp_s / 2 - kRamp_s * ramp(1 - (t - go) / kRamp_s);
    return reached + kRamp_s / 2 + (t - go - kRamp_s);
  };
}

// A stop takes the pause and two ramps, in which a ramp's length is gone along.
TEST(StsPace, APauseMovesNothingButWhatComesAfterIt) {
  const Events natural = Natural();
  for (const double pause_s : {0.1, 0.3, 0.8, 1.5})
    for (double at_s = natural.onset_s - 0.1; at_s < natural.standing_s; at_s += 0.03) {
      const Events paused = EventsOf(Play(PausedAt(at_s, pause_s), kLength_s + pause_s + 0.2, 60));
      const auto expected = [&](double event_s) { return event_s > at_s + 0.1 ? event_s + pause_s + 0.2 : event_s; };
      SCOPED_TRACE(testing::Message() << "stopped for " << pause_s << " s at " << at_s << " s");
      const auto expect = [&](const char* what, double found_s, double event_s) {
        // A stop on the very moment of an event may be said to be before it or after it.
        if (std::abs(event_s - at_s - 0.1) > 0.13) {
          EXPECT_NEAR(found_s, expected(event_s), 0.1) << what;
        }
      };
      expect("onset", paused.onset_s, natural.onset_s);
      expect("seat-off", paused.seat_off_s, natural.seat_off_s);
      expect("standing", paused.standing_s, natural.standing_s);
    }
}

TEST(StsPace, EventsAreThoseOfThePath) {
  const Events natural = Natural();
  for (const double rise_s : {0.9, 2.0, 4.0, 8.0, 16.0, 35.0})
    for (const double slide_mm : {0.0, 60.0}) {
      const double factor = rise_s / kRise_s;
      const auto at = [&](double event_s) { return kRest_s + (event_s - kRest_s) * factor; };
      const Events slow = EventsOf(Play(Lasting(rise_s), kRest_s + rise_s + 2, 60, {}, slide_mm));
      SCOPED_TRACE(testing::Message() << rise_s << " s, sliding by " << slide_mm << " mm");
      EXPECT_NEAR(slow.onset_s, at(natural.onset_s), 0.005 * rise_s + 0.01);
      EXPECT_NEAR(slow.seat_off_s, at(natural.seat_off_s), 0.005 * rise_s + 0.01);
      EXPECT_NEAR(slow.standing_s, at(natural.standing_s), 0.005 * rise_s + 0.01);
    }
}

// A seated person's sway hides the first fifth of a slow lean: where it began is extrapolated.
TEST(StsPace, SwayHardlyMovesTheEvents) {
  const Events natural = Natural();
  for (const double slide_mm : {0.0, 60.0}) {
    std::vector<double> onset_error, seat_off_error, standing_error;  // of the rise's duration
    for (const double rise_s : {2.0, 4.0, 8.0, 16.0, 35.0})
      for (unsigned seed = 1; seed <= 20; ++seed) {
        const double factor = rise_s / kRise_s;
        const Events slow = EventsOf(Play(Lasting(rise_s), kRest_s + rise_s + 3, 60, {0.2, 0.2, 1, seed}, slide_mm));
        const auto error_s = [&](double found_s, double event_s) {
          return std::abs(found_s - kRest_s - (event_s - kRest_s) * factor);
        };
        onset_error.push_back(error_s(slow.onset_s, natural.onset_s) / rise_s);
        seat_off_error.push_back(error_s(slow.seat_off_s, natural.seat_off_s) / rise_s);
        standing_error.push_back(error_s(slow.standing_s, natural.standing_s) / rise_s);
      }
    SCOPED_TRACE(testing::Message() << "sliding by " << slide_mm << " mm");
    EXPECT_LT(Quantile(onset_error, 0.85), 0.02);
    EXPECT_LT(Quantile(onset_error, 1), 0.05);
    EXPECT_LT(Quantile(seat_off_error, 0.95), 0.02);
    EXPECT_LT(Quantile(standing_error, 0.9), 0.02);
  }
}

// As if the waist marker were seen first at a time, with another lean at rest.
gait::StsSignals SeenFrom(double from_s, gait::StsSignals signals, double more_lean_deg = 0) {
  for (std::size_t i = 0; i < signals.frame.size(); ++i) {
    signals.trunk_deg[i] += more_lean_deg;
    if (signals.time_s[i] < from_s) signals.trunk_deg[i] = signals.trunk_deg_s[i] = NAN;
  }
  return signals;
}

// Nothing is known of a lean before its marker is seen. The marker's appearance is no movement.
TEST(StsPace, AWaistMarkerThatAppearsIsNoOnset) {
  constexpr double kBefore_s = 4, kDuration_s = 1.7;
  const auto rise = [](double t) { return kRest_s + (t - kBefore_s) * kRise_s / kDuration_s; };
  const gait::StsSignals whole = Play(rise, kBefore_s + kDuration_s + 2, 60);
  const motion::StsEvent expected = OnsetOf(whole);
  for (const double more_lean_deg : {-1.0, 5.0, 15.0})
    for (const double before_s : {3.0, 1.9, 1.05, 0.6, 0.3, 0.1, 0.03}) {
      SCOPED_TRACE(testing::Message() << "seen for " << before_s << " s, leaning by " << 5 + more_lean_deg);
      const gait::StsSignals late = SeenFrom(expected.time_s - before_s, whole, more_lean_deg);
      EXPECT_NEAR(OnsetOf(late).time_s, expected.time_s, 0.02);
    }
}

// A lean that has begun when its marker is first seen: the onset is by then, and is said to be uncertain.
TEST(StsPace, ALeanThatHasBegunWhenItIsSeenIsUncertain) {
  for (const double duration_s : {1.2, 1.7, 4.0}) {
    const auto rise = [=](double t) { return kRest_s + (t - 4) * kRise_s / duration_s; };
    const gait::StsSignals whole = Play(rise, 4 + duration_s + 2, 60);
    const double expected_s = OnsetOf(whole).time_s;
    for (const double share : {0.04, 0.08, 0.12, 0.2, 0.3}) {
      SCOPED_TRACE(testing::Message() << duration_s << " s, seen after " << share);
      const gait::StsSignals late = SeenFrom(expected_s + share * duration_s, whole);
      const gait::FoundStsEvents found = gait::FindStsEvents(late);
      const motion::StsEvent onset = OnsetOf(late);
      EXPECT_LT(std::abs(onset.time_s - expected_s), 2 * onset.sd_s + 0.02);
      EXPECT_LT(onset.time_s - expected_s, 0.25 * duration_s);
      EXPECT_NE(gait::OnsetsWithoutLean(late, found.events), "");
    }
  }
}

// A waist marker that is hidden while the lean begins.
TEST(StsPace, AnOnsetWithinAGapIsAsUncertainAsTheGap) {
  const gait::StsSignals whole = Play([](double t) { return t; }, kLength_s, 60);
  const double expected_s = OnsetOf(whole).time_s;
  for (const double from_s : {-0.5, -0.2, -0.05})
    for (const double to_s : {0.1, 0.3}) {
      gait::StsSignals hidden = whole;
      for (std::size_t i = 0; i < hidden.frame.size(); ++i)
        if (hidden.time_s[i] > expected_s + from_s && hidden.time_s[i] < expected_s + to_s)
          hidden.trunk_deg[i] = hidden.trunk_deg_s[i] = NAN;
      const motion::StsEvent onset = OnsetOf(hidden);
      SCOPED_TRACE(testing::Message() << "hidden from " << from_s << " to " << to_s);
      EXPECT_LT(std::abs(onset.time_s - expected_s), 2 * onset.sd_s);
      EXPECT_LT(onset.sd_s, to_s - from_s + 0.02);  // a frame
    }
}

// Who stops close to standing, and goes on later, has not stood. Original times of the stop; the knee stops at 21 to
// 9° of the 92° that it extends by.
TEST(StsPace, ALongPauseNearExtensionIsNotStanding) {
  const double natural_s = Natural().standing_s;
  for (const double rise_s : {10.0, 20.0})
    for (const double knee_deg : {26.0, 20.0, 14.0})
      for (const double pause_s : {2.2, 3.0}) {
        double at_s = kRest_s;
        const auto knee = [](double t) {
          const SyntheticAngles angles = RiseAngles((t - kRest_s) / kRise_s);
          return angles.shank_deg - angles.thigh_deg;
        };
        while (at_s < kRest_s + 0.4 * kRise_s || knee(at_s) > knee_deg) at_s += 1e-3;
        const double factor = rise_s / kRise_s, pause = pause_s / factor;
        const Warp paused = PausedAt(at_s, pause);
        const auto slow = [&](double t) { return paused(kRest_s + (t - kRest_s) / factor); };
        const double expected_s = kRest_s + (natural_s + pause + 0.2 - kRest_s) * factor;
        for (const double stands_s : {3.0, 15.0}) {
          SCOPED_TRACE(testing::Message() << rise_s << " s, stopped for " << pause_s << " s at " << knee_deg
                                          << " deg, then standing for " << stands_s);
          EXPECT_NEAR(EventsOf(Play(slow, expected_s + stands_s, 60)).standing_s, expected_s, 0.02 * rise_s);
        }
      }
}

// With 3 % of the extension to come a long stop may be the end of the rise or not: the deviation says so.
TEST(StsPace, AStopThatMayBeStandingMakesItUncertain) {
  constexpr double kFactor = 10 / kRise_s;
  const Warp paused = PausedAt(4.34, 2.2 / kFactor);
  const auto slow = [&](double t) { return paused(kRest_s + (t - kRest_s) / kFactor); };
  const std::vector<motion::StsEvent> events = gait::FindStsEvents(Play(slow, 20, 60)).events;
  const double expected_s = kRest_s + (Natural().standing_s + 2.2 / kFactor + 0.2 - kRest_s) * kFactor;
  EXPECT_EQ(events.back().kind, motion::StsEventKind::kStanding);
  EXPECT_GT(events.back().sd_s, 1);
  EXPECT_LT(std::abs(events.back().time_s - expected_s), 2 * events.back().sd_s);
}

// Whoever has stood up and shifts a little after a while has stood up before that.
TEST(StsPace, AShiftOfAStandingPersonIsNoRise) {
  const double natural_s = Natural().standing_s;
  for (const double shift_deg : {1.0, 3.0, 6.0})
    for (const double after_s : {3.0, 6.0}) {
      gait::StsSignals signals = Play([](double t) { return t; }, kLength_s + 12, 60);
      const double at_s = natural_s + after_s;
      for (std::size_t i = 0; i < signals.frame.size(); ++i) {
        const auto flexion = [&](double t) { return shift_deg * (1 - MinimumJerk(t - at_s)); };
        const double t = signals.time_s[i];
        signals.knee_deg[i] += t > natural_s ? flexion(t) : shift_deg;
        if (t > natural_s) signals.knee_deg_s[i] += (flexion(t + 1e-3) - flexion(t - 1e-3)) / 2e-3;
      }
      SCOPED_TRACE(testing::Message() << shift_deg << " deg after " << after_s);
      const std::vector<motion::StsEvent> events = gait::FindStsEvents(signals).events;
      EXPECT_LT(std::abs(events.back().time_s - natural_s), 0.03 + 2 * events.back().sd_s);
      EXPECT_EQ(events.back().kind, motion::StsEventKind::kStanding);
    }
}

// The errors of onsets in a sway, over what is said of them, for a rise after a rest.
std::vector<double> OnsetErrorsInDeviations(double sway_deg, double rise_s, double rest_s) {
  const double natural_s = OnsetOf(Play([](double t) { return t; }, kLength_s, 60)).time_s;
  const double factor = rise_s / kRise_s, true_s = rest_s + (natural_s - kRest_s) * factor;
  const auto slowly = [&](double t) { return kRest_s + (t - rest_s) / factor; };
  std::vector<double> errors;
  for (const double slide_mm : {0.0, 60.0})
    for (unsigned seed = 101; seed <= 120; ++seed) {
      // A seat holds the hip: it moves less than the trunk.
      const double hip_mm = std::min(5.0, 5 * sway_deg);
      const Sway sway{.trunk_deg = sway_deg, .knee_deg = sway_deg, .hip_mm = hip_mm, .seed = seed};
      const motion::StsEvent onset = OnsetOf(Play(slowly, rest_s + rise_s + 3, 60, sway, slide_mm));
      EXPECT_GT(onset.sd_s, 0);
      errors.push_back((onset.time_s - true_s) / onset.sd_s);
    }
  return errors;
}

// How large is the error of an onset that sway moves is told by its SD, whether the sway is slower than the lean or
// not, and where it hides most of the lean.
TEST(StsPace, TheOnsetsDeviationHoldsTheSway) {
  std::vector<double> all;
  for (const double rest_s : {2.0, 6.0})
    for (const double sway_deg : {0.05, 0.2, 0.5, 1.0, 2.0})
      for (const double rise_s : {2.0, 8.0, 35.0}) {
        const std::vector<double> errors = OnsetErrorsInDeviations(sway_deg, rise_s, rest_s);
        SCOPED_TRACE(testing::Message() << "sway of " << sway_deg << " deg, a rise of " << rise_s << " s after "
                                        << rest_s << " s of rest");
        // Of 40 drawn errors. A rest of 2 s shows the sway's size no better than by half, so the groups differ.
        EXPECT_GT(RootMeanSquare(errors), 0.4);
        EXPECT_LT(RootMeanSquare(errors), 1.6);
        all.insert(all.end(), errors.begin(), errors.end());
      }
  const auto held = std::ranges::count_if(all, [](double error) { return std::abs(error) <= 2; });
  EXPECT_GE(static_cast<double>(held), 0.9 * static_cast<double>(all.size()));
}

// Who keeps still has an onset that is known as well as the markers are, here exactly.
TEST(StsPace, WithoutSwayNothingIsAddedToTheDeviation) {
  for (const double rise_s : {2.0, 8.0, 35.0}) {
    const motion::StsEvent onset = OnsetOf(Play(Lasting(rise_s), kRest_s + rise_s + 3, 60));
    EXPECT_LT(onset.sd_s, 0.001 * rise_s) << rise_s;
  }
}

}  // namespace
}  // namespace lake
