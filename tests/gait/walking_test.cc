// Heel strikes, toe-offs and strides: against force plates, and of drawn walks with known events.
#include "lake/gait/walking.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <random>

#include "drawn_walk.h"
#include "fitted_movement.h"
#include "lake/core/csv.h"
#include "lake/core/statistics.h"
#include "lake/exchange/ground_forces.h"
#include "lake/exchange/trial.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/movement.h"
#include "name_map.h"
#include "places.h"
#include "real_markers.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using motion::StsEventKind;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<double> StepTimes(const std::vector<motion::StsEvent>& events, StsEventKind kind) {
  std::vector<double> times;
  for (const motion::StsEvent& event : events)
    if (event.kind == kind) times.push_back(event.time_s);
  return times;
}

struct PlateEvent {
  StsEventKind kind;
  double time_s;
};

// Errors of the events of one kind, and the same in their own standard deviations.
struct Errors {
  std::vector<double> s, sds;
};

// A recording of a leg with its force plate's events, as it may be recorded otherwise.
struct Walked {
  exchange::Trial trial;
  std::vector<PlateEvent> plate;
};

exchange::Trial ReadWalk(const fs::path& file, const std::string& names) {
  return exchange::ReadTrial(file, {NameMap(names), {}, ""});
}

std::vector<Walked> WalksOverPlates(bool by_foot) {
  const fs::path folder = SharedData() / "walking_force_plates";
  const CsvTable table = CsvTable::Read(folder / "plate_events.csv");
  std::vector<Walked> walks;
  for (const char* name : {"walking1", "walkingTI1", "walkingTS1"})
    for (const std::string side : {"r", "L"}) {
      const std::string foot = side == "r" ? ",heel=r_calc,toe=r_toe" : ",heel=L_calc,toe=L_toe";
      Walked walk{
          ReadWalk(folder / (std::string(name) + ".trc"), (side == "r" ? kRightLeg : kLeftLeg) + (by_foot ? foot : "")),
          {}};
      for (std::size_t row = 0; row < table.Rows(); ++row)
        if (table.Text(row, 0) == name && table.Text(row, 1) == side)
          walk.plate.push_back({table.Text(row, 2) == "heel_strike" ? StsEventKind::kHeelStrike : StsEventKind::kToeOff,
                                table.RequiredNumber(row, 3)});
      walks.push_back(std::move(walk));
    }
  return walks;
}

// Every `step`-th frame, with noise.
motion::MarkerRecording Coarser(const motion::MarkerRecording& recording, std::size_t step, double noise_mm,
                                gait::LateralPlaces& lateral, unsigned seed) {
  motion::MarkerRecording coarse = recording;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_mm);
  const auto thin = [&](auto& values) {
    auto all = values;
    values.clear();
    for (std::size_t i = 0; i < all.size(); i += step) values.push_back(all[i]);
  };
  thin(coarse.frame);
  thin(coarse.time_s);
  for (motion::MarkerTrack& marker : coarse.markers) {
    thin(marker.samples);
    for (motion::MarkerSample& sample : marker.samples)
      if (noise_mm > 0 && sample.IsKnown()) {
        sample.position += Eigen::Vector2d(noise(random), noise(random));
        sample.sigma = noise_mm;
      }
  }
  for (auto& [name, places] : lateral) thin(places);
  return coarse;
}

void Compare(const std::vector<PlateEvent>& plate, const std::vector<motion::StsEvent>& events,
             std::map<StsEventKind, Errors>& errors) {
  constexpr double kFirst_s = 0.05, kSame_s = 0.15;
  for (const PlateEvent& truth : plate) {
    if (truth.time_s < kFirst_s) continue;
    const auto found = std::ranges::find_if(events, [&](const motion::StsEvent& event) {
      return event.kind == truth.kind && std::abs(event.time_s - truth.time_s) < kSame_s;
    });
    ASSERT_NE(found, events.end()) << ToString(truth.kind) << " at " << truth.time_s;
    errors[truth.kind].s.push_back(found->time_s - truth.time_s);
    errors[truth.kind].sds.push_back(errors[truth.kind].s.back() / found->sd_s);
  }
  // While the foot is on its plate it neither strikes nor leaves the ground.
  for (const motion::StsEvent& event : events)
    for (std::size_t i = 1; i < plate.size(); ++i)
      if (plate[i - 1].kind == StsEventKind::kHeelStrike && plate[i].kind == StsEventKind::kToeOff) {
        EXPECT_FALSE(event.time_s > plate[i - 1].time_s + kSame_s && event.time_s < plate[i].time_s - kSame_s)
            << ToString(event.kind) << " at " << event.time_s;
      }
}

