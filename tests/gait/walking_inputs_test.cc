// What is given beside the markers of a walk: force plates, events, quiet standing; and squats' measures.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <span>

#include "drawn_walk.h"
#include "draws.h"
#include "fitted_movement.h"
#include "lake/core/angles.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/exchange/trial.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/movement.h"
#include "lake/gait/squats.h"
#include "message_of.h"
#include "name_map.h"
#include "places.h"
#include "real_markers.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using motion::StsEventKind;
using testing::AllOf;
using testing::Ge;
using testing::HasSubstr;
using testing::Le;

// White, of this size per axis; the file says it.
void AddNoise(double noise_mm, unsigned seed, motion::MarkerRecording& recording) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_mm);
  for (motion::MarkerTrack& marker : recording.markers)
    for (motion::MarkerSample& sample : marker.samples) {
      if (!sample.IsKnown()) continue;
      sample.position += Eigen::Vector2d(noise(random), noise(random));
      sample.sigma = noise_mm;
    }
}

gait::LegFitResult FitWith(const motion::MarkerRecording& recording, const gait::PlateContact& contact) {
  gait::MovementOptions movement;
  movement.walking.contacts = {contact};
  return FitMovement(recording, {}, movement);
}

// The contact of the drawn walk's own or other foot in its second stride, by an amount later than it is drawn.
gait::PlateContact ContactOf(const DrawnWalkOptions& drawn, bool is_other, double later_s) {
  gait::PlateContact contact;
  contact.plate = "plate";
  const double phase = is_other ? 1.5 : 1.0;
  contact.begin_s = (phase + 0.3) * drawn.stride_s + later_s;
  contact.end_s = contact.begin_s + drawn.stance * drawn.stride_s;
  contact.begin_sd_s = contact.end_sd_s = 0.001;
  return contact;
}

void RemoveOther(motion::MarkerRecording& walk) {
  std::erase_if(walk.markers, [](const motion::MarkerTrack& marker) { return marker.name.starts_with("other"); });
}

struct Contact {
  bool is_other, has_other_markers;
};
class PlateContacts : public testing::TestWithParam<Contact> {};

// A contact's events are those of the foot on the plate, and of no other; without the other foot's markers its contact
// is of nobody.
TEST_P(PlateContacts, AreOfTheFootThatStays) {
  const auto [is_other, has_other_markers] = GetParam();
  DrawnWalkOptions drawn;
  drawn.noise_mm = 0.5;
  motion::MarkerRecording walk = DrawWalk(drawn);
  if (!has_other_markers) RemoveOther(walk);
  const double later_s = 0.04;
  const gait::PlateContact contact = ContactOf(drawn, is_other, later_s);
  const gait::LegFitResult leg = FitWith(walk, contact);
  const std::vector<gait::PlateEvent>& found = leg.movement.walk.by_plate;
  if (is_other && !has_other_markers) {
    EXPECT_TRUE(found.empty());
    return;
  }
  ASSERT_EQ(found.size(), 2u);
  const auto beside = [](const std::string& warning) { return warning.find("beside the plate") != std::string::npos; };
  EXPECT_EQ(std::ranges::count_if(leg.warnings, beside), std::ranges::count_if(found, [](const gait::PlateEvent& of) {
              return std::abs(of.markers_later_s) > 0.04;
            }));
  EXPECT_EQ(found[0].event.kind, is_other ? StsEventKind::kHeelStrikeOther : StsEventKind::kHeelStrike);
  EXPECT_EQ(found[1].event.kind, is_other ? StsEventKind::kToeOffOther : StsEventKind::kToeOff);
  int taken = 0;
  for (const motion::StsEvent& event : leg.events)
    taken += event.time_s == contact.begin_s || event.time_s == contact.end_s ? 1 : 0;
  EXPECT_EQ(taken, 2);
  // As the drawn events are found within 4.5 % of the stride (walking_test.cc).
  for (const gait::PlateEvent& of : found) EXPECT_NEAR(of.markers_later_s, -later_s, 0.045 * drawn.stride_s);
  EXPECT_EQ(leg.events.size(), FitMovement(walk).events.size());
}

