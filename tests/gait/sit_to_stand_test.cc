#include "lake/gait/sit_to_stand.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/statistics.h"
#include "synthetic_leg.h"
#include "temporary_folder.h"
#include "true_rise_times.h"

namespace lake {
namespace {

using gait::Measured;
using gait::SitToStand;

gait::LegFitResult Fit(const SyntheticLeg& leg, const TrackNoise& noise, unsigned seed) {
  const gait::LegView view = ScaledView();
  return gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, view, noise, seed), view);
}

constexpr Measured SitToStand::*kTimes[] = {&SitToStand::onset_s, &SitToStand::seat_off_s, &SitToStand::standing_s,
                                            &SitToStand::descent_s};

// The true times are those of the same leg without noise: what an event is stands in sts_events_test.cc.
TEST(SitToStand, DeviationsOfTimesAreThoseOfTheirErrors) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 3});
  const std::vector<SitToStand> truth = gait::MeasureSitToStands(Fit(leg, {.sigma_px = 1e-3}, 1));
  std::map<std::size_t, std::vector<double>> normalized;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const std::vector<SitToStand> found = gait::MeasureSitToStands(Fit(leg, {.sigma_px = 0.3}, seed));
    ASSERT_EQ(found.size(), 4u);
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k < std::size(kTimes); ++k) {
        const Measured& measured = found[r].*kTimes[k];
        ASSERT_TRUE(std::isfinite(measured.sd)) << k;
        normalized[k].push_back((measured.value - (truth[r].*kTimes[k]).value) / measured.sd);
      }
  }
  // 36 errors each: their root mean square, if the SDs hold, is 1 ± 0.12.
  for (const auto& [k, errors] : normalized) {
    EXPECT_GT(RootMeanSquare(errors), 0.5) << k;
    EXPECT_LT(RootMeanSquare(errors), 1.4) << k;
  }
}

TEST(SitToStand, PhasesMakeUpTheRise) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 2});
  for (const SitToStand& rise : gait::MeasureSitToStands(Fit(leg, {}, 3))) {
    if (rise.repetition == 0) continue;
    EXPECT_NEAR(rise.flexion_s.value + rise.transfer_s.value + rise.extension_s.value, rise.rise_s.value, 1e-9);
    EXPECT_GE(rise.transfer_s.value, 0);
    EXPECT_GT(rise.flexion_s.value, 0);
    EXPECT_GT(rise.extension_s.value, 0);
  }
}

// One struct a rise.
std::vector<TrueRiseTimes> TrueTimesOf(SyntheticLegOptions options) {
  options.rate_hz = 4000;
  const SyntheticLeg leg = MakeSyntheticLeg(options);
  TrueRises rises(options.rate_hz);
  for (const gait::LegPoints& points : leg.points_mm) rises.Add(points, options.facing);
  std::vector<TrueRiseTimes> times;
  for (const double onset_s : leg.onset_s) {
    const double lowering_s = onset_s + options.move_s + options.rest_s;
    times.push_back(rises.Times(onset_s, lowering_s, lowering_s + options.move_s));
  }
  return times;
}

class SitToStandAtRate : public testing::TestWithParam<double> {};