struct Recorded {
  bool by_foot;
  std::size_t step;
  double noise_mm;
};

class WalkingOverPlates : public testing::TestWithParam<Recorded> {};

// Limits of the issue: 20 ms RMS and 40 ms at most with heel and toe, 30 and 60 ms with the ankle alone; and 0.6 to 1.6
// standard deviations.
TEST_P(WalkingOverPlates, EventsAreWhereThePlatesSee) {
  if (!fs::exists(SharedData() / "walking_force_plates")) GTEST_SKIP() << "no recordings";
  const auto [by_foot, step, noise_mm] = GetParam();
  std::map<StsEventKind, Errors> errors;
  for (const Walked& walk : WalksOverPlates(by_foot))
    for (unsigned seed = 1; seed <= (noise_mm > 0 ? 3u : 1u); ++seed) {
      gait::LateralPlaces lateral = walk.trial.lateral_mm;
      const motion::MarkerRecording recording = Coarser(walk.trial.recording, step, noise_mm, lateral, seed);
      const gait::LegFitResult leg = FitMovement(recording, lateral);
      EXPECT_EQ(leg.movement.kind, gait::MovementKind::kWalking);
      EXPECT_EQ(leg.movement.walk.ground, gait::Ground::kOverground);
      Compare(walk.plate, leg.events, errors);
    }
  for (const auto& [kind, of] : errors) {
    EXPECT_LE(RootMeanSquare(of.s), by_foot ? 0.020 : 0.030) << ToString(kind);
    for (const double error_s : of.s) EXPECT_LE(std::abs(error_s), by_foot ? 0.040 : 0.060) << ToString(kind);
    EXPECT_THAT(RootMeanSquare(of.sds), testing::AllOf(testing::Ge(0.6), testing::Le(1.6))) << ToString(kind);
  }
}

INSTANTIATE_TEST_SUITE_P(Recorded, WalkingOverPlates,
                         testing::Values(Recorded{true, 1, 0}, Recorded{true, 2, 1}, Recorded{true, 3, 0},
                                         Recorded{true, 1, 3}, Recorded{false, 1, 0}, Recorded{false, 2, 1},
                                         Recorded{false, 3, 0}, Recorded{false, 1, 3}));

// Parts of the recordings that hold a single stance, or a single toe-off.
TEST(Walking, IsSeenInAStepAlone) {
  if (!fs::exists(SharedData() / "walking_force_plates")) GTEST_SKIP() << "no recordings";
  for (const bool by_foot : {true, false})
    for (const auto& [later_s, earlier_s] : {std::pair{0.4, 0.0}, {0.0, 0.25}})
      for (Walked walk : WalksOverPlates(by_foot)) {
        const double from_s = walk.trial.recording.time_s.front() + later_s,
                     to_s = walk.trial.recording.time_s.back() - earlier_s;
        for (std::size_t i = 0; i < walk.trial.recording.time_s.size(); ++i)
          if (const double time_s = walk.trial.recording.time_s[i]; time_s < from_s || time_s > to_s)
            for (motion::MarkerTrack& marker : walk.trial.recording.markers) marker.samples[i] = {};
        constexpr double kEdge_s = 0.09;
        std::erase_if(walk.plate, [&, from_s = from_s, to_s = to_s](const PlateEvent& event) {
          return event.time_s < from_s + kEdge_s || event.time_s > to_s - kEdge_s;
        });
        std::map<StsEventKind, Errors> errors;
        Compare(walk.plate, FitMovement(walk.trial).events, errors);
        for (const auto& [kind, of] : errors)
          for (const double error_s : of.s) EXPECT_LE(std::abs(error_s), by_foot ? 0.040 : 0.060) << ToString(kind);
      }
}