INSTANTIATE_TEST_SUITE_P(Contacts, PlateContacts,
                         testing::Values(Contact{false, true}, Contact{true, true}, Contact{false, false},
                                         Contact{true, false}));

// One foot steps on the plate, and the other one leaves it.
TEST(PlateContact, OfBothFeetGivesEachItsOwnEvent) {
  const DrawnWalkOptions drawn;
  gait::PlateContact both = ContactOf(drawn, false, 0);
  both.end_s = ContactOf(drawn, true, 0).end_s;
  motion::MarkerRecording walk = DrawWalk(drawn);
  const std::vector<gait::PlateEvent> found = FitWith(walk, both).movement.walk.by_plate;
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].event.kind, StsEventKind::kHeelStrike);
  EXPECT_EQ(found[1].event.kind, StsEventKind::kToeOffOther);
  RemoveOther(walk);
  EXPECT_EQ(FitWith(walk, both).movement.walk.by_plate.size(), 1u);
}

// Where one of its events is hidden from the camera, the other one is still the plate's.
TEST(PlateContact, WhoseEndTheMarkersMissKeepsItsBegin) {
  const DrawnWalkOptions drawn;
  const gait::PlateContact contact = ContactOf(drawn, false, 0);
  motion::MarkerRecording walk = DrawWalk(drawn);
  for (motion::MarkerTrack& marker : walk.markers)
    for (std::size_t i = 0; i < marker.samples.size(); ++i)
      if (std::abs(walk.time_s[i] - contact.end_s) < 0.25) marker.samples[i] = {};
  const std::vector<gait::PlateEvent> found = FitWith(walk, contact).movement.walk.by_plate;
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].event.kind, StsEventKind::kHeelStrike);
}

// A plate's event is not off as those that markers show are: of a stride from one to the other nothing cancels.
TEST(PlateContact, MakesAStrideToAMarkersEventLessCertain) {
  const DrawnWalkOptions drawn;
  const gait::LegFitResult markers = FitMovement(DrawWalk(drawn)),
                           mixed = FitWith(DrawWalk(drawn), ContactOf(drawn, false, 0));
  const auto before = gait::MeasureGaitCycles(markers).rows, after = gait::MeasureGaitCycles(mixed).rows;
  const auto struck = std::ranges::find_if(after, [&](const gait::GaitCycle& cycle) {
    return cycle.begin_s.value == mixed.movement.walk.by_plate.front().event.time_s;
  });
  ASSERT_NE(struck, after.end());
  const gait::GaitCycle &own = before.at(static_cast<std::size_t>(struck - after.begin())), &of = *struck;
  const auto next = std::ranges::find_if(mixed.events, [&](const motion::StsEvent& event) {
    return event.kind == StsEventKind::kHeelStrike && event.time_s > of.begin_s.value;
  });
  EXPECT_NEAR(of.stride_s.sd, std::hypot(of.begin_s.sd, next->sd_s), 1e-9);
  EXPECT_GT(of.stride_s.sd, own.stride_s.sd);
  // The stride's end, which markers show, is part of the share's deviation, too.
  EXPECT_GE(of.stance_percent.sd, of.stance_percent.value * 0.5 * next->sd_s / of.stride_s.value);
}

