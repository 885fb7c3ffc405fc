// The foot and the ankle: of drawn walks and rises whose angles are known, and of a person.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>

#include "drawn_walk.h"
#include "fitted_movement.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/statistics.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "name_map.h"
#include "places.h"
#include "synthetic_leg.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using motion::LegSample;
using testing::AllOf;
using testing::Ge;
using testing::HasSubstr;
using testing::Le;

// From lower to upper marker as drawn, x forward.
Eigen::Vector2d DrawnVector(const motion::MarkerRecording& drawn, const char* lower, const char* upper,
                            std::size_t frame, double direction) {
  const Eigen::Vector2d apart = drawn.Find(upper)->samples[frame].position - drawn.Find(lower)->samples[frame].position;
  return {direction * apart.x(), apart.y()};
}

struct AngleErrors {
  std::vector<double> deg, sds;
  void Add(double error_deg, double sd_deg) {
    deg.push_back(error_deg);
    sds.push_back(error_deg / sd_deg);
  }
};

class DrawnFootAngles : public testing::TestWithParam<DrawnWalkOptions> {};

// The drawn foot rests at 0, so its angle is its pitch. Heel and toe are 200 mm apart: a marker's 1 mm is 0.4° of a
// frame.
TEST_P(DrawnFootAngles, AreThoseDrawn) {
  AngleErrors foot, ankle;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    DrawnWalkOptions drawn = GetParam();
    drawn.seed = seed;
    const gait::LegFitResult leg = FitMovement(DrawWalk(drawn));
    drawn.noise_mm = 0;
    const motion::MarkerRecording truth = DrawWalk(drawn);
    for (std::size_t i = 0; i < leg.motion.samples.size(); ++i) {
      const LegSample& sample = leg.motion.samples[i];
      const Eigen::Vector2d sole = DrawnVector(truth, "heel", "toe", i, drawn.direction),
                            shank = DrawnVector(truth, "ankle", "knee", i, drawn.direction);
      const double foot_deg = DegreesFromRadians(std::atan2(sole.y(), sole.x())),
                   shank_deg = DegreesFromRadians(std::atan2(shank.x(), shank.y()));
      foot.Add(sample.foot_deg - foot_deg, sample.foot_sigma_deg);
      ankle.Add(sample.ankle_deg - shank_deg - foot_deg, sample.ankle_sigma_deg);
    }
  }
  for (const AngleErrors& errors : {foot, ankle}) {
    EXPECT_LT(RootMeanSquare(errors.deg), 0.45 * GetParam().noise_mm);
    EXPECT_THAT(RootMeanSquare(errors.sds), AllOf(Ge(0.6), Le(1.4)));
  }
}

DrawnWalkOptions WalkAt(double rate_hz, double direction, bool is_treadmill, double noise_mm) {
  DrawnWalkOptions o;
  o.rate_hz = rate_hz;
  o.direction = direction;
  o.is_treadmill = is_treadmill;
  o.noise_mm = noise_mm;
  return o;
}

INSTANTIATE_TEST_SUITE_P(Walks, DrawnFootAngles,
                         testing::Values(WalkAt(100, 1, false, 0.5), WalkAt(60, -1, false, 1), WalkAt(60, 1, true, 1)));

motion::MarkerRecording MarkedRise() {
  const SyntheticLeg leg = MakeSyntheticLeg({});
  return MakeTracks(leg.time_s, leg.points_mm, gait::MakeLegView(motion::LengthUnit::kMm, {}), {.sigma_px = 0.1}, 1);
}

// Markers of a foot that stays flat, the toe's lower than the heel's.
motion::MarkerRecording WithFoot(motion::MarkerRecording rise, double toe_mm) {
  motion::MarkerTrack heel{"heel", {}}, toe{"toe", {}};
  for (const motion::MarkerSample& ankle : rise.Find("ankle")->samples) {
    heel.samples.push_back({ankle.position + Eigen::Vector2d(-50, -40), ankle.sigma, ankle.status});
    toe.samples.push_back({ankle.position + Eigen::Vector2d(toe_mm, -60), ankle.sigma, ankle.status});
  }
  rise.markers.push_back(heel);
  rise.markers.push_back(toe);
  return rise;
}

