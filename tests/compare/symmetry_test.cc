// Both legs of one person, whose difference is known.
#include "lake/compare/symmetry.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <random>

#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/gait/sit_to_stand.h"

namespace lake {
namespace {

constexpr double kHz = 100, kRise_s = 1.5, kEvery_s = 4;
constexpr int kRises = 5;

// A leg as the fit leaves it: rises of 1.5 s from 90 degrees, each a little unlike the others, the knee bent by `more`
// degrees in the seat.
gait::LegFitResult Leg(double more_deg, unsigned seed, double between_rises_deg = 1.5) {
  gait::LegFitResult fit;
  fit.motion.unit = motion::LengthUnit::kMm;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> own_deg, own_s;
  for (int r = 0; r < kRises; ++r) {
    own_deg.push_back(between_rises_deg * normal(random));
    own_s.push_back(0.03 * normal(random));
    const double onset_s = 1 + kEvery_s * r;
    const auto add = [&](motion::StsEventKind kind, double at_s) {
      fit.events.push_back({r + 1, kind, static_cast<std::int64_t>(at_s * kHz), at_s, 0.005});
    };
    add(motion::StsEventKind::kOnset, onset_s);
    add(motion::StsEventKind::kSeatOff, onset_s + 0.4 + own_s.back());
    add(motion::StsEventKind::kStanding, onset_s + kRise_s);
  }
  gait::StsSignals& s = fit.signals;
  for (int i = 0; i < static_cast<int>(kHz * (1 + kEvery_s * kRises)); ++i) {
    const double t = i / kHz;
    const int r = std::min(kRises - 1, std::max(0, static_cast<int>((t - 1) / kEvery_s)));
    const auto rise = static_cast<std::size_t>(r);
    const double part = std::clamp((t - 1 - kEvery_s * r) / kRise_s, 0.0, 1.0);
    const double done = part * part * (3 - 2 * part),
                 speed = part > 0 && part < 1 ? 6 * part * (1 - part) / kRise_s : 0;
    const double seat_deg = 90 + more_deg + own_deg[rise];
    motion::LegSample sample;
    sample.ak = {100, 430};
    sample.kh = {-420 * (1 - done), 420 * done + 1};
    sample.hw = {50, 440};
    sample.knee_deg = seat_deg * (1 - done);
    sample.knee_sigma_deg = 0.1;
    sample.shank_deg = 12 * std::sin(kPi * part);
    sample.thigh_deg = sample.shank_deg - sample.knee_deg;
    sample.trunk_deg = 30 * std::sin(kPi * part);
    if (part > 0 && part < 1) sample.repetition = r + 1, sample.percent = 100 * part;
    fit.motion.frame.push_back(i);
    fit.motion.time_s.push_back(t);
    fit.motion.samples.push_back(sample);
    s.hip_height.push_back(430 + 400 * done);
    s.hip_up_speed.push_back(400 * speed + normal(random));
    s.knee_deg_s.push_back(-seat_deg * speed);
    s.trunk_deg_s.push_back(30 * kPi * std::cos(kPi * part) / kRise_s);
    s.shank_deg.push_back(sample.shank_deg);
    s.shank_deg_s.push_back(part > 0 && part < 1 ? 12 * kPi * std::cos(kPi * part) / kRise_s : 0);
    s.hip_deg_s.push_back(s.trunk_deg_s.back() - s.shank_deg_s.back() + s.knee_deg_s.back());
    for (auto* sd : {&s.sd.hip_deg_s, &s.sd.hip_height, &s.sd.hip_up_speed, &s.sd.knee_deg, &s.sd.knee_deg_s,
                     &s.sd.trunk_deg, &s.sd.trunk_deg_s, &s.sd.shank_deg, &s.sd.shank_deg_s, &s.sd.hip_deg})
      sd->push_back(0.1);
  }
  s.time_s = fit.motion.time_s;
  s.frame = fit.motion.frame;
  return fit;
}

const compare::SideDifference& Of(const compare::Symmetry& symmetry, const std::string& name) {
  for (const compare::SideDifference& difference : symmetry.quantities)
    if (difference.name == name) return difference;
  throw Fail("no quantity {}", name);
}

TEST(Symmetry, TellsAsymmetricRisesFromSymmetricOnes) {
  int false_alarms = 0;
  constexpr int kPeople = 40;
  for (unsigned seed = 0; seed < kPeople; ++seed)
    for (const bool one_recording : {true, false}) {
      // 3 mm of placement are 1.3 degrees of a knee's difference, 3.6 with ten intervals together; five rises add
      // some 5.
      const compare::SymmetryOptions options{.one_recording = one_recording};
      const compare::Symmetry alike = compare::CompareSides(Leg(0, seed), Leg(0, seed + 1000), options),
                              unlike = compare::CompareSides(Leg(20, seed), Leg(0, seed + 1000), options);
      EXPECT_TRUE(unlike.is_asymmetric) << seed;
      const compare::SideDifference& knee = Of(unlike, "knee_max_deg");
      EXPECT_TRUE(knee.IsAsymmetric()) << seed;
      EXPECT_LT(knee.interval.low, 20);
      EXPECT_GT(knee.interval.high, 20);
      EXPECT_NEAR(knee.index_percent, 100 * 20 / 100.0, 5);
      false_alarms += alike.is_asymmetric ? 1 : 0;
    }
  EXPECT_LE(false_alarms, 0.1 * 2 * kPeople) << "5 % are said to be so by chance";
}

TEST(Symmetry, FollowsTheKneeOverTheRise) {
  const compare::Symmetry symmetry = compare::CompareSides(Leg(10, 1, 0.1), Leg(0, 2, 0.1), {.one_recording = true});
  ASSERT_EQ(symmetry.knee_deg.size(), 101u);
  EXPECT_NEAR(symmetry.knee_deg[50].difference, 5, 0.3);
  EXPECT_NEAR(symmetry.knee_deg[50].left, 50, 0.5);
  EXPECT_EQ(symmetry.left_count, 5u);
}

// Forces of five rises beside the ten quantities of the motion: at 1 − 0.05 / 11 / 2 Student's t of four degrees of
// freedom is 5.747, and that of the plates' 1 % 2.838.
TEST(Symmetry, TakesForcesUnderTheFeet) {
  compare::FurtherQuantity force;
  force.name = "force_n";
  force.relative_sd = 0.01;
  const double more_n[] = {28, 29, 30, 31, 32};  // their mean's SD is √(2.5 / 5)
  for (int r = 1; r <= 5; ++r) force.left[r].value = 300 + more_n[r - 1], force.right[r].value = 300;
  compare::SymmetryOptions options;
  options.one_recording = true;
  options.further = {force};
  const compare::Symmetry symmetry = compare::CompareSides(Leg(0, 1), Leg(0, 2), options);
  const compare::SideDifference& of = Of(symmetry, "force_n");
  EXPECT_NEAR(of.difference, 30, 1e-9);
  const double reach = std::hypot(5.747 * std::sqrt(0.5), 2.838 * 0.01 * std::hypot(330, 300));
  EXPECT_NEAR(of.interval.high - of.difference, reach, 0.01);
  EXPECT_TRUE(of.IsAsymmetric());
}

// The right leg's second rise was not found, so that its third is numbered second.
TEST(Symmetry, MatchesRisesOfOneRecordingByTheirTimes) {
  const gait::LegFitResult left = Leg(10, 1);
  gait::LegFitResult right = Leg(0, 2);
  std::erase_if(right.events, [](const motion::StsEvent& event) { return event.repetition == 2; });
  for (motion::StsEvent& event : right.events)
    if (event.repetition > 2) --event.repetition;
  for (motion::LegSample& sample : right.motion.samples)
    if (sample.repetition == 2)
      sample.repetition.reset();
    else if (sample.repetition > 2)
      --*sample.repetition;
  const compare::MatchedRepetitions matched = compare::MatchRepetitions(left, right);
  EXPECT_EQ(matched.left_by_right, (std::map<int, int>{{1, 1}, {2, 3}, {3, 4}, {4, 5}}));
  EXPECT_THAT(matched.warnings, testing::ElementsAre("rise 2 of the left leg, 5.00 to 6.50 s, has no counterpart among "
                                                     "the right leg's: it is left out"));
  const compare::Symmetry symmetry = compare::CompareSides(left, right, {.one_recording = true});
  EXPECT_EQ(symmetry.left_count, 5u);
  EXPECT_EQ(symmetry.right_count, 4u);
  EXPECT_EQ(symmetry.warnings, matched.warnings);
  // The means are of the same four rises.
  double left_deg = 0;
  for (const gait::SitToStand& rise : gait::MeasureSitToStands(left))
    if (rise.repetition != 0 && rise.repetition != 2) left_deg += rise.knee_max_deg.value / 4;
  EXPECT_NEAR(Of(symmetry, "knee_max_deg").left, left_deg, 1e-9);
  for (motion::StsEvent& event : right.events) event.time_s += 2;  // between those of the left leg
  EXPECT_THAT(compare::MatchRepetitions(left, right).left_by_right, testing::IsEmpty());
  EXPECT_THROW(compare::CompareSides(left, right, {.one_recording = true}), Error);
}

// A walk of eight strides of 1.1 s, each a little unlike the others.
gait::LegFitResult Walk(double first_strike_s, double stance_s, double knee_swing_deg, unsigned seed) {
  constexpr double kStride_s = 1.1;
  constexpr int kStrides = 8;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  gait::LegFitResult fit;
  fit.motion.unit = motion::LengthUnit::kMm;
  fit.movement.kind = gait::MovementKind::kWalking;
  std::vector<double> strike_s, off_s;
  const auto add = [&](int stride, motion::StsEventKind kind, double at_s) {
    fit.events.push_back({stride, kind, static_cast<std::int64_t>(at_s * kHz), at_s, 0.004});
  };
  for (int n = 0; n <= kStrides; ++n) {
    strike_s.push_back(first_strike_s + kStride_s * n + 0.008 * normal(random));
    off_s.push_back(strike_s.back() + stance_s + 0.008 * normal(random));
    add(n + 1, motion::StsEventKind::kHeelStrike, strike_s.back());
    add(n + 1, motion::StsEventKind::kToeOff, off_s.back());
  }
  for (int i = 0; i < static_cast<int>(kHz * (first_strike_s + kStride_s * (kStrides + 1))); ++i) {
    motion::LegSample sample;
    const double t = i / kHz;
    sample.ak = {50, 430};
    sample.kh = {-20, 420};
    sample.hw = {10, 440};
    sample.knee_sigma_deg = 0.2;
    for (int n = 0; n < kStrides; ++n) {
      const auto k = static_cast<std::size_t>(n);
      if (t < strike_s[k] || t >= strike_s[k + 1]) continue;
      sample.repetition = n + 1;
      sample.percent = 100 * (t - strike_s[k]) / (strike_s[k + 1] - strike_s[k]);
      sample.knee_deg = 2 + (knee_swing_deg - 2) * std::exp(-std::pow((sample.percent - 75) / 8, 2));
    }
    fit.motion.frame.push_back(i);
    fit.motion.time_s.push_back(t);
    fit.motion.samples.push_back(sample);
  }
  return fit;
}

TEST(Symmetry, OfAWalkComparesStridesAndSteps) {
  const gait::LegFitResult left = Walk(0.5, 0.70, 62, 1), right = Walk(0.5 + 0.59, 0.64, 60, 2);
  const compare::Symmetry symmetry = compare::CompareSides(left, right, {.one_recording = true});
  EXPECT_EQ(symmetry.movement, gait::MovementKind::kWalking);
  EXPECT_EQ(symmetry.left_count, 8u);
  EXPECT_THAT(symmetry.warnings, testing::IsEmpty());  // each stride has its own, though it overlaps two alike
  const compare::SideDifference& stance = Of(symmetry, "stance_s");
  EXPECT_NEAR(stance.difference, 0.06, 0.01);
  EXPECT_TRUE(stance.IsAsymmetric());
  // From the left heel's strike to the right one's 0.59 s, from there to the next left one's 0.51 s.
  const compare::SideDifference& step = Of(symmetry, "step_s");
  EXPECT_NEAR(step.left, 0.51, 0.008);
  EXPECT_NEAR(step.right, 0.59, 0.008);
  EXPECT_TRUE(step.IsAsymmetric());
  // 2 degrees are less than where the markers sit: 3 mm on each of six.
  EXPECT_FALSE(Of(symmetry, "knee_swing_deg").IsAsymmetric());
  // An index of what is about zero says nothing.
  EXPECT_TRUE(std::isnan(Of(symmetry, "knee_heel_strike_deg").index_percent));
  EXPECT_NEAR(symmetry.knee_deg[75].difference, 2, 0.1);
  gait::LegFitResult rises = Leg(0, 1);
  EXPECT_THROW(compare::CompareSides(left, rises, {}), Error);
}

TEST(Symmetry, OfAnEvenWalkIsSeldomDoubted) {
  int false_alarms = 0;
  constexpr int kPeople = 40;
  for (unsigned seed = 0; seed < kPeople; ++seed)
    for (const bool one_recording : {true, false})
      false_alarms += compare::CompareSides(Walk(0.5, 0.67, 60, seed), Walk(0.5 + 0.55, 0.67, 60, seed + 1000),
                                            {.one_recording = one_recording})
                          .is_asymmetric;
  EXPECT_LE(false_alarms, 0.1 * 2 * kPeople) << "5 % are said to be so by chance";
}

TEST(Symmetry, OfOneRiseHasNoInterval) {
  gait::LegFitResult left = Leg(12, 1), right = Leg(0, 2);
  for (gait::LegFitResult* leg : {&left, &right})
    std::erase_if(leg->events, [](const motion::StsEvent& event) { return event.repetition > 1; });
  const compare::Symmetry symmetry = compare::CompareSides(left, right, {});
  EXPECT_EQ(symmetry.left_count, 1u);
  EXPECT_NEAR(Of(symmetry, "knee_max_deg").difference, 12, 5);
  EXPECT_TRUE(std::isnan(Of(symmetry, "knee_max_deg").interval.low));
  EXPECT_FALSE(symmetry.is_asymmetric);
  EXPECT_THAT(symmetry.warnings, testing::ElementsAre(testing::HasSubstr("of a single rise")));
  right.events.clear();
  EXPECT_THROW(compare::CompareSides(left, right, {}), Error);
}

}  // namespace
}  // namespace lake
