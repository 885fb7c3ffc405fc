// Markers that are no person's leg are refused with what to do; every true trial passes.
#include "lake/gait/persons_leg.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <functional>

#include "fitted_movement.h"
#include "lake/exchange/trial.h"
#include "message_of.h"
#include "name_map.h"
#include "places.h"
#include "real_markers.h"
#include "synthetic_leg.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

#define REQUIRE_TRIAL(name) \
  if (!fs::exists(SharedData() / name)) GTEST_SKIP() << (SharedData() / name).string() << " is not here"

gait::LegFitResult Fit(const std::string& file, const std::string& names, char up, const std::string& forward = "") {
  const exchange::Trial trial = exchange::ReadTrial(SharedData() / file, {NameMap(names), up, forward});
  gait::LegFitOptions options;
  if (trial.faces_right) options.facing = *trial.faces_right ? motion::Facing::kRight : motion::Facing::kLeft;
  return FitTrial(trial, options);
}

struct TrueTrial {
  const char *file, *names;
  char up = 'y';
};

class TrueTrials : public testing::TestWithParam<TrueTrial> {};

TEST_P(TrueTrials, AreAPersonsLeg) {
  REQUIRE_TRIAL(GetParam().file);
  gait::LegFitResult result;
  ASSERT_NO_THROW(result = Fit(GetParam().file, GetParam().names, GetParam().up));
  for (const std::string& warning : result.warnings) EXPECT_THAT(warning, Not(HasSubstr("of the other leg")));
}

INSTANTIATE_TEST_SUITE_P(
    , TrueTrials,
    testing::Values(TrueTrial{"sts_force_plates/STS1.trc", kRightLeg}, TrueTrial{"sts_force_plates/STS1.trc", kLeftLeg},
                    TrueTrial{"opencap_sts/sts_default_markers.trc", kRightLeg},
                    TrueTrial{"opencap_sts/sts_default_markers.trc", kLeftLeg},
                    TrueTrial{"real_motions/subject4_squats1.trc", kRightLeg},
                    TrueTrial{"real_motions/subject4_squats1.trc", kLeftLeg},
                    TrueTrial{"real_motions/subject4_walking1.trc", kRightLeg},
                    TrueTrial{"real_motions/subject4_walking1.trc", kLeftLeg},
                    TrueTrial{"real_motions/subject4_DJ1.trc", kRightLeg},
                    TrueTrial{"real_motions/subject4_DJ1.trc", kLeftLeg},
                    TrueTrial{"real_motions/tabs_squat2.trc", "ankle=RANK,knee=RKNE,hip=RASI+RPSI"},
                    TrueTrial{"real_motions/tabs_squat2.trc", "ankle=LANK,knee=LKNE,hip=LASI+LPSI"},
                    TrueTrial{"real_motions/tabs_stairs3.trc", "ankle=RANK,knee=RKNE,hip=RASI+RPSI"},
                    TrueTrial{"real_motions/tabs_stairs3.trc", "ankle=LANK,knee=LKNE,hip=LASI+LPSI"},
                    TrueTrial{"real_motions/gait_200hz.trc", "ankle=RxLatMal,knee=RxLatCon,hip=RxThigh"},
                    TrueTrial{"real_motions/gait_200hz.trc", "ankle=LxLatMal,knee=LxLatCon,hip=LxThigh"},
                    TrueTrial{"real_motions/standing_static.trc", "ankle=r_ankle,knee=r_knee,hip=r_thigh1"},
                    TrueTrial{"real_motions/standing_static.trc", kLeftLeg},
                    TrueTrial{"opensim_walk/std_walking2_markers.trc", "ankle=LAJC,knee=LKJC,hip=LHJC,waist=LASI+LPSI",
                              'z'},
                    TrueTrial{"opensim_walk/std_walking5_markers.trc", "ankle=RAJC,knee=RKJC,hip=RHJC", 'z'}));

struct WrongTrial {
  const char *names, *message, *forward = "";
};

class WrongTrials : public testing::TestWithParam<WrongTrial> {};

TEST_P(WrongTrials, AreRefusedWithWhatToDo) {
  for (const char* file : {"sts_force_plates/STS1.trc", "opencap_sts/sts_default_markers.trc"}) {
    REQUIRE_TRIAL(file);
    EXPECT_THAT(MessageOf([&] { Fit(file, GetParam().names, 'y', GetParam().forward); }), HasSubstr(GetParam().message))
        << file;
  }
}