// Another laboratory: fast walks in both directions, joint centres, 250 Hz. The left heels strike 136 and 155 mm before
// the edges of their plates, whose forces begin with the forefoot, so their heel strikes are not measured.
TEST(Walking, IsSeenAlikeInAnotherLaboratory) {
  const fs::path folder = SharedData() / "opensim_walk";
  if (!fs::exists(folder)) GTEST_SKIP() << "no recordings";
  struct Contact {
    const char* trial;
    char side;
    std::size_t plate;
  };
  std::map<StsEventKind, Errors> errors;
  for (const auto& [name, side, plate] :
       {Contact{"walking2.c3d", 'R', 0}, {"walking2.c3d", 'L', 1}, {"walking5.c3d", 'R', 1}, {"walking5.c3d", 'L', 0}})
    for (const bool by_foot : {true, false}) {
      const exchange::GroundForceRecording forces = exchange::ReadGroundForces(folder / name);
      const std::vector<Eigen::Vector3d>& force_n = forces.plates.at(plate).force_n;
      const auto is_loaded = [](const Eigen::Vector3d& force) { return force.z() > 20; };
      const auto first = std::ranges::find_if(force_n, is_loaded) - force_n.begin();
      const auto last = std::find_if(force_n.rbegin(), force_n.rend(), is_loaded).base() - force_n.begin();
      std::vector<PlateEvent> events = {{StsEventKind::kToeOff, forces.time_s[static_cast<std::size_t>(last)]}};
      if (side == 'R') events.push_back({StsEventKind::kHeelStrike, forces.time_s[static_cast<std::size_t>(first)]});
      const std::string names = fmt::format("ankle={0}AJC,knee={0}KJC,hip={0}HJC,waist={0}ASI+{0}PSI", side) +
                                (by_foot ? fmt::format(",heel={0}CAL,toe={0}MT2", side) : "");
      Compare(events, FitMovement(ReadWalk(folder / name, names)).events, errors);
    }
  for (const auto& [kind, of] : errors) EXPECT_LE(RootMeanSquare(of.s), 0.020) << ToString(kind);
}

class DrawnWalk : public testing::TestWithParam<DrawnWalkOptions> {};

// The toe's lowest place in a frame of the middle half of its swing, above where it stands; mm.
double DrawnToeClearance(const DrawnWalkOptions& drawn, const gait::GaitCycle& cycle) {
  const auto toe_mm = [&](double time_s) {
    return synth::DrawWalk(time_s / drawn.stride_s - 0.3, {drawn.stride_s, drawn.stride_mm, drawn.stance})
        .at("toe")
        .y();
  };
  const double strike_s = cycle.begin_s.value, off_s = strike_s + cycle.stance_s.value, swing_s = cycle.swing_s.value;
  double least_mm = std::numeric_limits<double>::infinity();
  for (double frame = std::ceil((off_s + 0.25 * swing_s) * drawn.rate_hz);
       frame <= (off_s + 0.75 * swing_s) * drawn.rate_hz; ++frame)
    least_mm = std::min(least_mm, toe_mm(frame / drawn.rate_hz));
  return least_mm - toe_mm((strike_s + off_s) / 2);
}