TEST(GivenEvents, OfAWalkReplaceAllThatWereFound) {
  DrawnWalkOptions drawn;
  drawn.noise_mm = 0.5;
  gait::LegFitResult leg = FitMovement(DrawWalk(drawn));
  const TemporaryFolder folder;
  motion::WriteEventsCsv(folder / "events.csv", leg.events);
  const std::vector<motion::StsEvent> found = leg.events;
  const int strides = leg.movement.walk.strides, incomplete = leg.movement.walk.incomplete;
  // The same file again changes nothing, standard deviations included.
  gait::CorrectEvents(motion::ReadEventCorrections(folder / "events.csv"), leg);
  ASSERT_EQ(leg.events.size(), found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(leg.events[i].kind, found[i].kind);
    EXPECT_EQ(leg.events[i].time_s, found[i].time_s);
    EXPECT_EQ(leg.events[i].sd_s, found[i].sd_s);
  }
  EXPECT_EQ(leg.movement.walk.strides, strides);
  EXPECT_EQ(leg.movement.walk.incomplete, incomplete);
  // One that is moved, and one that is taken away, as lake review writes it.
  motion::EventCorrection moved{2, StsEventKind::kToeOff, {}, found[0].time_s, {}},
      away{1, StsEventKind::kHeelStrike, {}, {}, {}};
  const auto at = std::ranges::find_if(found, [](const motion::StsEvent& event) {
    return event.kind == StsEventKind::kToeOff && event.repetition == 2;
  });
  moved.time_s = at->time_s + 0.05;
  motion::WriteEventCorrections(folder / "moved.csv", {moved, away});
  const std::vector<motion::StsEvent> merged = motion::ApplyEventCorrections(
      motion::ReadEventCorrections(folder / "moved.csv"), leg.motion.frame, leg.motion.time_s, found);
  ASSERT_EQ(merged.size(), found.size() - 1);
  for (const motion::StsEvent& event : merged)
    if (event.kind == at->kind && event.repetition == 2) {
      EXPECT_DOUBLE_EQ(event.time_s, at->time_s + 0.05);
    } else {
      EXPECT_TRUE(std::ranges::any_of(found, [&](const motion::StsEvent& other) {
        return other.kind == event.kind && other.time_s == event.time_s && other.sd_s == event.sd_s;
      }));
    }
  WriteTextFile(folder / "given.csv",
                "repetition,event,time_s\n1,heel_strike,1.5\n1,toe_off,2.2\n2,heel_strike,2.55\n");
  gait::CorrectEvents(motion::ReadEventCorrections(folder / "given.csv"), leg);
  const gait::Measures<gait::GaitCycle> cycles = gait::MeasureGaitCycles(leg);
  ASSERT_EQ(cycles.rows.size(), 1u);
  EXPECT_DOUBLE_EQ(cycles.rows[0].stride_s.value, 2.55 - 1.5);
  EXPECT_TRUE(std::isnan(cycles.rows[0].stride_s.sd));  // nobody said it
  EXPECT_EQ(leg.movement.walk.strides, 1);
  WriteTextFile(folder / "given.csv", "repetition,event,time_s\n2,heel_strike,1.5\n1,heel_strike,2.55\n");
  EXPECT_THROW(gait::CorrectEvents(motion::ReadEventCorrections(folder / "given.csv"), leg), Error);
}

// A leg that stands for three seconds with a knee of 4°, swaying by 0.5°, and then bends to 60°.
motion::MarkerRecording StandAndBend(unsigned seed) {
  motion::MarkerRecording recording;
  recording.unit = motion::LengthUnit::kMm;
  for (const char* name : {"ankle", "knee", "hip", "waist"}) recording.markers.push_back({name, {}});
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.3);
  const auto along = [](double length, double deg) {
    return Eigen::Vector2d(length * std::sin(RadiansFromDegrees(deg)), length * std::cos(RadiansFromDegrees(deg)));
  };
  for (int i = 0; i < 500; ++i) {
    const double t = i / 100.0, bend = t < 3 ? 0 : 28 * (1 - std::cos((t - 3) * 3.14159));
    const double sway = 0.5 * std::numbers::sqrt2 * std::sin(2 * 3.14159 * 0.7 * t + seed);
    const Eigen::Vector2d ankle(0, 80), knee = ankle + along(430, 5 + bend / 2 + sway),
                                        hip = knee + along(410, 1 - bend / 2), waist = hip + along(250, 3);
    recording.frame.push_back(i);
    recording.time_s.push_back(t);
    std::size_t m = 0;
    for (const Eigen::Vector2d& place : {ankle, knee, hip, waist})
      recording.markers[m++].samples.push_back(
          {place + Eigen::Vector2d(noise(random), noise(random)), 0.3, motion::SampleStatus::kDetected});
  }
  return recording;
}