// 0.05 px, 0.1 mm here, is what lake-track leaves on renderings; the truth is each time's definition, read from the
// closed form at 4 kHz.
TEST_P(SitToStandAtRate, TimesOfThePhasesAreWithinAFrame) {
  const double frame_s = 1 / GetParam();
  for (const double move_s : {1.2, 2.6}) {
    const SyntheticLegOptions options{.rate_hz = GetParam(), .repetitions = 2, .move_s = move_s};
    const std::vector<TrueRiseTimes> truth = TrueTimesOf(options);
    for (const unsigned seed : {1u, 2u}) {
      const std::vector<SitToStand> rises = gait::MeasureSitToStands(Fit(MakeSyntheticLeg(options), {0.05}, seed));
      ASSERT_EQ(rises.size(), truth.size() + 1);
      for (std::size_t r = 0; r < truth.size(); ++r) {
        SCOPED_TRACE(testing::Message() << "a move of " << move_s << " s, seed " << seed << ", rise " << r);
        const SitToStand& rise = rises[r];
        const TrueRiseTimes& is = truth[r];
        // 3 % of the trunk's peak speed is little: the SD is up to 11 ms, of a slow move at 30 Hz.
        const double onset_s = std::max(frame_s, 3 * rise.onset_s.sd);
        EXPECT_LT(rise.onset_s.sd, 0.012);
        EXPECT_NEAR(rise.onset_s.value, is.onset_s, onset_s);
        EXPECT_NEAR(rise.seat_off_s.value, is.seat_off_s, frame_s);
        EXPECT_NEAR(rise.standing_s.value, is.standing_s, frame_s);
        EXPECT_NEAR(rise.flexion_s.value, is.seat_off_s - is.onset_s, onset_s);
        EXPECT_NEAR(rise.transfer_s.value, is.leaned_s - is.seat_off_s, frame_s);
        EXPECT_NEAR(rise.extension_s.value, is.standing_s - is.leaned_s, frame_s);
        EXPECT_NEAR(rise.stabilisation_s.value, is.steady_s - is.standing_s, frame_s);
        EXPECT_NEAR(rise.rise_s.value, is.standing_s - is.onset_s, onset_s);
        EXPECT_NEAR(rise.descent_s.value, is.seated_s - is.descent_s, frame_s);
        for (const Measured& measured : {rise.flexion_s, rise.transfer_s, rise.extension_s, rise.stabilisation_s})
          EXPECT_GT(measured.sd, 0);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, SitToStandAtRate, testing::Values(30.0, 60.0, 120.0, 240.0),
                         [](const auto& info) { return fmt::format("{:.0f}Hz", info.param); });

// The hip rests on the seat while the trunk leans: who does not see the lean sees the onset too late.
TEST(SitToStand, AnOnsetThatNoLeanTellsIsWarnedOf) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 2, .rest_s = 3});
  motion::MarkerRecording recording = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {}, 1);
  const gait::LegFitResult whole = gait::FitLeg(recording, ScaledView());
  EXPECT_EQ(gait::OnsetsWithoutLean(whole.signals, whole.events), "");
  const double first_s = whole.events.front().time_s;
  std::erase_if(recording.markers, [](const motion::MarkerTrack& marker) { return marker.name == "waist"; });
  const gait::LegFitResult without = gait::FitLeg(recording, ScaledView());
  EXPECT_THAT(gait::OnsetsWithoutLean(without.signals, without.events),
              testing::StartsWith("rises 1, 2: no marker shows the trunk lean before them, so their onsets are "));
  std::vector<motion::StsEvent> given = without.events;
  for (motion::StsEvent& event : given)
    if (event.repetition == 1) event.sd_s = motion::LegSample::kUnknown;  // as a person's has none
  EXPECT_THAT(gait::OnsetsWithoutLean(without.signals, given), testing::StartsWith("rise 2: "));
  EXPECT_GT(without.events.front().time_s, first_s + 0.2);
}

// Whoever does not come to rest before sitting down, or before the recording ends, has no fourth phase.
TEST(SitToStand, WithoutRestNoStabilisationIsTold) {
  const SyntheticLegOptions quick{.rate_hz = 60, .repetitions = 2, .rest_s = 0.3};
  const std::vector<SitToStand> rises = gait::MeasureSitToStands(Fit(MakeSyntheticLeg(quick), {}, 3));
  ASSERT_EQ(rises.size(), 3u);  // the five-times test is the third row
  for (std::size_t r = 0; r < 2; ++r) {
    EXPECT_TRUE(std::isfinite(rises[r].standing_s.value));
    EXPECT_TRUE(std::isnan(rises[r].stabilisation_s.value));
  }
  SyntheticLeg cut = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 1});
  const SitToStand whole = gait::MeasureSitToStands(Fit(cut, {}, 3)).front();
  ASSERT_TRUE(std::isfinite(whole.stabilisation_s.value));
  const auto until = [&](double time_s) {
    const auto frames = static_cast<std::size_t>(time_s * 60);
    cut.time_s.resize(frames);
    cut.points_mm.resize(frames);
    cut.truth.resize(frames);
    return gait::MeasureSitToStands(Fit(cut, {}, 3)).front();
  };
  const double steady_s = whole.standing_s.value + whole.stabilisation_s.value;
  EXPECT_NEAR(until(steady_s + 0.7).stabilisation_s.value, whole.stabilisation_s.value, 0.03);
  const SitToStand ends = until(steady_s + 0.3);
  EXPECT_TRUE(std::isfinite(ends.standing_s.value));
  EXPECT_TRUE(std::isnan(ends.stabilisation_s.value));
}

