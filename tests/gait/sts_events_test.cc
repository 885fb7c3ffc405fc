#include "lake/gait/sts_events.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "lake/gait/leg_fit.h"
#include "lake/gait/movement.h"
#include "synthetic_leg.h"

namespace lake {
namespace {

std::vector<double> Derivative(const std::vector<double>& values, const std::vector<double>& time_s) {
  std::vector<double> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t a = i == 0 ? 0 : i - 1, b = std::min(i + 1, values.size() - 1);
    result[i] = (values[b] - values[a]) / (time_s[b] - time_s[a]);
  }
  return result;
}

gait::StsSignals SignalsOf(const SyntheticLeg& leg) {
  gait::StsSignals signals;
  signals.time_s = leg.time_s;
  for (std::size_t i = 0; i < leg.time_s.size(); ++i) {
    signals.frame.push_back(static_cast<std::int64_t>(i));
    signals.hip_height.push_back(leg.points_mm[i].hip->y());
    signals.knee_deg.push_back(leg.truth[i].knee_deg);
    signals.trunk_deg.push_back(leg.truth[i].trunk_deg);
  }
  signals.hip_up_speed = Derivative(signals.hip_height, leg.time_s);
  for (const motion::LegSample& sample : leg.truth) signals.hip_behind.push_back(-sample.ak.x() - sample.kh.x());
  signals.knee_deg_s = Derivative(signals.knee_deg, leg.time_s);
  signals.trunk_deg_s = Derivative(signals.trunk_deg, leg.time_s);
  signals.leg_length = 840;
  return signals;
}

constexpr std::vector<double> gait::StsSignals::*kColumns[] = {
    &gait::StsSignals::time_s,     &gait::StsSignals::hip_height, &gait::StsSignals::hip_up_speed,
    &gait::StsSignals::hip_behind, &gait::StsSignals::knee_deg,   &gait::StsSignals::knee_deg_s,
    &gait::StsSignals::trunk_deg,  &gait::StsSignals::trunk_deg_s};

std::vector<double> TimesOf(const std::vector<motion::StsEvent>& events, motion::StsEventKind kind) {
  std::vector<double> times;
  for (const motion::StsEvent& event : events)
    if (event.kind == kind) times.push_back(event.time_s);
  return times;
}

TEST(StsEvents, EachRepetitionHasItsFiveEventsInOrder) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 120, .repetitions = 3});
  const std::vector<motion::StsEvent> events = gait::FindStsEvents(SignalsOf(leg)).events;
  ASSERT_EQ(events.size(), 15u);
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].repetition, static_cast<int>(i / 5) + 1);
    EXPECT_EQ(static_cast<std::size_t>(events[i].kind), i % 5);
    EXPECT_TRUE(i == 0 || events[i].time_s > events[i - 1].time_s) << i << " " << events[i].time_s;
  }
}

