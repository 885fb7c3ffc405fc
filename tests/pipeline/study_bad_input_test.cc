// Studies that cannot be: each ends with one line that names the step, and what was finished stays.
#include <gmock/gmock.h>

#include "lake/core/error.h"
#include "pipeline/study_trials.h"
#include "places.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

class BadStudy : public testing::Test {
 protected:
  void ExpectFailure(const std::string& step, const std::string& message) {
    EXPECT_THAT([&] { study_.Go(); }, ThrowsMessage<Error>(AllOf(HasSubstr("step " + step + " ("), HasSubstr(message),
                                                                 Not(HasSubstr("\n")))));
    EXPECT_TRUE(fs::is_regular_file(study_.Out() / "human/summary.json"));
    EXPECT_FALSE(fs::exists(study_.Out() / "report.html"));
    EXPECT_FALSE(fs::exists(study_.Out() / "comparison/comparison.json"));
  }

  // Before the first step.
  void ExpectRefusal(const std::string& key, const std::string& message) {
    EXPECT_THAT([&] { study_.Go(); },
                ThrowsMessage<Error>(AllOf(HasSubstr("study.yaml: " + key), HasSubstr(message), Not(HasSubstr("\n")))));
    EXPECT_FALSE(fs::exists(study_.Out() / "human"));
  }

  motion::MarkerRecording Exo(double end_s = INFINITY) {
    return RecordingOf(synth::StsMotion(ExoMotionOptions()), 2, end_s);
  }

  StudyFolder study_;
};

TEST_F(BadStudy, WithoutACommonMarker) {
  study_.WriteStudy(std::string(kNoAnimation) + "compare: {exo_knee: joint}\n");
  ExpectFailure("comparison", "no marker 'joint'");
}

// The markers of the leg are there, but the subject only sits, or the trial ends on the way up.
TEST_F(BadStudy, WithoutARepetition) {
  const synth::StsPhase rise = synth::StsMotion(ExoMotionOptions()).Phases()[1];
  study_.WriteTrial("exo.csv", Exo(rise.start_s));
  ExpectFailure("comparison", "no sit-to-stand found");
  study_.WriteTrial("exo.csv", Exo(rise.start_s + 0.6 * (rise.end_s - rise.start_s)));
  ExpectFailure("comparison", "exo");
}

TEST_F(BadStudy, WithTrialsInDifferentUnits) {
  motion::MarkerRecording exo = Exo();
  exo.unit = motion::LengthUnit::kPx;
  // Image rows grow downward.
  for (motion::MarkerTrack& marker : exo.markers)
    for (motion::MarkerSample& sample : marker.samples) sample.position.y() = 1000 - sample.position.y();
  study_.WriteTrial("exo.csv", exo);
  ExpectFailure("comparison", "is in mm and");
}

TEST_F(BadStudy, WithAFileThatIsNoTrial) {
  WriteTextFile(study_.Folder() / "exo.csv", "frame,time_s\n");
  ExpectRefusal("'exo'", "exo.csv");
}

// What a step could not read is refused before the first step, whose tracking may take minutes.
TEST_F(BadStudy, WithFilesUnderTheWrongKeys) {
  const fs::path sample = SourceDir() / "data/sts-study";
  fs::copy_file(sample / "camera.yaml", study_.Folder() / "camera.yaml");
  fs::copy_file(sample / "worn.yaml", study_.Folder() / "worn.yaml");
  study_.WriteStudy("design: {worn: camera.yaml}\n");
  ExpectRefusal("'worn'", "camera.yaml");
  study_.WriteStudy("camera: worn.yaml\n");
  ExpectRefusal("'camera'", "worn.yaml");
  study_.WriteStudy("stroke: {duty_table: worn.yaml}\n");
  ExpectRefusal("'duty_table'", "worn.yaml");
  study_.WriteStudy("simulate: {torques: camera.yaml}\n");
  ExpectRefusal("'torques'", "camera.yaml");
}

// What an older version of lake left is made again, whatever its content says.
TEST_F(BadStudy, WithAnOlderComparisonIsDoneAgain) {
  study_.Go();
  const fs::path stamp = study_.Out() / "comparison/.comparison.lake-step.json";
  Json json = ReadJsonFile(stamp);
  json["maker"] = "lake 0.0.1";
  WriteJsonFile(stamp, json);
  const Json summary = study_.Go();
  EXPECT_THAT(study_.Done(summary), testing::Contains("comparison"));
  EXPECT_THAT(study_.Done(summary), Not(testing::Contains("human")));
}

// A step's folder is emptied before the step begins: what the study reads would be gone.
TEST_F(BadStudy, WithAnInputAmongItsOwnResults) {
  study_.Go();
  WriteTextFile(study_.Folder() / "study.yaml", "name: Quick\nhuman: {trial: out/human/trajectory.csv}\n");
  const std::string before = ReadTextFile(study_.Out() / "human/trajectory.csv");
  EXPECT_THAT([&] { study_.Go(); },
              ThrowsMessage<Error>(AllOf(HasSubstr("study.yaml:2"), HasSubstr("among the study's own results"))));
  EXPECT_EQ(ReadTextFile(study_.Out() / "human/trajectory.csv"), before);
  EXPECT_TRUE(fs::exists(study_.Out() / "exo/trajectory.csv"));
}

TEST_F(BadStudy, WithMissingFilesNamesThemAll) {
  fs::remove(study_.Folder() / "human.csv");
  fs::remove(study_.Folder() / "exo.csv");
  EXPECT_THAT([&] { study_.Go(); }, ThrowsMessage<Error>(AllOf(HasSubstr("2 files are missing"), HasSubstr("human.csv"),
                                                               HasSubstr("exo.csv"))));
  EXPECT_FALSE(fs::exists(study_.Out()));
}

}  // namespace
}  // namespace lake