TEST(SitToStand, AnglesAreThoseOfTheTruth) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 100, .repetitions = 1});
  const SitToStand rise = gait::MeasureSitToStands(Fit(leg, {}, 3)).front();
  const auto frame_at = [&](const Measured& time) {
    std::size_t i = 0;
    while (leg.time_s[i] < time.value) ++i;
    return i;
  };
  const motion::LegSample& truth = leg.truth[frame_at(rise.seat_off_s)];
  // The sample may be 10 ms late, at 60°/s of the joints there; 0.03 px are 0.01°.
  EXPECT_NEAR(rise.knee_seat_off_deg.value, truth.knee_deg, 0.7);
  EXPECT_NEAR(rise.trunk_seat_off_deg.value, truth.trunk_deg, 0.7);
  EXPECT_NEAR(rise.hip_seat_off_deg.value, truth.trunk_deg - truth.thigh_deg, 0.7);
  double most_trunk = -INFINITY;
  for (const motion::LegSample& sample : leg.truth) most_trunk = std::max(most_trunk, sample.trunk_deg);
  EXPECT_NEAR(rise.trunk_max_deg.value, most_trunk, 0.1);
  const double hip_rise_mm =
      leg.points_mm[frame_at(rise.standing_s)].hip->y() - leg.points_mm[frame_at(rise.onset_s)].hip->y();
  EXPECT_NEAR(rise.hip_rise.value, hip_rise_mm, 1);  // 10 ms late at 60 mm/s when standing
  EXPECT_NEAR(rise.hip_speed.value, rise.hip_rise.value / (rise.standing_s.value - rise.seat_off_s.value), 1e-9);
  EXPECT_GT(rise.hip_speed_max.value, rise.hip_speed.value);
  EXPECT_NEAR(rise.power_w_kg.value, 0.9 * 9.81 * rise.hip_rise.value / 1000 / rise.rise_s.value, 1e-9);
}

constexpr double kPelvis_mm = 150;  // from back to front

// Forward tilt of a pelvis that follows the trunk by 0.4 of its lean, from 12° when it is upright.
double TiltOf(const motion::LegSample& sample) {
  return 12 + 0.4 * sample.trunk_deg;
}

// A pelvis about the hip, its front 70 mm before and 60 mm above it where it is level.
motion::MarkerRecording WithPelvis(const SyntheticLeg& leg, const TrackNoise& noise, unsigned seed,
                                   motion::Facing facing = motion::Facing::kRight) {
  motion::MarkerRecording recording = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), noise, seed);
  std::vector<gait::LegPoints> pelvis = leg.points_mm;
  const double side = facing == motion::Facing::kRight ? 1 : -1;
  for (std::size_t i = 0; i < pelvis.size(); ++i) {
    const double tilt_rad = RadiansFromDegrees(TiltOf(leg.truth[i]));
    const auto at = [&](double forward_mm, double up_mm) {
      return Eigen::Vector2d(side * (forward_mm * std::cos(tilt_rad) + up_mm * std::sin(tilt_rad)),
                             up_mm * std::cos(tilt_rad) - forward_mm * std::sin(tilt_rad));
    };
    pelvis[i].ankle = *pelvis[i].hip + at(70, 60);
    pelvis[i].knee = *pelvis[i].hip + at(70 - kPelvis_mm, 60);
  }
  const motion::MarkerRecording seen = MakeTracks(leg.time_s, pelvis, ScaledView(), noise, seed + 1000);
  for (const auto& [from, name] : {std::pair("ankle", gait::kAsis), {"knee", gait::kPsis}})
    recording.markers.push_back({name, seen.Find(from)->samples});
  return recording;
}

TEST(TrunkOnPelvis, LeanIsTrunkLessPelvisInClosedForm) {
  for (const auto facing : {motion::Facing::kRight, motion::Facing::kLeft}) {
    const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 100, .repetitions = 1, .facing = facing});
    const gait::LegFitResult fit = gait::FitLeg(WithPelvis(leg, {}, 3, facing), ScaledView());
    EXPECT_EQ(gait::FindTrunkOnPelvis(fit).warning, "");
    const SitToStand rise = gait::MeasureSitToStands(fit).front();
    const auto lean_at = [&](double time_s) {
      const motion::LegSample& sample = leg.truth[static_cast<std::size_t>(std::lround(time_s * 100))];
      return sample.trunk_deg - TiltOf(sample);
    };
    // The sample may be 5 ms beside, at 0.6 of the trunk's 60°/s; 0.03 px are 0.06 mm of 150 mm: 0.03°.
    EXPECT_NEAR(rise.trunk_pelvis_seat_off_deg.value, lean_at(rise.seat_off_s.value), 0.3);
    double most = -INFINITY;
    for (const motion::LegSample& sample : leg.truth) most = std::max(most, sample.trunk_deg - TiltOf(sample));
    EXPECT_NEAR(rise.trunk_pelvis_max_deg.value, most, 0.15);
    EXPECT_GT(rise.trunk_pelvis_max_deg.sd, 0);
  }
}