// Wherever the first rise is cut, it has no onset, the others keep their times, and none is taken for cut off at rest.
TEST(StsEvents, ARiseThatWasUnderWayAtTheBeginningHasNoOnset) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 3});
  const gait::StsSignals all = SignalsOf(leg);
  const std::vector<motion::StsEvent> events = gait::FindStsEvents(all).events;
  const auto index_of = [&](motion::StsEventKind kind) {  // of the first frame after it
    const double time_s = events.at(static_cast<std::size_t>(kind)).time_s;
    return static_cast<std::size_t>(std::lower_bound(all.time_s.begin(), all.time_s.end(), time_s) -
                                    all.time_s.begin());
  };
  EXPECT_FALSE(gait::FindStsEvents(all).begins_during_rise);
  const std::size_t onset = index_of(motion::StsEventKind::kOnset), seat_off = index_of(motion::StsEventKind::kSeatOff);
  const auto cut_at = [&](std::size_t begin) {
    gait::StsSignals cut = all;
    const auto drop = [&](auto& values) {
      values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(begin));
    };
    drop(cut.frame);
    for (const auto values : kColumns) drop(cut.*values);
    return gait::FindStsEvents(cut);
  };
  std::vector<double> standing = TimesOf(events, motion::StsEventKind::kStanding);
  // The seat is left after the trunk has leaned for a while: a rise whose lean was under way has no onset.
  for (std::size_t begin = onset; begin < seat_off; ++begin) {
    const gait::FoundStsEvents cut = cut_at(begin);
    EXPECT_TRUE(cut.begins_during_lean && !cut.begins_during_rise) << begin;
    EXPECT_EQ(TimesOf(cut.events, motion::StsEventKind::kOnset).size(), 2u) << begin;
    EXPECT_EQ(cut.events.front().kind, motion::StsEventKind::kSeatOff) << begin;
    EXPECT_EQ(TimesOf(cut.events, motion::StsEventKind::kStanding), standing) << begin;
  }
  standing.erase(standing.begin());
  for (std::size_t begin = seat_off; begin < seat_off + 6; ++begin) {
    const gait::FoundStsEvents cut = cut_at(begin);
    EXPECT_TRUE(cut.begins_during_rise && !cut.begins_during_lean) << begin;
    EXPECT_EQ(TimesOf(cut.events, motion::StsEventKind::kOnset).size(), 2u) << begin;
    EXPECT_EQ(TimesOf(cut.events, motion::StsEventKind::kStanding), standing) << begin;
  }
  // A quarter of a second of rest is enough.
  for (std::size_t begin = 0; begin + 17 < onset; ++begin) {
    EXPECT_FALSE(cut_at(begin).begins_during_lean) << begin;
    EXPECT_NEAR(TimesOf(cut_at(begin).events, motion::StsEventKind::kOnset).front(), events.front().time_s, 1.01 / 60)
        << begin;
  }
}

TEST(StsEvents, OnsetIsWhenTheTrunkLeavesRest) {
  for (const double rate_hz : {30.0, 60.0, 240.0}) {
    const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = rate_hz, .repetitions = 2});
    const std::vector<double> onsets =
        TimesOf(gait::FindStsEvents(SignalsOf(leg)).events, motion::StsEventKind::kOnset);
    ASSERT_EQ(onsets.size(), leg.onset_s.size());
    // The trunk turns by 35° in 0.9 s with minimum jerk: 30 τ² · 35°/0.9 s = 2°/s at τ = 0.042, 0.038 s after it
    // starts.
    for (std::size_t i = 0; i < onsets.size(); ++i)
      EXPECT_NEAR(onsets[i], leg.onset_s[i] + 0.038, 1.01 / rate_hz + 0.005);
  }
}

TEST(StsEvents, SeatOffAndStandingAreTheStatedFractionsOfTheirPeaks) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 500, .repetitions = 1});
  const gait::StsSignals signals = SignalsOf(leg);
  const std::vector<motion::StsEvent> events = gait::FindStsEvents(signals).events;
  ASSERT_GE(events.size(), 3u);
  double peak_up = 0, peak_extension = 0;
  for (std::size_t i = 0; i < signals.frame.size() / 2; ++i) {
    peak_up = std::max(peak_up, signals.hip_up_speed[i]);
    peak_extension = std::max(peak_extension, -signals.knee_deg_s[i]);
  }
  // The signals are those of the leg at 500 Hz: linear from frame to frame.
  const auto at = [&](const std::vector<double>& values, double time_s) {
    const auto i = static_cast<std::size_t>(time_s * 500);
    return values[i] + (time_s * 500 - static_cast<double>(i)) * (values[i + 1] - values[i]);
  };
  EXPECT_NEAR(at(signals.hip_up_speed, events[1].time_s), 0.1 * peak_up, 1e-6 * peak_up);
  EXPECT_NEAR(at(signals.knee_deg_s, events[2].time_s), -0.05 * peak_extension, 1e-6 * peak_extension);
  EXPECT_LT(signals.hip_up_speed[static_cast<std::size_t>(events[1].time_s * 500)], 0.1 * peak_up);
}