// The drawn foot stops at once, where a person's yields, and its heel goes on rising after toe-off: events are off by
// up to 4.5 % of the stride, alike in all strides; how well they are found in people the plates say. Strides are within
// 10 ms.
TEST_P(DrawnWalk, HasItsStrides) {
  const DrawnWalkOptions& drawn = GetParam();
  const gait::LegFitResult leg = FitMovement(DrawWalk(drawn));
  ASSERT_EQ(leg.movement.kind, gait::MovementKind::kWalking);
  const gait::Walk& walk = leg.movement.walk;
  EXPECT_EQ(walk.ground, drawn.is_treadmill ? gait::Ground::kTreadmill : gait::Ground::kOverground);
  EXPECT_THAT(walk.left_out, IsEmpty());
  for (const auto& [kind, at] : {std::pair(StsEventKind::kHeelStrike, 0.3),
                                 {StsEventKind::kToeOff, 0.3 + drawn.stance},
                                 {StsEventKind::kHeelStrikeOther, 0.8},
                                 {StsEventKind::kToeOffOther, 0.8 + drawn.stance}}) {
    const std::vector<double> times = StepTimes(leg.events, kind);
    const double strides = drawn.length_s / drawn.stride_s;
    EXPECT_NEAR(static_cast<double>(times.size()), strides, 1) << ToString(kind);
    for (const double time_s : times) {
      const double phase = time_s / drawn.stride_s - at;
      EXPECT_NEAR(phase - std::round(phase), 0, 0.045) << ToString(kind) << " at " << time_s;
    }
  }
  const gait::Measures<gait::GaitCycle> cycles = gait::MeasureGaitCycles(leg);
  ASSERT_EQ(static_cast<int>(cycles.rows.size()), walk.strides);
  EXPECT_EQ(walk.incomplete, 2);
  for (const gait::GaitCycle& cycle : cycles.rows) {
    EXPECT_NEAR(cycle.stride_s.value, drawn.stride_s, 0.010);
    EXPECT_NEAR(cycle.stance_percent.value, 100 * drawn.stance, 6);
    // Speed in the belt's frame or over the ground, to 2 %.
    EXPECT_NEAR(cycle.stride_length.value, drawn.stride_mm, 0.02 * drawn.stride_mm);
    EXPECT_NEAR(cycle.speed.value, drawn.stride_mm / drawn.stride_s, 0.03 * drawn.stride_mm / drawn.stride_s);
    EXPECT_NEAR(cycle.step_s.value, drawn.stride_s / 2, 0.015);
    EXPECT_NEAR(cycle.step_length.value, drawn.stride_mm / 2, 0.05 * drawn.stride_mm);
    EXPECT_NEAR(cycle.double_support_percent.value, 100 * (2 * drawn.stance - 1), 12);
    EXPECT_NEAR(cycle.toe_clearance.value, DrawnToeClearance(drawn, cycle), 1 + 3 * drawn.noise_mm);
  }
  int last = 0;
  for (const motion::LegSample& sample : leg.motion.samples)
    if (sample.repetition) {
      EXPECT_GE(*sample.repetition, last);
      last = *sample.repetition;
      EXPECT_TRUE(sample.percent >= 0 && sample.percent <= 100);
    }
  EXPECT_EQ(last, cycles.rows.back().repetition);
}

DrawnWalkOptions With(double rate_hz, double stride_s, double stride_mm, double direction, bool is_treadmill,
                      double noise_mm) {
  DrawnWalkOptions o;
  o.rate_hz = rate_hz;
  o.stride_s = stride_s;
  o.stride_mm = stride_mm;
  o.direction = direction;
  o.is_treadmill = is_treadmill;
  o.noise_mm = noise_mm;
  return o;
}

INSTANTIATE_TEST_SUITE_P(Paces, DrawnWalk,
                         testing::Values(With(100, 1.1, 1300, 1, false, 0.3), With(60, 0.9, 1500, -1, false, 1),
                                         With(30, 1.3, 1000, 1, false, 0.5), With(60, 1.1, 1300, 1, true, 1),
                                         With(120, 1.5, 800, -1, true, 0.3)));

TEST(Walking, BackwardAndRunningAreSaidAndGiveNoCycle) {
  DrawnWalkOptions backward = With(100, 1.1, 1300, 1, false, 0.3);
  backward.is_backward = true;
  const gait::LegFitResult back = FitMovement(DrawWalk(backward));
  EXPECT_THAT(back.events, IsEmpty());
  EXPECT_THAT(WarningsOf(back), HasSubstr("the person walks backward"));
  DrawnWalkOptions running = With(100, 0.7, 1600, 1, false, 0.3);
  running.stance = 0.36;
  const gait::LegFitResult run = FitMovement(DrawWalk(running));
  EXPECT_THAT(run.events, IsEmpty());
  EXPECT_THAT(WarningsOf(run), HasSubstr("the person runs"));
}

TEST(Walking, MovementsThatAreNoneHaveNoEventsOfIt) {
  if (!fs::exists(SharedData() / "real_motions")) GTEST_SKIP() << "no recordings";
  struct Other {
    const char *file, *names;
    std::optional<gait::MovementKind> kind;
  };
  const char* left = "ankle=LANK,knee=LKNE,hip=LASI+LPSI";
  for (const auto& [file, names, kind] :
       {Other{"real_motions/subject4_squats1.trc", kRightLeg, gait::MovementKind::kSquat},
        {"real_motions/tabs_squat2.trc", left, gait::MovementKind::kSquat},
        {"real_motions/tabs_stairs3.trc", left, std::nullopt},
        {"real_motions/subject4_DJ1.trc", kRightLeg, std::nullopt},
        {"real_motions/standing_static.trc", "ankle=r_ankle,knee=r_knee,hip=r_thigh1", std::nullopt},
        {"opencap_sts/sts_default_markers.trc", "ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=R_Shoulder",
         gait::MovementKind::kSitToStand},
        {"sts_force_plates/STS1.trc", kRightLeg, gait::MovementKind::kSitToStand}}) {
    const gait::LegFitResult leg = FitMovement(ReadWalk(SharedData() / file, names));
    EXPECT_EQ(leg.movement.kind, kind) << file;
    for (const motion::StsEvent& event : leg.events) EXPECT_LT(event.kind, StsEventKind::kHeelStrike) << file;
  }
}