TEST(TrunkOnPelvis, DeviationsAreThoseOfTheErrors) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 3});
  const auto measure = [&](double sigma_px, unsigned seed) {
    return gait::MeasureSitToStands(gait::FitLeg(WithPelvis(leg, {.sigma_px = sigma_px}, seed), ScaledView()));
  };
  const std::vector<SitToStand> truth = measure(1e-3, 1);
  std::vector<double> normalized;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const std::vector<SitToStand> found = measure(0.3, seed);
    ASSERT_EQ(found.size(), truth.size());
    for (std::size_t r = 0; r < 3; ++r) {
      const Measured& lean = found[r].trunk_pelvis_seat_off_deg;
      normalized.push_back((lean.value - truth[r].trunk_pelvis_seat_off_deg.value) / lean.sd);
    }
  }
  // 36 errors: their root mean square, if the SDs hold, is 1 ± 0.12.
  EXPECT_GT(RootMeanSquare(normalized), 0.65);
  EXPECT_LT(RootMeanSquare(normalized), 1.4);
}

TEST(TrunkOnPelvis, IsUnknownWithoutAPelvisOfItsOwn) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 1});
  const motion::MarkerRecording whole = WithPelvis(leg, {}, 3);
  const auto expect_none = [](const motion::MarkerRecording& recording, const char* why) {
    const gait::LegFitResult fit = gait::FitLeg(recording, ScaledView());
    EXPECT_THAT(gait::FindTrunkOnPelvis(fit).warning, testing::HasSubstr(why));
    const SitToStand rise = gait::MeasureSitToStands(fit).front();
    EXPECT_TRUE(std::isfinite(rise.trunk_max_deg.value));
    EXPECT_TRUE(std::isnan(rise.trunk_pelvis_seat_off_deg.value));
    EXPECT_TRUE(std::isnan(rise.trunk_pelvis_max_deg.value));
  };
  motion::MarkerRecording without = whole;
  without.markers.pop_back();
  expect_none(without, "none called 'psis'");
  motion::MarkerRecording exchanged = whole;
  std::swap(exchanged.markers[4].name, exchanged.markers[5].name);
  expect_none(exchanged, "'asis' is behind 'psis'");
  const SyntheticLeg low = MakeSyntheticLeg({.rate_hz = 60, .repetitions = 1, .trunk_mm = 90});
  expect_none(WithPelvis(low, {}, 3), "the waist marker is on the pelvis itself");
  without.markers.pop_back();
  EXPECT_EQ(gait::FindTrunkOnPelvis(gait::FitLeg(without, ScaledView())).warning, "");
}

TEST(SitToStand, FiveTimesTestIsTheFirstFiveRises) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 50, .repetitions = 6});
  const std::vector<SitToStand> rows = gait::MeasureSitToStands(Fit(leg, {}, 3));
  ASSERT_EQ(rows.size(), 7u);
  const SitToStand& test = rows.back();
  EXPECT_EQ(test.repetition, 0);
  EXPECT_DOUBLE_EQ(test.onset_s.value, rows[0].onset_s.value);
  EXPECT_DOUBLE_EQ(test.standing_s.value, rows[4].standing_s.value);
  EXPECT_DOUBLE_EQ(test.five_times_s.value, rows[4].standing_s.value - rows[0].onset_s.value);
  std::vector<double> rises_s;
  for (std::size_t r = 0; r < 5; ++r) rises_s.push_back(rows[r].rise_s.value);
  EXPECT_DOUBLE_EQ(test.rise_s.value, Mean(rises_s));
  EXPECT_DOUBLE_EQ(test.rise_s.sd, StandardDeviation(rises_s));
  // Alcazar's equation, its height difference measured. To the fifth standing there are five rises and four lowerings.
  EXPECT_NEAR(test.power_w_kg.value, 0.9 * 9.81 * test.hip_rise.value / 1000 / (test.five_times_s.value / 9), 1e-9);
  const Json json = gait::FiveTimesJson(test, {});
  EXPECT_EQ(json["ends"], "fifth standing");
  EXPECT_EQ(json["half_cycles"], 9);
}

