// The joint misalignment of a walk: it depends neither on the speed of walking nor on its direction.
#include <gmock/gmock.h>

#include <filesystem>

#include "gait/drawn_walk.h"
#include "gait/fitted_movement.h"
#include "gait/worn_joint_marker.h"
#include "lake/compare/comparison_file.h"
#include "lake/compare/misalignment.h"
#include "lake/core/error.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "name_map.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

compare::TrialTables FitWalk(const motion::MarkerRecording& recording, const gait::LateralPlaces& lateral_mm = {}) {
  const gait::LegFitResult leg = FitMovement(recording, lateral_mm);
  return {"walk", leg.trajectory, leg.motion, leg.events};
}

compare::RegisteredTrial RegisterWalk(const compare::TrialTables& tables, const char* knee) {
  compare::RegistrationOptions options;
  options.knee = knee;
  return compare::RegisterTrial(tables, options);
}

const Eigen::Vector2d kJointOffset_mm(9, -7.93725);  // 12 mm

void ExpectTheOffset(const compare::Misalignment& m) {
  EXPECT_EQ(m.movement, gait::MovementKind::kWalking);
  ASSERT_TRUE(m.joint);
  EXPECT_NEAR(m.joint->rms_mm, 12, 0.5);
  EXPECT_LT((m.joint->mean_mm - kJointOffset_mm).norm(), 0.5) << m.joint->mean_mm.transpose();
  // Paths are relative to the hip.
  for (const compare::StsCurve* curve : {&m.human, &m.exo})
    for (const Eigen::Vector2d& hip : curve->hip) EXPECT_LT(hip.norm(), 1e-6);
}

struct WornPace {
  const char* name;
  double stride_s, stride_mm, direction;
  bool is_treadmill;
};

class WalkingComparison : public testing::TestWithParam<WornPace> {};

TEST_P(WalkingComparison, FindsTheJointAtAnySpeedAndDirection) {
  const WornPace& worn = GetParam();
  DrawnWalkOptions drawn;
  drawn.noise_mm = 0.5;
  const compare::RegisteredTrial human = RegisterWalk(FitWalk(DrawWalk(drawn)), "knee");
  drawn.stride_s = worn.stride_s;
  drawn.stride_mm = worn.stride_mm;
  drawn.direction = worn.direction;
  drawn.is_treadmill = worn.is_treadmill;
  drawn.length_s = 5 * worn.stride_s;
  drawn.seed = 2;
  motion::MarkerRecording recording = DrawWalk(drawn);
  AddWornJoint(kJointOffset_mm, worn.direction, recording, drawn.noise_mm);
  const compare::RegisteredTrial exo = RegisterWalk(FitWalk(recording), "exo_knee");
  EXPECT_GE(exo.repetitions.size(), 3U);
  for (const compare::StsCurve& stride : exo.repetitions) EXPECT_NEAR(stride.duration_s, worn.stride_s, 0.02);
  const compare::Misalignment m = compare::CompareTrials(human, exo);
  ExpectTheOffset(m);
  // The knee comes before the hip as the leg is swung, whatever the direction of walking.
  double foremost_mm = 0;
  for (const Eigen::Vector2d& knee : m.human.knee) foremost_mm = std::max(foremost_mm, knee.x());
  EXPECT_GT(foremost_mm, 150);
  // Strides of one length differ in nothing but the joint; 2 mm are events that are off by a percent or two.
  if (worn.stride_mm == DrawnWalkOptions().stride_mm) {
    EXPECT_NEAR(m.metrics.rms_mm, 12, 2);
  }
}

INSTANTIATE_TEST_SUITE_P(All, WalkingComparison,
                         testing::Values(WornPace{"Alike", 1.1, 1300, 1, false},
                                         WornPace{"Slower", 1.6, 1000, 1, false},
                                         WornPace{"FasterAndBack", 0.95, 1450, -1, false},
                                         WornPace{"SlowerAndBack", 1.5, 1300, -1, false},
                                         WornPace{"OnATreadmill", 1.3, 1200, 1, true}),
                         [](const auto& info) { return info.param.name; });

