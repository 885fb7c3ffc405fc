// From marker tracks to figures: synthetic sit-to-stands through the leg fit, registered and compared with their truth.
#include <gmock/gmock.h>

#include "closed_form.h"
#include "lake/compare/misalignment.h"
#include "lake/core/error.h"
#include "lake/gait/leg_fit.h"
#include "lake/synth/sts_motion.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

struct Recorded {
  double rate_hz = 60, sigma_mm = 0.1, end_s = INFINITY;
  unsigned seed = 1;
  double slower = 1;  // by this factor than the motion
};

// Positions in the plane at a frame rate, with noise.
motion::MarkerRecording Record(const synth::MarkerMotion& motion, const Recorded& r) {
  motion::MarkerRecording recording;
  recording.unit = motion::LengthUnit::kMm;
  std::mt19937 random(r.seed);
  std::normal_distribution<double> normal(0, r.sigma_mm);
  for (const std::string& name : motion.Names()) recording.markers.push_back({name, {}});
  for (int i = 0; i / r.rate_hz < std::min(r.slower * motion.DurationS(), r.end_s); ++i) {
    recording.frame.push_back(i);
    recording.time_s.push_back(i / r.rate_hz);
    const std::vector<Eigen::Vector2d> at = motion.At(i / r.rate_hz / r.slower);
    for (std::size_t m = 0; m < at.size(); ++m) {
      const double x = normal(random), y = normal(random);
      recording.markers[m].samples.push_back(
          {at[m] + Eigen::Vector2d(x, y), std::max(r.sigma_mm, 1e-3), motion::SampleStatus::kDetected});
    }
  }
  return recording;
}

compare::TrialTables Fit(const synth::MarkerMotion& motion, const Recorded& r, const char* name = "trial") {
  const motion::MarkerRecording recording = Record(motion, r);
  const gait::LegFitResult fit = gait::FitLeg(recording, gait::MakeLegView(recording.unit, std::nullopt));
  return {name, fit.trajectory, fit.motion, fit.events};
}

compare::RegisteredTrial Register(const compare::TrialTables& tables, const char* knee = "knee") {
  compare::RegistrationOptions options;
  options.knee = knee;
  return compare::RegisterTrial(tables, options);
}

// A motion's markers, its subject turned to face along x.
class Faced {
 public:
  explicit Faced(const synth::StsMotion& motion) : motion_(motion) {}

  Eigen::Vector2d Point(const char* name, double time_s) const {
    const double side = motion_.FacingInImage() == motion::Facing::kRight ? 1 : -1;
    const Eigen::Vector2d p = motion_.At(time_s)[static_cast<std::size_t>(synth::IndexOfMarker(motion_, name))];
    return {side * p.x(), p.y()};
  }
  double KneeDeg(double time_s) const { return Lean("ankle", "knee", time_s) - Lean("knee", "hip", time_s); }
  double TrunkDeg(double time_s) const { return Lean("hip", "waist", time_s); }

 private:
  double Lean(const char* lower, const char* upper, double time_s) const {
    const Eigen::Vector2d v = Point(upper, time_s) - Point(lower, time_s);
    return DegreesFromRadians(std::atan2(v.x(), v.y()));
  }

  const synth::StsMotion& motion_;
};

struct TrueRise {
  double onset_s, standing_s;
};

// The definitions of sts_events.h on 2000 exact samples per second.
TrueRise FindTrueRise(const synth::StsMotion& motion) {
  constexpr double kStep = 1 / 2000.0;
  const Faced faced(motion);
  const synth::StsPhase& rise =
      *std::find_if(motion.Phases().begin(), motion.Phases().end(),
                    [](const synth::StsPhase& p) { return p.kind == synth::StsPhase::Kind::kRise; });
  const auto speed = [](const auto& f, double t) { return (f(t + kStep) - f(t - kStep)) / (2 * kStep); };
  const auto trunk_deg = [&](double t) { return faced.TrunkDeg(t); };
  const auto knee_deg = [&](double t) { return faced.KneeDeg(t); };
  const auto height = [&](double t) { return faced.Point("hip", t).y(); };
  const double rest_mm = height(rise.start_s - 0.1), rise_mm = height(rise.end_s) - rest_mm;
  double lean_deg_s = 0, peak_deg_s = 0;
  for (double t = rise.start_s; t < rise.end_s; t += kStep) {
    lean_deg_s = std::max(lean_deg_s, speed(trunk_deg, t));
    peak_deg_s = std::min(peak_deg_s, speed(knee_deg, t));
  }
  TrueRise found{rise.start_s, rise.end_s};
  while (speed(trunk_deg, found.onset_s) < 0.03 * lean_deg_s &&
         std::abs(height(found.onset_s) - rest_mm) < 0.005 * rise_mm)
    found.onset_s += kStep;
  while (speed(knee_deg, found.standing_s) > 0.05 * peak_deg_s) found.standing_s -= kStep;
  return found;
}