TEST(NeutralPose, IsThatOfQuietStanding) {
  std::vector<double> errors_sd;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    gait::LegFitResult leg = FitMovement(StandAndBend(seed));
    const motion::LegSample pose = gait::NeutralPose(leg, 0.2, 2.8);
    EXPECT_NEAR(pose.knee_deg, 4, 0.3);
    EXPECT_NEAR(pose.shank_deg, 5, 0.3);
    EXPECT_NEAR(pose.thigh_deg, 1, 0.1);
    EXPECT_NEAR(pose.knee_sigma_deg, 0.5, 0.15);  // the sway
    leg.motion.neutral = pose;
    const TemporaryFolder folder;
    motion::WriteKinematicsCsv(folder / "kinematics.csv", leg.motion);
    const CsvTable table = CsvTable::Read(folder / "kinematics.csv");
    EXPECT_NEAR(table.RequiredNumber(400, table.Column("knee_neutral_deg")),
                table.RequiredNumber(400, table.Column("knee_deg")) - pose.knee_deg, 1e-12);
    EXPECT_FALSE(table.Has("foot_neutral_deg"));
    // Against a frame of the standing, whose pose is as uncertain.
    errors_sd.push_back((leg.motion.samples[150].knee_deg - pose.knee_deg) / pose.knee_sigma_deg);
  }
  EXPECT_THAT(RootMeanSquare(errors_sd), AllOf(Ge(0.5), Le(1.6)));
}

TEST(NeutralPose, SaysWhereNobodyStandsQuietly) {
  const gait::LegFitResult leg = FitMovement(StandAndBend(1));
  const auto said = [&](double from_s, double to_s) {
    return MessageOf([&] { gait::NeutralPose(leg, from_s, to_s); });
  };
  EXPECT_THAT(said(3, 5), HasSubstr("the knee's angle sways by"));
  EXPECT_THAT(said(3.98, 4.06), HasSubstr("the knee is bent by"));
  EXPECT_THAT(said(7, 8), HasSubstr("0 frames show the leg there"));
}

struct OpticalStrides {
  const char* file;
  char side;
};
class OpticalKnee : public testing::TestWithParam<OpticalStrides> {};

