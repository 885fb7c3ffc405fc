// Messages name options; who wrote a study file is told its keys.
#include <gtest/gtest.h>

#include "lake/commands/track.h"
#include "lake/steps/study_steps.h"
#include "lake/study/study.h"

namespace lake {
namespace {

std::string InTrial(const std::string& message) {
  commands::TrackRunOptions options;
  return steps::InStudyFile(message, steps::KeysOf(OptionsOf(options)));
}

TEST(StudyKeys, StandBesideTheOptionsOfAMessage) {
  EXPECT_EQ(InTrial("marker 'exo_knee' cannot be found by itself; say where it is with --seed exo_knee=X,Y (seen: 3)"),
            " (in the study file: seeds: [\"exo_knee=X,Y\"])");
  EXPECT_EQ(InTrial("say which, for example --seed knee=1,2@3 --seed hip=4,5@6."),
            " (in the study file: seeds: [\"knee=1,2@3\", \"hip=4,5@6\"])");
  EXPECT_EQ(InTrial("turned by 180° clockwise, a leg stands upright: --rotate 180"),
            " (in the study file: rotate: 180)");
  EXPECT_EQ(InTrial("give it with --scale, or --camera"), " (in the study file: camera, scale)");
  EXPECT_EQ(InTrial("--seeds and --seed-number are of another program"), "");
  EXPECT_EQ(InTrial("the video cannot be opened"), "");
}

TEST(StudyText, SaysWhatWasDone) {
  EXPECT_EQ(study::StudyText({{.name = "human", .done = true, .why = "not made yet", .seconds = 12.4},
                              {.name = "exo", .done = false, .seconds = 12.4}}),
            "human          12.4 s  done\nexo            12.4 s  unchanged\n");
}

}  // namespace
}  // namespace lake