compare::StsCurve CurveOver(const TrueRise& rise, const synth::StsMotion& motion, const char* knee) {
  const Faced faced(motion);
  compare::StsCurve curve;
  curve.duration_s = rise.standing_s - rise.onset_s;
  for (int i = 0; i < compare::kPercentSamples; ++i) {
    const double t = rise.onset_s + curve.duration_s * i / 100;
    curve.ankle.push_back(faced.Point("ankle", t));
    curve.knee.push_back(faced.Point(knee, t));
    curve.hip.push_back(faced.Point("hip", t));
    curve.knee_deg.push_back(faced.KneeDeg(t));
    curve.knee_sigma_mm.push_back(0);
  }
  return curve;
}

// The motion's own curves between its true events.
compare::StsCurve TrueCurve(const synth::StsMotion& motion, const char* knee = "knee") {
  return CurveOver(FindTrueRise(motion), motion, knee);
}

synth::StsMotionOptions Still() {
  synth::StsMotionOptions options;
  options.variation = 0;
  options.ankle_sway_mm = 0;
  options.body_sway_deg = 0;
  options.min_rest_s = 1;
  return options;
}

double Rms(const compare::StsCurve& a, const compare::StsCurve& b) {
  return compare::ComputeMetrics(a, b, std::vector<bool>(compare::kPercentSamples, true)).rms_mm;
}

TEST(Trials, FiguresAgreeWithTheTruth) {
  const struct {
    double human_hz, exo_hz, pace;
    int human_repetitions, exo_repetitions;
    motion::Facing exo_facing;
  } cases[] = {{60, 60, 1, 2, 2, motion::Facing::kRight},
               {60, 30, 1.6, 1, 3, motion::Facing::kLeft},
               {100, 50, 0.8, 3, 1, motion::Facing::kLeft}};
  unsigned seed = 1;
  for (const auto& c : cases) {
    synth::StsMotionOptions human_options = Still(), exo_options = Still();
    human_options.repetitions = c.human_repetitions;
    exo_options.repetitions = c.exo_repetitions;
    exo_options.facing = c.exo_facing;
    exo_options.pace = c.pace;
    exo_options.seed = 7;
    exo_options.exo_knee_mm = Eigen::Vector2d(9, -6);
    const synth::StsMotion human(human_options), exo(exo_options);
    const auto human_leg = Fit(human, {c.human_hz, 0.1, INFINITY, seed++});
    const auto exo_leg = Fit(exo, {c.exo_hz, 0.1, INFINITY, seed++});
    const compare::Misalignment m = compare::CompareTrials(Register(human_leg), Register(exo_leg, "exo_knee"));
    EXPECT_EQ(m.human_repetitions, c.human_repetitions);
    EXPECT_EQ(m.exo_repetitions, c.exo_repetitions);
    EXPECT_NEAR(m.metrics.rms_mm, Rms(TrueCurve(human), TrueCurve(exo, "exo_knee")), 0.3)
        << c.human_hz << " " << c.exo_hz;
    EXPECT_LT((m.decomposition.offset_mm - Eigen::Vector2d(9, -6)).norm(), 0.3)
        << m.decomposition.offset_mm.transpose();
    EXPECT_GE(m.decomposition.placement, 0.95);
  }
}

TEST(Trials, TimeWarpIsFound) {
  for (const double hz : {60.0, 30.0}) {
    synth::StsMotionOptions warped = Still();
    warped.time_warp = 0.05;
    warped.seed = 3;
    const synth::StsMotion human(Still()), exo(warped);
    const compare::Misalignment m = compare::CompareTrials(Register(Fit(human, {60, 0.1, INFINITY, 11})),
                                                           Register(Fit(exo, {hz, 0.1, INFINITY, 12})));
    const compare::StsCurve true_human = TrueCurve(human), true_exo = TrueCurve(exo);
    EXPECT_NEAR(m.metrics.rms_mm, Rms(true_human, true_exo), 0.3) << hz;
    EXPECT_GE(m.decomposition.timing, 0.95) << hz;
    const compare::Decomposition truth = compare::Decompose(true_human, true_exo);
    for (std::size_t i = 20; i <= 80; i += 10)
      EXPECT_NEAR(m.decomposition.timing_percent[i], truth.timing_percent[i], 0.5) << hz << " " << i;
  }
}