// Who rises and sits down without a rest gives the same power in each rise as in the test.
TEST(SitToStand, PowerOfTheTestIsThatOfItsRisesWhereNothingIsBetweenThem) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 100, .repetitions = 5, .rest_s = 0.3, .move_s = 1.2});
  const std::vector<SitToStand> rows = gait::MeasureSitToStands(Fit(leg, {}, 3));
  ASSERT_EQ(rows.size(), 6u);
  const SitToStand& test = rows.back();
  // Eight rests of 0.3 s stand between the nine moves.
  const double without_rests = 9 / (test.five_times_s.value - 8 * 0.3) * test.five_times_s.value / 9;
  EXPECT_NEAR(test.power_w_kg.value * without_rests, rows[0].power_w_kg.value, 0.05 * rows[0].power_w_kg.value);
}

// Bohannon's summary of 13 papers.
TEST(SitToStand, FiveTimesTestIsHeldAgainstPeopleOfTheAge) {
  EXPECT_EQ(gait::FiveTimesReference_s(60), 11.4);
  EXPECT_EQ(gait::FiveTimesReference_s(69.9), 11.4);
  EXPECT_EQ(gait::FiveTimesReference_s(70), 12.6);
  EXPECT_EQ(gait::FiveTimesReference_s(89), 14.8);
  EXPECT_FALSE(gait::FiveTimesReference_s(59));
  EXPECT_FALSE(gait::FiveTimesReference_s(90));
}

// Baltasar-Fernandez et al.: among older adults, 2.5 W/kg of men and 1.9 W/kg of women.
TEST(SitToStand, PowerOfTheTestIsHeldAgainstOlderPeopleOfTheSex) {
  using motion::Sex;
  EXPECT_EQ(gait::LowPowerWKg(Sex::kMale, {}), 2.5);
  EXPECT_EQ(gait::LowPowerWKg(Sex::kFemale, 65), 1.9);
  EXPECT_FALSE(gait::LowPowerWKg(Sex::kMale, 64));
  SitToStand test;
  EXPECT_TRUE(gait::FiveTimesJson(test, {{}, Sex::kMale}).is_null());
  test.five_times_s = {12, 0.1}, test.power_w_kg = {2.2, 0.1};
  const Json unknown = gait::FiveTimesJson(test, {}), young = gait::FiveTimesJson(test, {40, Sex::kMale}),
             man = gait::FiveTimesJson(test, {72, Sex::kMale}), woman = gait::FiveTimesJson(test, {72, Sex::kFemale});
  EXPECT_EQ(unknown["power_w_kg"], 2.2);
  EXPECT_FALSE(unknown.contains("low_power"));
  EXPECT_TRUE(young["low_power_below_w_kg"].is_null());
  EXPECT_FALSE(young.contains("low_power"));
  EXPECT_EQ(man["low_power"], true);
  EXPECT_EQ(woman["low_power"], false);
  EXPECT_EQ(woman["worse_than_average"], false);
}

TEST(SitToStand, TableHasARowARiseAndTheTest) {
  const TemporaryFolder folder;
  gait::LegFitResult fit = Fit(MakeSyntheticLeg({.rate_hz = 50, .repetitions = 2}), {}, 3);
  std::erase_if(fit.events, [](const motion::StsEvent& e) {
    return e.repetition == 2 && e.kind == motion::StsEventKind::kStanding;
  });
  gait::WriteSitToStandCsv(folder / "sit_to_stand.csv", gait::MeasureSitToStands(fit), fit.motion.unit);
  const CsvTable table = CsvTable::Read(folder / "sit_to_stand.csv");
  ASSERT_EQ(table.Rows(), 3u);
  // The fourth phase, the pelvis and the centre of mass came later, and stand behind for those who read columns by
  // their order.
  const std::string later =
      ",five_times_s{0},stabilisation_s{0},trunk_pelvis_seat_off_deg{0},trunk_pelvis_max_deg{0},com_seat_off_mm{0},"
      "com_forward_max_mm_s{0},com_upward_max_mm_s{0}";
  EXPECT_THAT(ReadTextFile(folder / "sit_to_stand.csv"),
              testing::AllOf(testing::StartsWith("repetition,onset_s,seat_off_s,standing_s,rise_s,flexion_s,transfer_s,"
                                                 "extension_s,descent_s,"),
                             testing::HasSubstr(fmt::format(fmt::runtime(later), "") + ",onset_s_sd,"),
                             testing::HasSubstr(fmt::format(fmt::runtime(later), "_sd") + "\n")));
  EXPECT_TRUE(table.Has("hip_speed_max_mm_s_sd"));
  EXPECT_TRUE(table.Number(0, table.Column("rise_s")));
  EXPECT_FALSE(table.Number(1, table.Column("rise_s")));  // the recording ends before the person stands
  EXPECT_TRUE(table.Number(1, table.Column("seat_off_s")));
  EXPECT_EQ(table.Text(2, 0), "five_times");
  EXPECT_FALSE(table.Number(2, table.Column("five_times_s")));
}