TEST(Foot, OfARiseRestsOnTheGround) {
  const gait::LegFitResult fit = FitMovement(WithFoot(MarkedRise(), 150));
  for (const LegSample& sample : fit.motion.samples) {
    EXPECT_NEAR(sample.foot_deg, 0, 0.5);
    EXPECT_DOUBLE_EQ(sample.ankle_deg, sample.shank_deg + sample.foot_deg);
  }
  const TemporaryFolder folder;
  motion::WriteKinematicsCsv(folder / "kinematics.csv", fit.motion);
  const motion::LegMotion read = motion::ReadKinematicsCsv(folder / "kinematics.csv");
  for (const motion::Angle& angle : motion::Angles()) {
    EXPECT_EQ(read.samples.front().*angle.deg, fit.motion.samples.front().*angle.deg) << angle.name;
    EXPECT_EQ(read.samples.front().*angle.sigma_deg, fit.motion.samples.front().*angle.sigma_deg) << angle.name;
  }
}

TEST(Foot, HasNoColumnsWithoutItsMarkers) {
  const gait::LegFitResult fit = FitMovement(MarkedRise());
  const TemporaryFolder folder;
  motion::WriteKinematicsCsv(folder / "kinematics.csv", fit.motion);
  EXPECT_FALSE(CsvTable::Read(folder / "kinematics.csv").Has("foot_deg"));
  EXPECT_TRUE(std::isnan(motion::ReadKinematicsCsv(folder / "kinematics.csv").samples.front().foot_deg));
}

TEST(Foot, WithItsMarkersExchangedIsLeftOut) {
  const gait::LegFitResult fit = FitMovement(WithFoot(MarkedRise(), -250));
  EXPECT_THAT(WarningsOf(fit), HasSubstr("'toe' is behind 'heel' in most frames: exchange their names"));
  for (const LegSample& sample : fit.motion.samples)
    EXPECT_TRUE(std::isnan(sample.foot_deg) && std::isnan(sample.ankle_sigma_deg));
}

// Joint centres of a fast walk: the angle between shank and foot in space, less its mean, is the planar one's within
// 3°, as the foot turns outward. Usual walks have 7 to 16° of dorsiflexion and −10 to −30° (Perry & Burnfield 2010).
TEST(Foot, OfAPersonTurnsAsInSpace) {
  const fs::path file = SharedData() / "opensim_walk/walking2.c3d";
  if (!fs::exists(file)) GTEST_SKIP() << "no recordings";
  const auto names = NameMap("ankle=RAJC,knee=RKJC,hip=RHJC,waist=RASI+RPSI,heel=RCAL,toe=RMT2");
  const gait::LegFitResult leg = FitMovement(exchange::ReadTrial(file, {names, {}, ""}));
  const exchange::PointRecording points = exchange::RenamePoints(exchange::ReadPoints(file, {}), names, file);
  std::vector<double> difference_deg;
  double least_deg = 90, most_deg = -90;
  for (std::size_t i = 0; i < leg.motion.samples.size(); ++i) {
    const double ankle_deg = leg.motion.samples[i].ankle_deg;
    const Eigen::Vector3d shank = points.Find("knee")->positions[i] - points.Find("ankle")->positions[i],
                          foot = points.Find("toe")->positions[i] - points.Find("heel")->positions[i];
    const double between_deg = DegreesFromRadians(std::acos(shank.normalized().dot(foot.normalized())));
    if (!std::isfinite(ankle_deg) || !std::isfinite(between_deg)) continue;
    difference_deg.push_back(ankle_deg + between_deg);
    least_deg = std::min(least_deg, ankle_deg);
    most_deg = std::max(most_deg, ankle_deg);
  }
  ASSERT_GT(difference_deg.size(), 100u);
  EXPECT_LT(StandardDeviation(difference_deg), 3);
  EXPECT_THAT(most_deg, AllOf(Ge(7), Le(22)));
  EXPECT_THAT(least_deg, AllOf(Ge(-35), Le(-8)));
}

}  // namespace
}  // namespace lake