// Signed by the side to which the knee bends most.
// The angle between the joint centres' vectors in the frames as recorded, with nothing smoothed: at the heel strike
// between the frames beside it, its largest in swing and its range within the same times.
TEST_P(OpticalKnee, IsThatOfTheJointCentres) {
  const auto [name, side] = GetParam();
  const fs::path file = SharedData() / "opensim_walk" / name;
  if (!fs::exists(file)) GTEST_SKIP() << "no recordings";
  const auto names =
      NameMap(fmt::format("ankle={0}AJC,knee={0}KJC,hip={0}HJC,waist={0}ASI+{0}PSI,heel={0}CAL,toe={0}MT2", side));
  gait::LegFitResult leg = FitMovement(exchange::ReadTrial(file, {names, {}, ""}));
  const exchange::PointRecording points = exchange::RenamePoints(exchange::ReadPoints(file, {}), names, file);
  std::vector<double> knee_deg;
  std::vector<Eigen::Vector3d> normals;
  for (std::size_t i = 0; i < points.time_s.size(); ++i) {
    const Eigen::Vector3d ankle = points.Find("ankle")->positions[i], knee = points.Find("knee")->positions[i],
                          hip = points.Find("hip")->positions[i];
    knee_deg.push_back(DegreesFromRadians(std::acos((knee - ankle).normalized().dot((hip - knee).normalized()))));
    normals.push_back((knee - ankle).cross(hip - knee));
  }
  std::size_t bent = 0;
  for (std::size_t i = 0; i < knee_deg.size(); ++i)
    if (knee_deg[i] > knee_deg[bent] || std::isnan(knee_deg[bent])) bent = i;
  for (std::size_t i = 0; i < knee_deg.size(); ++i)
    if (normals[i].dot(normals[bent]) < 0) knee_deg[i] *= -1;
  const auto measure = [&](const motion::StsEvent& strike, const motion::StsEvent& off, double end_s) {
    const auto after =
        static_cast<std::size_t>(std::ranges::lower_bound(points.time_s, strike.time_s) - points.time_s.begin());
    const double part = (strike.time_s - points.time_s[after - 1]) / (points.time_s[after] - points.time_s[after - 1]);
    double swing = -90, least = 180, most = -90;
    for (std::size_t i = 0; i < knee_deg.size(); ++i) {
      if (points.time_s[i] < strike.time_s || points.time_s[i] > end_s || !std::isfinite(knee_deg[i])) continue;
      least = std::min(least, knee_deg[i]);
      most = std::max(most, knee_deg[i]);
      if (points.time_s[i] >= off.time_s) swing = std::max(swing, knee_deg[i]);
    }
    return std::array{std::lerp(knee_deg[after - 1], knee_deg[after], part), swing, most - least};
  };
  // The recordings hold no whole stride of every leg: where one is missing, the end of the recording ends it.
  std::vector<motion::StsEvent> strikes, offs;
  for (const motion::StsEvent& event : leg.events) {
    if (event.kind == StsEventKind::kHeelStrike) strikes.push_back(event);
    if (event.kind == StsEventKind::kToeOff) offs.push_back(event);
  }
  ASSERT_FALSE(strikes.empty());
  const auto off = std::ranges::find_if(offs, [&](const auto& event) { return event.time_s > strikes[0].time_s; });
  ASSERT_NE(off, offs.end());
  if (strikes.size() < 2) {
    motion::StsEvent last = strikes[0];
    last.repetition = strikes[0].repetition + 1;
    last.time_s = std::min(off->time_s + 0.45, leg.motion.time_s.back() - 0.02);
    leg.events.push_back(last);
    strikes.push_back(last);
  }
  const gait::Measures<gait::GaitCycle> cycles = gait::MeasureGaitCycles(leg);
  ASSERT_FALSE(cycles.rows.empty());
  const gait::GaitCycle& cycle = cycles.rows.front();
  const auto [at_strike, swing, range] = measure(strikes[0], *off, strikes[1].time_s);
  EXPECT_NEAR(cycle.knee_heel_strike_deg.value, at_strike, 1);
  EXPECT_NEAR(cycle.knee_swing_deg.value, swing, 1);
  EXPECT_NEAR(cycle.knee_range_deg.value, range, 1);
  EXPECT_THAT(cycle.knee_swing_deg.value, AllOf(Ge(60), Le(78)));
}

INSTANTIATE_TEST_SUITE_P(OpenSim, OpticalKnee,
                         testing::Values(OpticalStrides{"walking2.c3d", 'R'}, OpticalStrides{"walking5.c3d", 'R'},
                                         OpticalStrides{"walking2.c3d", 'L'}, OpticalStrides{"walking5.c3d", 'L'}));

// Five of a person.
class Squats : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(file_)) GTEST_SKIP() << "no recordings";
  }
  exchange::Trial Read(const char* leg) const { return exchange::ReadTrial(file_, {NameMap(leg), {}, ""}); }

  const fs::path file_ = SharedData() / "real_motions/subject4_squats1.trc";
};