TEST(StsEvents, WithoutRestBetweenThemRepetitionsAreStillFound) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 100, .repetitions = 5, .rest_s = 0.02, .move_s = 0.8});
  const std::vector<motion::StsEvent> events = gait::FindStsEvents(SignalsOf(leg)).events;
  const std::vector<double> onsets = TimesOf(events, motion::StsEventKind::kOnset);
  EXPECT_EQ(TimesOf(events, motion::StsEventKind::kStanding).size(), 5u);
  // The recording begins with the first rise, which therefore has none.
  ASSERT_EQ(onsets.size(), 4u);
  // The trunk never rests here, so the SD that its speed must leave is large.
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(onsets[i], leg.onset_s[i + 1], 0.12);
}

// A squat keeps the hip over the feet; here it is half as far behind them as on the seat.
gait::StsSignals SquatsOf(const SyntheticLeg& leg) {
  gait::StsSignals signals = SignalsOf(leg);
  for (double& behind : signals.hip_behind) behind /= 2;
  return signals;
}

TEST(StsEvents, SquatsAreLeftOutAndCounted) {
  const SyntheticLegOptions quick{.rate_hz = 100, .repetitions = 4, .rest_s = 0.3, .starts_standing = true};
  const gait::FoundStsEvents found = gait::FindStsEvents(SquatsOf(MakeSyntheticLeg(quick)));
  EXPECT_TRUE(found.events.empty());
  EXPECT_EQ(found.without_seat.size(), 4);
}

// Whether it is known by where the hip is, by a long rest, or by a long rest at the same height.
TEST(StsEvents, ASeatIsOneHoweverShortlyItIsTouched) {
  const auto rises = [](const gait::StsSignals& signals) {
    const gait::FoundStsEvents found = gait::FindStsEvents(signals);
    EXPECT_TRUE(found.without_seat.empty());
    return TimesOf(found.events, motion::StsEventKind::kStanding).size();
  };
  const SyntheticLegOptions quick{.rate_hz = 100, .repetitions = 5, .rest_s = 0.02, .move_s = 0.8};
  const SyntheticLeg touched = MakeSyntheticLeg(quick);
  EXPECT_EQ(rises(SignalsOf(touched)), 5u);
  EXPECT_EQ(rises(SquatsOf(MakeSyntheticLeg({.rate_hz = 100, .repetitions = 2, .rest_s = 1.5}))), 2u);
  gait::StsSignals first_rests = SquatsOf(touched);
  constexpr int kRest = 150;  // frames, before the first of the quick ones
  for (auto* values : {&first_rests.hip_height, &first_rests.hip_behind, &first_rests.knee_deg, &first_rests.trunk_deg})
    values->insert(values->begin(), kRest, values->front());
  for (auto* values : {&first_rests.hip_up_speed, &first_rests.knee_deg_s, &first_rests.trunk_deg_s})
    values->insert(values->begin(), kRest, 0.0);
  for (int i = 0; i < kRest; ++i) {
    first_rests.frame.push_back(first_rests.frame.back() + 1);
    first_rests.time_s.push_back(first_rests.time_s.back() + 0.01);
  }
  EXPECT_EQ(rises(first_rests), 5u);
}

TEST(StsEvents, ARecordingThatBeginsStandingCountsItsRisesOnly) {
  const SyntheticLeg leg = MakeSyntheticLeg({.repetitions = 2, .starts_standing = true});
  const std::vector<motion::StsEvent> events = gait::FindStsEvents(SignalsOf(leg)).events;
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.front().kind, motion::StsEventKind::kOnset);
  EXPECT_EQ(TimesOf(events, motion::StsEventKind::kOnset).size(), 2u);
}