// Slow, so that the hip comes less far in a swing: 8 s of it end in one.
TEST(Walking, NoStepOfASteadyWalkIsLeftOut) {
  DrawnWalkOptions drawn = With(100, 1.5, 1100, -1, false, 0.5);
  for (drawn.length_s = 7; drawn.length_s < 8.5; drawn.length_s += 0.25)
    EXPECT_THAT(FitMovement(DrawWalk(drawn)).movement.walk.left_out, IsEmpty()) << drawn.length_s;
}

TEST(Movement, IsTheOneAskedFor) {
  const motion::MarkerRecording walk = DrawWalk({});
  gait::MovementOptions options;
  options.kind = gait::MovementKind::kSitToStand;
  EXPECT_THAT(FitMovement(walk, {}, options).events, IsEmpty());
  options.kind = gait::MovementKind::kWalking;
  options.walking.ground = gait::Ground::kTreadmill;
  options.walking.belt_speed_mm_s = 500;
  const gait::LegFitResult leg = FitMovement(walk, {}, options);
  EXPECT_EQ(leg.movement.walk.ground, gait::Ground::kTreadmill);
  EXPECT_THAT(WarningsOf(leg), testing::Not(HasSubstr("belt")));
  options.walking.ground.reset();
  EXPECT_THAT(WarningsOf(FitMovement(walk, {}, options)), HasSubstr("the belt's speed is left out"));
  // As over the ground, and the belt in addition.
  EXPECT_NEAR(gait::MeasureGaitCycles(leg).mean.speed.value, 1300 / 1.1 + 500, 30);
}

TEST(GaitCycles, TableHasMeanAndSpread) {
  const gait::LegFitResult leg = FitMovement(DrawWalk({}));
  const gait::Measures<gait::GaitCycle> cycles = gait::MeasureGaitCycles(leg);
  const TemporaryFolder folder;
  gait::WriteMeasures(folder / "gait_cycles.csv", "stride", cycles, motion::LengthUnit::kMm);
  const CsvTable table = CsvTable::Read(folder / "gait_cycles.csv");
  ASSERT_EQ(table.Rows(), cycles.rows.size() + 2);
  EXPECT_EQ(table.Text(table.Rows() - 2, 0), "mean");
  EXPECT_EQ(table.Text(table.Rows() - 1, 0), "sd");
  EXPECT_EQ(table.Header().size(), 1 + 2 * gait::GaitCycle::Fields().size());
  EXPECT_NEAR(table.RequiredNumber(table.Rows() - 2, table.Column("stride_s")), 1.1, 0.01);
  motion::WriteEventsCsv(folder / "events.csv", leg.events);
  const std::vector<motion::StsEvent> read = motion::ReadEventsCsv(folder / "events.csv");
  ASSERT_EQ(read.size(), leg.events.size());
  EXPECT_EQ(read.back().sd_s, leg.events.back().sd_s);
}

// Small as they are of a drawn walk, no standard deviation is rounded to nothing, and values have their digits.
TEST(GaitCycles, AreToldWithTheDigitsOfTheirStandardDeviations) {
  DrawnWalkOptions drawn;
  drawn.noise_mm = 0.02;
  const std::string text =
      gait::MeasuresText(gait::MeasureGaitCycles(FitMovement(DrawWalk(drawn))), motion::LengthUnit::kMm);
  EXPECT_THAT(text, testing::StartsWith("means ± standard deviation of the mean:"));
  EXPECT_THAT(text, testing::ContainsRegex("stride_mm  [0-9]+[.][0-9]+ ± 0[.]0*[1-9]"));
  EXPECT_THAT(text, testing::Not(testing::ContainsRegex("± [0.]*\n")));
}

}  // namespace
}  // namespace lake