// Against the hip's marker itself: its height, and the frames in which it is lowest.
TEST_F(Squats, AreMeasuredAsTheMarkersShowThem) {
  const exchange::Trial trial = Read(kRightLeg);
  const gait::LegFitResult leg = FitMovement(trial);
  ASSERT_EQ(leg.movement.kind, gait::MovementKind::kSquat);
  const gait::Measures<gait::Squat> squats = gait::MeasureSquats(leg);
  ASSERT_EQ(squats.rows.size(), 5u);
  const motion::MarkerTrack& hip = *trial.recording.Find("hip");
  for (const gait::Squat& squat : squats.rows) {
    const double from_s = squat.begin_s.value, to_s = from_s + squat.squat_s.value;
    double lowest = 1e9, lowest_s = 0, first = NAN;
    for (std::size_t i = 0; i < trial.recording.time_s.size(); ++i) {
      const double time_s = trial.recording.time_s[i], height = hip.samples[i].position.y();
      if (time_s < from_s || time_s > to_s || !hip.samples[i].IsKnown()) continue;
      if (std::isnan(first)) first = height;
      if (height < lowest) {
        lowest = height;
        lowest_s = time_s;
      }
    }
    EXPECT_NEAR(squat.depth.value, first - lowest, 5);
    EXPECT_NEAR(squat.descent_s.value, lowest_s - from_s, 0.1);
    EXPECT_NEAR(squat.squat_s.value, squat.descent_s.value + squat.ascent_s.value, 1e-9);
    // The mean speed of the way down and up, and what a smooth movement has at most (Flash & Hogan 1985: 1.875 times).
    EXPECT_THAT(squat.descent_speed.value * squat.descent_s.value / squat.depth.value, AllOf(Ge(1.2), Le(3.0)));
    EXPECT_THAT(squat.ascent_speed.value * squat.ascent_s.value / squat.depth.value, AllOf(Ge(1.2), Le(3.0)));
    for (const gait::Field<gait::Squat>& field : gait::Squat::Fields())
      EXPECT_GE((squat.*field.value).sd, 0) << field.name;
  }
  const TemporaryFolder folder;
  gait::WriteMeasures(folder / "squats.csv", "squat", squats, motion::LengthUnit::kMm);
  const CsvTable table = CsvTable::Read(folder / "squats.csv");
  EXPECT_EQ(table.Rows(), squats.rows.size() + 2);
  EXPECT_EQ(table.RequiredNumber(0, table.Column("depth_mm")), squats.rows[0].depth.value);
}

// Each measure's scatter over draws of the markers' noise against its standard deviation.
template <typename Row>
std::map<std::string, double> ScatterOverSd(const std::vector<std::vector<Row>>& draws,
                                            std::span<const gait::Field<Row>> fields) {
  std::map<std::string, double> ratios;
  for (const gait::Field<Row>& field : fields) {
    std::vector<double> scatters, sds;
    for (std::size_t r = 0; r < draws.front().size(); ++r) {
      std::vector<double> values;
      for (const std::vector<Row>& draw : draws) {
        values.push_back((draw[r].*field.value).value);
        sds.push_back((draw[r].*field.value).sd);
      }
      scatters.push_back(StandardDeviation(values));
    }
    ratios[field.name] = RootMeanSquare(scatters) / RootMeanSquare(sds);
  }
  return ratios;
}

// The standard deviations hold what the person's own markers lack, too: 0.40 to 0.52 of them are the noise drawn here.
TEST_F(Squats, ScatterByNoMoreThanTheirStandardDeviationsSay) {
  const exchange::Trial trial = Read(kRightLeg);
  std::vector<std::vector<gait::Squat>> draws;
  for (unsigned seed = 1; seed <= Draws(5, 12); ++seed) {
    motion::MarkerRecording noisy = trial.recording;
    AddNoise(1, seed, noisy);
    draws.push_back(gait::MeasureSquats(FitMovement(noisy, trial.lateral_mm)).rows);
    ASSERT_EQ(draws.back().size(), 5u);
  }
  for (const auto& [name, ratio] : ScatterOverSd<gait::Squat>(draws, gait::Squat::Fields()))
    EXPECT_THAT(ratio, AllOf(Ge(0.35), Le(1.6))) << name;
}

