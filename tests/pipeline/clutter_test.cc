// Rooms as laboratories have them: lamps and reflections, a subject who walks in, a second person.
#include <gmock/gmock.h>

#include "lake/core/error.h"
#include "lake/synth/staging.h"
#include "lake/synth/sts_motion.h"
#include "pipeline/rendered_trial.h"

namespace lake {
namespace {

synth::SceneOptions Cluttered(std::uint64_t seed) {
  synth::SceneOptions scene = synth::CleanScene(seed);
  scene.reflections = 60;
  scene.glint = true;
  scene.motion.start_standing = true;
  // The camera looks at the chair, not at the way to it.
  scene.camera = synth::Scene(scene).Profile();
  return scene;
}

TEST(ClutteredRoom, SubjectWhoWalksInIsNamed) {
  const std::uint64_t seed = 35218;
  synth::SceneOptions scene = Cluttered(seed);
  scene.duration_s = 7.5;
  RenderedTrial trial(synth::Scene(scene, synth::MakeWalkIn(std::make_shared<synth::StsMotion>(scene.motion), 2.5)),
                      {.crf = 20});
  trial.Track();
  const TrackErrors errors = CompareTracks(trial.Tracks(), trial);
  Print("walks in", seed, errors, {});
  EXPECT_LE(errors.worst_px, 1);
  EXPECT_EQ(errors.false_samples, 0) << "something was taken for a marker that is not in the picture";
  EXPECT_GE(errors.recall, 0.9);
}

TEST(ClutteredRoom, TwoWhoStandUpAreAQuestion) {
  const std::uint64_t seed = 95522;
  synth::SceneOptions scene = Cluttered(seed);
  scene.duration_s = 4;
  synth::StsMotionOptions other = scene.motion;
  other.seed = seed + 1;
  RenderedTrial trial(synth::Scene(scene, synth::MakeTwoPeople(std::make_shared<synth::StsMotion>(scene.motion),
                                                               std::make_shared<synth::StsMotion>(other), -450)),
                      {.crf = 20});
  EXPECT_THAT([&] { trial.Track(); }, testing::ThrowsMessage<Error>(testing::AllOf(
                                          testing::HasSubstr("--seed"), testing::HasSubstr("candidates.png"))));
  EXPECT_TRUE(std::filesystem::exists(trial.folder / "trial" / "candidates.csv"));
}

}  // namespace
}  // namespace lake