TEST(Trials, TheSameMotionTwiceShowsTheNoiseFloor) {
  int contained = 0;
  constexpr int kPairs = 10;
  for (unsigned pair = 0; pair < kPairs; ++pair) {
    synth::StsMotionOptions options = Still();
    std::mt19937 random(pair);
    std::normal_distribution<double> normal(0, 3);  // the knee's marker is put back as well as --replacement-sd says
    const double x = normal(random), y = normal(random);
    const synth::StsMotion human(options);
    options.exo_knee_mm = Eigen::Vector2d(x, y);
    const synth::StsMotion again(options);
    const compare::Misalignment m =
        compare::CompareTrials(Register(Fit(human, {60, 0.2, INFINITY, 100 + pair})),
                               Register(Fit(again, {60, 0.2, INFINITY, 200 + pair}), "exo_knee"));
    ASSERT_TRUE(m.intervals);
    contained += m.intervals->relative_rms.low <= m.noise_floor_relative &&
                 m.noise_floor_relative <= m.intervals->relative_rms.high;
    // Both components N(0, 3 mm) and little else: the floor is 3 sqrt(2) mm, known to 4 % from 300 draws.
    EXPECT_NEAR(m.noise_floor_mm, 3 * std::sqrt(2.0), 0.5);
  }
  EXPECT_GE(contained, kPairs - 1);  // 95 % of them
}

// The joint is 10 mm in front of the knee and everything else is equal; only the pace of the exoskeleton's trial is
// not.
TEST(Trials, PaceIsNoMisalignment) {
  synth::StsMotionOptions options = Still();
  options.repetitions = 1;
  const compare::RegisteredTrial human = Register(Fit(synth::StsMotion(options), {}));
  options.exo_knee_mm = Eigen::Vector2d(10, 0);
  const synth::StsMotion worn(options);
  for (const double slower : {0.7, 1.0, 2.0, 4.0, 8.0, 14.0}) {
    compare::RegistrationOptions at;
    at.knee = "exo_knee";
    const compare::Misalignment m = compare::CompareTrials(
        human, compare::RegisterTrial(Fit(worn, {.rate_hz = 30, .seed = 2, .slower = slower}), at));
    SCOPED_TRACE(testing::Message() << slower << " times slower, a rise of " << m.exo.duration_s << " s");
    ASSERT_TRUE(m.joint);
    EXPECT_NEAR(m.joint->rms_mm, 10, 0.1);  // noise of 0.1 mm on both
    EXPECT_NEAR(m.joint->mean_mm.x(), 10, 0.1);
    EXPECT_LT(m.joint->remainder_mm, 0.2);
    EXPECT_NEAR(m.metrics.rms_mm, 10, 0.5);
    EXPECT_LT(std::abs(m.decomposition.timing), 0.03);
  }
}

// Nor is sway of the joint's place. It hides where a slow rise begins, and so moves the path difference from that of
// the path as it was swayed, between the events that it would have without: the intervals say by how much.
TEST(Trials, WhatSwayHidesIsInTheIntervals) {
  synth::StsMotionOptions options = Still();
  options.repetitions = 1;
  options.min_rest_s = options.max_rest_s = 3;
  const synth::StsMotion own(options);
  const compare::RegisteredTrial human = Register(Fit(own, {}));
  const compare::StsCurve own_curve = TrueCurve(own);
  options.exo_knee_mm = Eigen::Vector2d(10, 0);
  for (const double rise_s : {2.0, 4.0, 8.0, 16.0, 35.0}) {
    options.pace = rise_s / own_curve.duration_s;
    options.body_sway_deg = options.ankle_sway_mm = 0;
    const TrueRise rise = FindTrueRise(synth::StsMotion(options));
    options.body_sway_deg = 0.3;
    options.ankle_sway_mm = 0.5;
    for (const unsigned seed : {1U, 2U, 3U}) {
      options.seed = seed;
      const synth::StsMotion worn(options);
      const double truth_mm = Rms(CurveOver(rise, worn, "exo_knee"), own_curve);
      const compare::Misalignment m =
          compare::CompareTrials(human, Register(Fit(worn, {.rate_hz = 30, .seed = seed}), "exo_knee"));
      SCOPED_TRACE(testing::Message() << "a rise of " << rise_s << " s, seed " << seed);
      ASSERT_TRUE(m.joint && m.intervals);
      EXPECT_NEAR(m.joint->rms_mm, 10, 0.1);  // noise of 0.1 mm on both
      // An onset that is 4 % of the rise too early or late is a warp that large.
      EXPECT_NEAR(m.metrics.rms_mm, truth_mm, rise_s <= 4 ? 0.5 : 3);
      EXPECT_LE(m.intervals->rms_mm.low, truth_mm);
      EXPECT_GE(m.intervals->rms_mm.high, truth_mm);
    }
  }
}