// Against the events of the markers as they are; where the hip comes to rest slowly its speed's slope says too little.
TEST_F(Squats, EventsErrAsTheirStandardDeviationsSay) {
  std::map<StsEventKind, std::vector<double>> errors_sd;
  for (const char* leg : {kRightLeg, kLeftLeg}) {
    const exchange::Trial trial = Read(leg);
    const std::vector<motion::StsEvent> truth = FitMovement(trial).events;
    for (unsigned seed = 1; seed <= Draws(2, 6); ++seed) {
      motion::MarkerRecording noisy = trial.recording;
      AddNoise(2, seed, noisy);
      const std::vector<motion::StsEvent> found = FitMovement(noisy, trial.lateral_mm).events;
      ASSERT_EQ(found.size(), truth.size());
      for (std::size_t i = 0; i < found.size(); ++i)
        errors_sd[found[i].kind].push_back((found[i].time_s - truth[i].time_s) / found[i].sd_s);
    }
  }
  for (const auto& [kind, of] : errors_sd) EXPECT_THAT(RootMeanSquare(of), AllOf(Ge(0.5), Le(1.6))) << ToString(kind);
}

// Events' scatter between persons is in the standard deviations of what hangs on them; of ranges and lengths the noise
// is all.
TEST(GaitCycles, ScatterAsTheirStandardDeviationsSay) {
  std::vector<std::vector<gait::GaitCycle>> draws;
  for (unsigned seed = 1; seed <= Draws(5, 12); ++seed) {
    DrawnWalkOptions drawn;
    drawn.noise_mm = 1;
    drawn.seed = seed;
    draws.push_back(gait::MeasureGaitCycles(FitMovement(DrawWalk(drawn))).rows);
    ASSERT_EQ(draws.back().size(), draws.front().size());
  }
  std::map<std::string, double> ratios = ScatterOverSd<gait::GaitCycle>(draws, gait::GaitCycle::Fields());
  for (const auto& [name, ratio] : ratios) EXPECT_LE(ratio, 1.6) << name;
  for (const char* name : {"knee_swing_deg", "knee_range_deg", "thigh_range_deg", "shank_range_deg", "ankle_range_deg",
                           "stride_mm", "toe_clearance_mm"})
    EXPECT_GE(ratios.at(name), 0.6) << name;
}

template <typename Row>
void ExpectDescribed(const std::string& table) {
  const std::string described = ReadTextFile(SourceDir() / "apps/python/lake/columns.csv");
  for (const gait::Field<Row>& field : Row::Fields()) {
    const char* quote = std::string(field.meaning).find(',') == std::string::npos ? "" : "\"";
    EXPECT_THAT(described, HasSubstr(fmt::format("\n{0},{1},{2},{4}{3}{4},", table, field.name, field.unit,
                                                 field.meaning, quote)));
    EXPECT_THAT(described, HasSubstr(fmt::format("\n{},{}_sd,", table, field.Column(motion::LengthUnit::kPx))));
  }
}

TEST(MeasuresColumns, AreDescribedAsTheFieldsAre) {
  ExpectDescribed<gait::Squat>("squats");
  ExpectDescribed<gait::GaitCycle>("gait_cycles");
}

// A norm that nobody could have measured gets a sentence.
TEST(ReferenceCurve, IsRefusedWhereItIsNone) {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& text) {
    WriteTextFile(folder / "norm.csv", text);
    return MessageOf([&] { gait::ReadReferenceCurve(folder / "norm.csv"); });
  };
  EXPECT_EQ(said("percent,mean,sd\n0,5,4\n50,20,5\n100,5,4\n"), "");
  EXPECT_THAT(said("percent,mean,sd\n0,5,4\n0,20,5\n"), HasSubstr("norm.csv:3: percent 0"));
  EXPECT_THAT(said("percent,mean,sd\n0,5,4\n120,20,5\n"), HasSubstr("percent 120"));
  EXPECT_THAT(said("percent,mean,sd\n0,5,-4\n50,20,5\n"), HasSubstr("is negative"));
  EXPECT_THAT(said("percent,mean\n0,5\n"), HasSubstr("sd"));
  EXPECT_THAT(said("percent,mean,sd\n0,5,4\n"), HasSubstr("two rows"));
}

}  // namespace
}  // namespace lake