// Joint centres of one person in two walks, one to either side, each with one whole stride of the left leg; the second
// also half as fast.
TEST(WalkingComparisonOfPeople, FindsTheJoint) {
  const fs::path folder = SharedData() / "opensim_walk";
  if (!fs::exists(folder)) GTEST_SKIP() << "no recordings";
  const auto read = [&](const char* file) {
    exchange::TrialOptions options;
    options.names = NameMap("ankle=LAJC,knee=LKJC,hip=LHJC,waist=LASI+LPSI,heel=LCAL,toe=LMT2");
    return exchange::ReadTrial(folder / file, options);
  };
  const exchange::Trial without = read("walking2.c3d");
  exchange::Trial with = read("walking5.c3d");
  const motion::Facing facing = FitWalk(with.recording, with.lateral_mm).motion.facing;
  EXPECT_NE(facing, FitWalk(without.recording, without.lateral_mm).motion.facing);
  AddWornJoint(kJointOffset_mm, facing == motion::Facing::kRight ? 1 : -1, with.recording, 0.5);
  const compare::RegisteredTrial human = RegisterWalk(FitWalk(without.recording, without.lateral_mm), "knee");
  for (const double slower : {1.0, 2.0}) {
    SCOPED_TRACE(slower);
    motion::MarkerRecording worn = with.recording;
    for (double& time_s : worn.time_s) time_s *= slower;
    const compare::RegisteredTrial exo = RegisterWalk(FitWalk(worn, with.lateral_mm), "exo_knee");
    EXPECT_NEAR(exo.repetitions.front().duration_s, 0.98 * slower, 0.05 * slower);
    ExpectTheOffset(compare::CompareTrials(human, exo));
  }
}

TEST(WalkingComparisonFiles, SayTheMovement) {
  motion::MarkerRecording recording = DrawWalk({});
  const compare::RegisteredTrial human = RegisterWalk(FitWalk(recording), "knee");
  AddWornJoint(kJointOffset_mm, 1, recording);
  compare::RegisteredTrial exo = RegisterWalk(FitWalk(recording), "exo_knee");
  const Json json = compare::ComparisonJson(compare::CompareTrials(human, exo));
  EXPECT_EQ(json["movement"], "walking");
  EXPECT_FALSE(json["pace"].contains("phases"));
  const TemporaryFolder folder;
  WriteJsonFile(folder / "comparison.json", json);
  EXPECT_EQ(compare::ReadComparison(folder.Path()).movement, gait::MovementKind::kWalking);
  EXPECT_THAT([&] { compare::ReadComparisonOfRises(folder.Path()); },
              ThrowsMessage<Error>(HasSubstr("it is of walking, and a linkage is designed for sit-to-stands")));
  exo.movement = gait::MovementKind::kSitToStand;
  EXPECT_THAT([&] { compare::CompareTrials(human, exo); },
              ThrowsMessage<Error>(HasSubstr("of walking and the exoskeleton trial of sit-to-stand")));
}

TEST(WalkingComparisonFiles, NeedAWholeStride) {
  compare::TrialTables tables = FitWalk(DrawWalk({}));
  std::erase_if(tables.events, [](const motion::StsEvent& event) { return event.repetition > 1; });
  EXPECT_THAT([&] { RegisterWalk(tables, "knee"); }, ThrowsMessage<Error>(HasSubstr("no stride is whole")));
  tables.events = {{.repetition = 1, .kind = motion::StsEventKind::kDescent, .time_s = 1},
                   {.repetition = 1, .kind = motion::StsEventKind::kBottom, .time_s = 2},
                   {.repetition = 1, .kind = motion::StsEventKind::kStanding, .time_s = 3}};
  EXPECT_THAT([&] { RegisterWalk(tables, "knee"); }, ThrowsMessage<Error>(HasSubstr("it is of squats")));
}

}  // namespace
}  // namespace lake