// The leg fit has no table of masses: whoever has one says where the centre of mass is, by the rise's number.
TEST(SitToStand, TakesTheCentreOfMassOfEachRise) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 50, .repetitions = 5});
  const gait::LegFitResult fit = Fit(leg, {}, 3);
  gait::CentresOfMass centres;
  for (int rise = 1; rise <= 4; ++rise)
    centres[rise] = {.seat_off_mm = {-10.0 * rise, 2}, .forward_max_mm_s = {300, 5}, .upward_max_mm_s = {}};
  std::vector<SitToStand> rows = gait::MeasureSitToStands(fit, {}, centres);
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(rows[2].com_seat_off_mm.value, -30);
  EXPECT_EQ(rows[2].com_seat_off_mm.sd, 2);
  EXPECT_EQ(rows[2].com_forward_max_mm_s.value, 300);
  EXPECT_TRUE(std::isnan(rows[2].com_upward_max_mm_s.value));
  EXPECT_TRUE(std::isnan(rows[4].com_seat_off_mm.value));
  EXPECT_TRUE(std::isnan(rows[5].com_seat_off_mm.value)) << "of five times, where one is not known";
  centres[5] = {.seat_off_mm = {-50, 2}, .forward_max_mm_s = {}, .upward_max_mm_s = {}};
  rows = gait::MeasureSitToStands(fit, {}, centres);
  EXPECT_EQ(rows[5].com_seat_off_mm.value, -30);
  EXPECT_NEAR(rows[5].com_seat_off_mm.sd, std::sqrt(250), 1e-9);  // of −10, −20, … −50
}

TEST(SitToStand, TableTellsTheEventsDeviations) {
  const TemporaryFolder folder;
  gait::LegFitResult fit = Fit(MakeSyntheticLeg({.rate_hz = 50, .repetitions = 2}), {}, 3);
  gait::WriteSitToStandCsv(folder / "sit_to_stand.csv", gait::MeasureSitToStands(fit), fit.motion.unit);
  std::vector<motion::StsEvent> read = fit.events;
  for (motion::StsEvent& event : read) event.sd_s = NAN;
  read[0].time_s += 0.5;  // corrected by hand
  gait::ReadEventDeviations(folder / "sit_to_stand.csv", read);
  ASSERT_EQ(read[0].kind, motion::StsEventKind::kOnset);
  EXPECT_TRUE(std::isnan(read[0].sd_s));
  for (const motion::StsEvent& event : fit.events) {
    const auto same = std::ranges::find_if(
        read, [&](const auto& e) { return e.repetition == event.repetition && e.kind == event.kind; });
    if (event.kind == motion::StsEventKind::kStanding || event.kind == motion::StsEventKind::kSeatOff) {
      EXPECT_GT(event.sd_s, 0);
      EXPECT_EQ(same->sd_s, event.sd_s);
    }
  }
}

// A recording of px has no power, and its lengths are in px.
TEST(SitToStand, WithoutAScaleThereIsNoPower) {
  const SyntheticLeg leg = MakeSyntheticLeg({.rate_hz = 50, .repetitions = 1});
  const gait::LegFitResult fit = gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {}, 3), {});
  const TemporaryFolder folder;
  gait::WriteSitToStandCsv(folder / "sit_to_stand.csv", gait::MeasureSitToStands(fit), fit.motion.unit);
  const CsvTable table = CsvTable::Read(folder / "sit_to_stand.csv");
  EXPECT_TRUE(table.Number(0, table.Column("hip_rise_px")));
  EXPECT_FALSE(table.Number(0, table.Column("power_w_kg")));
}

}  // namespace
}  // namespace lake