// A marker on the exoskeleton's shank, so that the axis of its joint does not cover the knee's marker.
TEST(Trials, AMarkerBesideTheJointTellsOfTheJoint) {
  const Eigen::Vector2d joint_mm(10, -7), marker_at_mm(4, -60);
  synth::StsMotionOptions options = Still();
  options.repetitions = 1;
  const compare::RegisteredTrial human = Register(Fit(synth::StsMotion(options), {}));
  options.exo_knee_mm = joint_mm + marker_at_mm;
  for (const motion::Facing facing : {motion::Facing::kRight, motion::Facing::kLeft}) {
    options.facing = facing;
    compare::RegistrationOptions at;
    at.knee = "exo_knee";
    at.marker_at_mm = marker_at_mm;
    const compare::TrialTables worn = Fit(synth::StsMotion(options), {.rate_hz = 30, .seed = 2});
    const compare::Misalignment m = compare::CompareTrials(human, compare::RegisterTrial(worn, at));
    ASSERT_TRUE(m.joint);
    EXPECT_LT((m.joint->mean_mm - joint_mm).norm(), 0.1) << m.joint->mean_mm.transpose();  // noise of 0.1 mm
    EXPECT_LT(m.joint->remainder_mm, 0.2);
    EXPECT_NEAR(m.metrics.rms_mm, joint_mm.norm(), 0.5);
  }
}

TEST(Trials, EventsKeepWhatTheFitSaysOfTheirTimes) {
  compare::TrialTables tables = Fit(synth::StsMotion(Still()), {});
  for (motion::StsEvent& event : tables.events)
    event.sd_s = event.kind == motion::StsEventKind::kOnset ? 0.03 : event.repetition == 1 ? 0.01 : NAN;
  const compare::RegisteredTrial trial = Register(tables);
  EXPECT_EQ(trial.repetitions[0].onset_sd_s, 0.03);
  EXPECT_EQ(trial.repetitions[0].standing_sd_s, 0.01);
  EXPECT_EQ(trial.repetitions[1].standing_sd_s, 0);  // not known
}

TEST(Trials, BadInputIsRefusedInOneLine) {
  const synth::StsMotion motion(Still());
  const compare::TrialTables good = Fit(motion, {});
  EXPECT_THAT([&] { Register(good, "exo_knee"); },
              ThrowsMessage<Error>(HasSubstr("no marker 'exo_knee'; it has: ankle, knee, hip, waist")));
  compare::TrialTables px = good;
  px.trajectory.unit = motion::LengthUnit::kPx;
  EXPECT_THAT([&] { Register(px); }, ThrowsMessage<Error>(HasSubstr("lengths are in px")));
  compare::TrialTables none = good;
  none.events.clear();
  EXPECT_THAT([&] { Register(none); }, ThrowsMessage<Error>(HasSubstr("no sit-to-stand found")));
  const synth::StsPhase& rise = motion.Phases()[1];
  const compare::TrialTables cut = Fit(motion, {60, 0.1, rise.start_s + 0.75 * (rise.end_s - rise.start_s)}, "short");
  EXPECT_THAT([&] { Register(cut); }, ThrowsMessage<Error>(HasSubstr("short: ")));
  compare::TrialTables mixed = good;
  mixed.motion.time_s.pop_back();
  EXPECT_THAT([&] { Register(mixed); }, ThrowsMessage<Error>(HasSubstr("track it again")));
  compare::MisalignmentOptions options;
  options.replacement_sd_mm = -1;
  EXPECT_THROW(compare::CompareTrials(Register(good), Register(good), options), UsageError);
}

TEST(Trials, LongGapsLeaveARepetitionOut) {
  const synth::StsMotion motion(Still());
  compare::TrialTables tables = Fit(motion, {});
  const double middle_s = 0.5 * (motion.Phases()[1].start_s + motion.Phases()[1].end_s);
  for (motion::MarkerTrack& marker : tables.trajectory.markers)
    for (std::size_t i = 0; i < marker.samples.size(); ++i)
      if (marker.name == "knee" && std::abs(tables.trajectory.time_s[i] - middle_s) < 0.2) marker.samples[i] = {};
  const compare::RegisteredTrial registered = Register(tables);
  EXPECT_EQ(registered.repetitions.size(), 1U);
  EXPECT_THAT(registered.warnings,
              testing::ElementsAre(HasSubstr("repetition 1 is left out: marker 'knee' is missing for 0.42 s of it")));

  for (motion::MarkerTrack& marker : tables.trajectory.markers)
    for (std::size_t i = 0; i < marker.samples.size(); ++i)
      if (marker.name == "knee" && tables.trajectory.time_s[i] < middle_s) marker.samples[i] = {};
  EXPECT_THAT(Register(tables).warnings,
              testing::ElementsAre(HasSubstr("marker 'knee' is missing at the beginning or end of it")));
}

}  // namespace
}  // namespace lake