TEST(StsEvents, FidgetingOnTheSeatIsNotAnOnset) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 100, .repetitions = 1, .rest_s = 3});
  gait::StsSignals signals = SignalsOf(leg);
  for (std::size_t i = 40; i < signals.frame.size(); ++i) {  // the trunk leans forward a little 2 s before, and rests
    if (i < 90) signals.trunk_deg_s[i] += 15;
    signals.trunk_deg[i] += 0.15 * static_cast<double>(std::min<std::size_t>(i, 89) - 39);
  }
  const std::vector<double> onsets = TimesOf(gait::FindStsEvents(signals).events, motion::StsEventKind::kOnset);
  ASSERT_EQ(onsets.size(), 1u);
  EXPECT_NEAR(onsets[0], 3.04, 0.02);
}

// The hip is lifted and lowered again without the knee (a hoist, a marker that slips): no repetition, and its lowering
// is not that of the repetition before.
TEST(StsEvents, ARiseThatDoesNotCountAddsNothingToTheRepetitionBefore) {
  for (const bool before : {false, true}) {
    const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 100, .repetitions = 1});
    gait::StsSignals signals = SignalsOf(leg);
    const std::vector<motion::StsEvent> alone = gait::FindStsEvents(signals).events;
    ASSERT_EQ(alone.size(), 5u);
    gait::StsSignals lifted = signals;
    const double last_s = signals.time_s.back(),
                 seated = before ? signals.hip_height.front() : signals.hip_height.back();
    for (const auto values : kColumns) (lifted.*values).clear();
    lifted.frame.clear();
    for (int i = 0; i < 400; ++i) {
      const double phase = 2 * std::numbers::pi * i / 400;
      lifted.frame.push_back(i), lifted.time_s.push_back(i / 100.0);
      lifted.hip_height.push_back(seated + 150 * (1 - std::cos(phase)));
      lifted.hip_up_speed.push_back(150 * std::numbers::pi / 2 * std::sin(phase));
      lifted.knee_deg.push_back(signals.knee_deg.front()), lifted.knee_deg_s.push_back(0);
      lifted.trunk_deg.push_back(signals.trunk_deg.front()), lifted.trunk_deg_s.push_back(0);
      lifted.hip_behind.push_back(signals.hip_behind.front());
    }
    EXPECT_TRUE(gait::FindStsEvents(lifted).events.empty());
    gait::StsSignals joined = before ? lifted : signals;
    const gait::StsSignals& second = before ? signals : lifted;
    const double offset_s = before ? 4.01 : last_s + 0.01;
    for (std::size_t i = 0; i < second.frame.size(); ++i) {
      joined.frame.push_back(static_cast<std::int64_t>(joined.frame.size()));
      for (const auto values : kColumns)
        (joined.*values).push_back((second.*values)[i] + (values == &gait::StsSignals::time_s ? offset_s : 0));
    }
    const std::vector<motion::StsEvent> events = gait::FindStsEvents(joined).events;
    ASSERT_EQ(events.size(), 5u) << before;
    for (std::size_t i = 0; i < events.size(); ++i) {
      EXPECT_EQ(events[i].kind, alone[i].kind);
      EXPECT_EQ(events[i].repetition, 1);
    }
  }
}

TEST(StsEvents, WalkingHasNone) {
  gait::StsSignals signals;
  signals.leg_length = 840;
  for (int i = 0; i < 600; ++i) {
    const double t = i / 100.0, phase = 2 * std::numbers::pi * t;
    signals.frame.push_back(i), signals.time_s.push_back(t);
    signals.hip_height.push_back(900 + 25 * std::sin(2 * phase)),
        signals.hip_up_speed.push_back(314 * std::cos(2 * phase));
    signals.hip_behind.push_back(0);
    signals.knee_deg.push_back(32 + 32 * std::sin(phase)), signals.knee_deg_s.push_back(200 * std::cos(phase));
    signals.trunk_deg.push_back(0.8 * std::sin(2 * phase)), signals.trunk_deg_s.push_back(10 * std::cos(2 * phase));
  }
  EXPECT_TRUE(gait::FindStsEvents(signals).events.empty());
}