INSTANTIATE_TEST_SUITE_P(
    , WrongTrials,
    testing::Values(
        WrongTrial{"ankle=r_ankle,knee=L_knee,hip=R_HJC,waist=r.ASIS+r.PSIS", "is 'knee' of the other leg?"},
        WrongTrial{"ankle=L_ankle,knee=r_knee,hip=L_HJC", "is 'knee' of the other leg?"},
        WrongTrial{"ankle=L_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS", "is 'ankle' of the other leg?"},
        WrongTrial{"ankle=r_knee,knee=R_HJC,hip=r.ASIS+r.PSIS,waist=R_Shoulder", "names"},
        WrongTrial{"ankle=r_knee,knee=R_HJC,hip=R_Shoulder", "a segment too high"},
        WrongTrial{"ankle=r_toe,knee=r_ankle,hip=r_knee,waist=R_HJC", "names right"},
        WrongTrial{"ankle=r_ankle,knee=r_knee,hip=r.ASIS+r.PSIS,waist=R_HJC", "are hip and waist exchanged"},
        WrongTrial{"ankle=r_ankle,knee=R_HJC,hip=r_knee,waist=r.ASIS+r.PSIS", "are knee and hip exchanged"},
        WrongTrial{"ankle=r_knee,knee=r_ankle,hip=R_HJC,waist=r.ASIS+r.PSIS", "are ankle and knee exchanged"},
        WrongTrial{"ankle=R_HJC,knee=r_knee,hip=r_ankle,waist=r.ASIS+r.PSIS", "are ankle and hip exchanged"},
        WrongTrial{kRightLeg, "the knee bends backward", "-x"},
        WrongTrial{kLeftLeg, "or --facing right is wrong", "-x"}));

TEST(PersonsLeg, AFacingThatIsWrongIsNamedInThePlane) {
  const SyntheticLeg leg = MakeSyntheticLeg({.repetitions = 1});
  const motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {}, 9);
  gait::LegFitOptions options;
  options.facing = motion::Facing::kLeft;
  for (const char* said : {"--facing left", "--forward"}) {
    if (said != std::string("--facing left")) options.said_facing = said;
    EXPECT_THAT(MessageOf([&] { gait::FitLeg(tracks, ScaledView(), options); }),
                AllOf(HasSubstr("the knee angle is -10"), HasSubstr(fmt::format("or {} is wrong", said))));
  }
}

TEST(PersonsLeg, AUnitThatIsNotMmIsAskedAboutBeforeTheFit) {
  const SyntheticLeg leg = MakeSyntheticLeg({.repetitions = 1});
  for (const auto& [mm_per_unit, unit] : {std::pair{1000.0, "m"}, {10.0, "cm"}}) {
    gait::LegView view = ScaledView();
    const motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, view, {}, 9);
    view.mm_per_px = *view.mm_per_px / mm_per_unit;
    gait::LegFitOptions options;
    options.unit_question = [](const std::string& fits) { return "asked about " + fits; };
    EXPECT_THAT(MessageOf([&] { gait::FitLeg(tracks, view, options); }),
                AllOf(HasSubstr("the shank is"), HasSubstr(std::string("asked about ") + unit)));
  }
}

// As a folder holds it, without the recording.
TEST(PersonsLeg, AMotionWhoseTrunkFallsBackwardOrWhoseShankLiesIsRefused) {
  const SyntheticLeg leg = MakeSyntheticLeg({.repetitions = 2});
  const gait::LegFitResult good =
      gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {}, 9), ScaledView());
  ASSERT_FALSE(good.events.empty());
  EXPECT_NO_THROW(gait::CheckPersonsLeg(gait::PathOf(good.motion), good.events, {}));
  const auto refused = [&](const std::function<void(motion::LegSample&)>& change, const std::string& message) {
    motion::LegMotion motion = good.motion;
    for (motion::LegSample& sample : motion.samples) change(sample);
    EXPECT_THAT(MessageOf([&] { gait::CheckPersonsLeg(gait::PathOf(motion), good.events, {}); }), HasSubstr(message));
  };
  const auto turned = [](const Eigen::Vector2d& v, double deg) {
    return Eigen::Vector2d(Eigen::Rotation2Dd(-RadiansFromDegrees(deg)) * v);
  };
  refused([](motion::LegSample& s) { s.hw.x() *= -2; }, "the trunk leans backward");
  refused([&](motion::LegSample& s) { s.ak = turned(s.ak, -80); }, "a shank by 60° at most");
  refused([](motion::LegSample& s) { s.kh = {-404, 71}; }, "in standing");  // leans back by 80° all the time
  refused([](motion::LegSample& s) { s.hw *= -1; }, "'waist' lies below 'hip'");
  refused([](motion::LegSample& s) { s.kh *= 5; }, "the thigh is");
}

}  // namespace
}  // namespace lake