TEST(StsEvents, GapsAndAMissingTrunkDoNotHideARise) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 1});
  gait::StsSignals signals = SignalsOf(leg);
  for (std::size_t i = 20; i < 40; ++i) signals.hip_height[i] = std::nan("");
  for (auto* values : {&signals.trunk_deg, &signals.trunk_deg_s}) values->assign(signals.frame.size(), std::nan(""));
  const std::vector<motion::StsEvent> events = gait::FindStsEvents(signals).events;
  ASSERT_EQ(events.size(), 5u);
  // Without a trunk the hip must rise by 2 mm, which it does before it has 10 % of its peak speed.
  EXPECT_LE(events[0].time_s, events[1].time_s);
  EXPECT_GT(events[0].time_s, leg.onset_s[0] + 0.25);
}

TEST(StsEvents, EmptyAndStillRecordingsHaveNone) {
  EXPECT_TRUE(gait::FindStsEvents({}).events.empty());
  SyntheticLeg leg = MakeSyntheticLeg({.repetitions = 1});
  gait::StsSignals signals = SignalsOf(leg);
  std::fill(signals.hip_height.begin(), signals.hip_height.end(), 500.0);
  EXPECT_TRUE(gait::FindStsEvents(signals).events.empty());
}

TEST(StsEvents, PercentRunsFromOnsetToStanding) {
  motion::LegMotion motion;
  for (int i = 0; i < 100; ++i) {
    motion.frame.push_back(i), motion.time_s.push_back(0.1 * i);
    motion.samples.emplace_back();
    motion.samples.back().percent = 7;  // to be cleared
  }
  gait::SetRepetitions({{1, motion::StsEventKind::kOnset, 20, 2.0},
                        {1, motion::StsEventKind::kStanding, 40, 4.0},
                        {2, motion::StsEventKind::kOnset, 90, 9.0}},
                       motion);
  EXPECT_TRUE(std::isnan(motion.samples[19].percent));
  EXPECT_NEAR(motion.samples[20].percent, 0, 1e-9);
  EXPECT_NEAR(motion.samples[30].percent, 50, 1e-9);
  EXPECT_NEAR(motion.samples[40].percent, 100, 1e-9);
  EXPECT_EQ(motion.samples[30].repetition, 1);
  EXPECT_FALSE(motion.samples[41].repetition || motion.samples[95].repetition);  // the second was cut off
}

// Of two rises of 2 s the second's onset is known to 0.3 s: that alone is told.
TEST(StsEvents, AnEventThatCannotBeToldToATenthOfTheRiseIsWarnedOf) {
  using Kind = motion::StsEventKind;
  const auto event = [](int rise, Kind kind, double time_s, double sd_s) {
    return motion::StsEvent{.repetition = rise, .kind = kind, .frame = 0, .time_s = time_s, .sd_s = sd_s};
  };
  const std::vector<motion::StsEvent> events = {event(1, Kind::kOnset, 1, 0.02),   event(1, Kind::kSeatOff, 1.8, 0.5),
                                                event(1, Kind::kStanding, 3, 0.1), event(2, Kind::kOnset, 5, 0.3),
                                                event(2, Kind::kStanding, 7, NAN), event(3, Kind::kOnset, 9, 0.9)};
  EXPECT_THAT(gait::UncertainEvents(events),
              testing::ElementsAre(testing::HasSubstr("rise 2: its onset is uncertain by 0.30 s")));
  gait::LegFitResult fit;
  fit.events = {events[0], events[2], events[3], events[4]};
  for (int frame = 0; frame <= 100; ++frame)
    fit.motion.frame.push_back(frame), fit.motion.time_s.push_back(frame / 10.0), fit.motion.samples.emplace_back();
  gait::CorrectEvents({{.repetition = 2, .kind = Kind::kOnset, .frame = {}, .time_s = 5.2}}, fit);
  EXPECT_THAT(gait::UncertainEvents(fit.events), testing::IsEmpty()) << "a person gave it";
}

}  // namespace
}  // namespace lake
