// How a cohort lies in its folder, and what its file says of each person.
#include "lake/cohort/cohort_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using cohort::ReadCohort;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

class CohortFile : public testing::Test {
 protected:
  CohortFile() {
    Write("participants.tsv",
          "participant_id\tmass_kg\theight_mm\nsub-01\t70\t1750\nsub-02\tn/a\t1680\nsub-03\t81\tn/a\n");
    for (const char* file :
         {"sub-01/ses-1/human.mp4", "sub-01/ses-2/run-1/human.mp4", "sub-01/ses-2/run-2/human.mp4", "sub-02/human.mp4"})
      Write(std::string("sourcedata/") + file, "");
    WriteYaml("");
  }

  void Write(const std::string& name, const std::string& text) {
    fs::create_directories((folder_ / name).parent_path());
    WriteTextFile(folder_ / name, text);
  }

  void WriteYaml(const std::string& rest) {
    Write("cohort.yaml",
          "study:\n  human: {video: human.mp4, end_s: 4}\n  camera: $cohort/camera.yaml\n"
          "  simulate: {mass_kg: $mass_kg}\n" +
              rest);
  }

  void ExpectRefused(const std::string& what) {
    EXPECT_THAT([&] { ReadCohort(folder_.Path()); }, ThrowsMessage<Error>(HasSubstr(what)));
  }

  TemporaryFolder folder_;
};

TEST_F(CohortFile, FindsRecordingsBySessionAndRun) {
  const cohort::Cohort cohort = ReadCohort(folder_.Path());
  std::vector<std::string> names, folders;
  for (const cohort::Recordings& of : cohort.recordings) names.push_back(of.Name()), folders.push_back(of.Folder());
  EXPECT_THAT(names, ElementsAre("sub-01_ses-1", "sub-01_ses-2_run-1", "sub-01_ses-2_run-2", "sub-02"));
  EXPECT_THAT(folders, ElementsAre("sub-01/ses-1", "sub-01/ses-2/run-1", "sub-01/ses-2/run-2", "sub-02"));
  EXPECT_THAT(cohort.absent, ElementsAre("sub-03"));
  EXPECT_EQ(ReadCohort(folder_.Path(), {"02"}).recordings.size(), 1u);
  EXPECT_EQ(ReadCohort(folder_.Path(), {"sub-02", "01"}).recordings.size(), 4u);
  EXPECT_THROW(ReadCohort(folder_.Path(), {"04"}), UsageError);
}

TEST_F(CohortFile, PutsInWhatIsKnownOfThePerson) {
  const cohort::Cohort cohort = ReadCohort(folder_.Path());
  EXPECT_EQ(cohort.recordings[0].study["simulate"]["mass_kg"], "70");
  EXPECT_EQ(cohort.recordings[0].study["camera"], "../../../camera.yaml") << "from its own recordings";
  EXPECT_EQ(cohort.recordings[1].study["camera"], "../../../../camera.yaml");
  EXPECT_FALSE(cohort.recordings[3].study["simulate"].contains("mass_kg")) << "n/a";
}

TEST_F(CohortFile, SaysWhatIsDifferentForOne) {
  WriteYaml(
      "people:\n  sub-01_ses-2_run-2: {human: {end_s: 9}}\n"
      "  sub-01: {human: {end_s: 5, start_s: 1}, simulate: ~}\n");
  const cohort::Cohort cohort = ReadCohort(folder_.Path());
  EXPECT_EQ(cohort.recordings[0].study["human"],
            (Json{{"end_s", 5.0}, {"video", "human.mp4"}, {"start_s", 1.0}, {"anonymise", true}}));
  EXPECT_EQ(cohort.recordings[2].study["human"]["end_s"], 9.0) << "the recording's own counts most";
  EXPECT_EQ(cohort.recordings[2].study["human"]["start_s"], 1.0);
  EXPECT_FALSE(cohort.recordings[0].study.contains("simulate"));
  EXPECT_EQ(cohort.recordings[3].study["human"]["end_s"], 4.0);
}

TEST_F(CohortFile, TakesAnotherMovementInAllStudies) {
  WriteYaml("  exo: {trial: exo.trc, movement: squat}\n");
  cohort::Cohort cohort = ReadCohort(folder_.Path());
  cohort::SetMovement(gait::MovementKind::kWalking, cohort);
  for (const cohort::Recordings& of : cohort.recordings) {
    for (const char* trial : {"human", "exo"}) EXPECT_EQ(of.study[trial]["movement"], "walking");
    EXPECT_FALSE(of.study.contains("compare"));
  }
}

TEST_F(CohortFile, BlursHeadsUnlessToldOtherwise) {
  WriteYaml(
      "  exo: {video: exo.mp4, markers: [ankle, knee, hip, shoulder, exo_knee]}\n"
      "people:\n  sub-02: {human: {anonymise: false}}\n");
  const cohort::Cohort cohort = ReadCohort(folder_.Path());
  EXPECT_EQ(cohort.recordings[0].study["human"]["anonymise"], true);
  EXPECT_EQ(cohort.recordings[0].study["exo"]["anonymise"], true);
  EXPECT_EQ(cohort.recordings[3].study["human"]["anonymise"], "false");
  WriteYaml("  exo: {trial: exo.trc}\n");
  EXPECT_FALSE(ReadCohort(folder_.Path()).recordings[0].study["exo"].contains("anonymise")) << "no pictures";
  for (const char* markers : {"[ankle, knee, hip]", "[ankle, knee, hip, exo_waist]", "'ankle,knee,hip'"}) {
    WriteYaml(fmt::format("  exo: {{video: exo.mp4, markers: {}}}\n", markers));
    ExpectRefused("'exo' has neither waist nor shoulder");
  }
  WriteYaml("  exo: {video: exo.mp4, markers: 'ankle,knee,hip,waist'}\n");
  EXPECT_EQ(ReadCohort(folder_.Path()).recordings[0].study["exo"]["anonymise"], true);
}

TEST_F(CohortFile, RefusesWhatCannotBe) {
  WriteYaml("peple: {}\n");
  ExpectRefused("cohort.yaml:5: unknown key 'peple'");
  WriteYaml("people: {sub-09: {}}\n");
  ExpectRefused("no recordings of 'sub-09'");
  WriteYaml("  reoptimize: {problem: $seat}\n");
  ExpectRefused("$seat: no such column");
  WriteYaml("  name: of $mass_kg kg\n");
  ExpectRefused("sub-02 has no mass_kg");
  Write("cohort.yaml", "name: nothing\n");
  ExpectRefused("'study' is missing");
  WriteYaml("task: sit to stand\n");
  ExpectRefused("'task' must be letters and digits");
  WriteYaml("");
  Write("sourcedata/sub-7/human.mp4", "");
  ExpectRefused("sub-7 is not in participants.tsv");
  fs::remove_all(folder_ / "sourcedata/sub-7");
  Write("sourcedata/sub-02/ses-a_b/human.mp4", "");
  ExpectRefused("only letters and digits may follow");
  fs::remove_all(folder_ / "sourcedata/sub-02/ses-a_b");
  Write("sourcedata/sub-02/run-one/human.mp4", "");
  ExpectRefused("sub-02/run-one: a run has a number, as run-1");
}

TEST_F(CohortFile, RefusesTablesOfNobodyOrOfOneTwice) {
  Write("participants.tsv", "participant_id\nsub-01\nsub-02\nsub-01\n");
  ExpectRefused("participants.tsv:4: sub-01 stands twice");
  Write("participants.tsv", "participant_id\nsub_01\n");
  ExpectRefused("'sub_01' must be sub- and a label");
  Write("participants.tsv", "name\nsub-01\n");
  ExpectRefused("the first column must be participant_id");
}

// Heights in metres or centimetres, words, and what a spreadsheet leaves.
TEST_F(CohortFile, RefusesNumbersThatNobodyHas) {
  for (const char* height : {"1.75", "175", "-1750", "nan", "inf", "1,750", "1750 mm", "tall"}) {
    Write("participants.tsv", fmt::format("participant_id\theight_mm\nsub-01\tn/a\nsub-02\t{}\n", height));
    ExpectRefused(
        fmt::format("participants.tsv:3: height_mm of sub-02: '{}' is not a number from 500 to 2750", height));
  }
  Write("participants.tsv", "participant_id\tmass_kg\nsub-01\t70000\nsub-02\t\n");
  ExpectRefused("participants.tsv:2: mass_kg of sub-01: '70000' is not a number from 10 to 650");
  Write("participants.tsv", "participant_id\tseat_height_mm\nsub-01\t45\nsub-02\t450\n");
  ExpectRefused("seat_height_mm of sub-01: '45'");
}

// As Excel and Windows write it.
TEST_F(CohortFile, ReadsTablesOfOtherPrograms) {
  Write("participants.tsv", "\xEF\xBB\xBFparticipant_id\tmass_kg\r\nsub-01\t70\r\nsub-02\t 81 \r\n\r\n");
  const cohort::Cohort cohort = ReadCohort(folder_.Path());
  ASSERT_EQ(cohort.recordings.size(), 4u);
  EXPECT_EQ(cohort.recordings[3].study["simulate"]["mass_kg"], "81");
}

TEST_F(CohortFile, ReadsWhatTheDesignForAllIs) {
  EXPECT_FALSE(ReadCohort(folder_.Path()).population);
  WriteYaml("population: {human_only: true, max_misalignment_percent: 3, across: quantile, quantile: 0.8, sizes: 3}\n");
  const cohort::Cohort cohort = ReadCohort(folder_.Path());
  ASSERT_TRUE(cohort.population);
  EXPECT_EQ(cohort.population->options.across, redesign::Across::kQuantile);
  EXPECT_EQ(cohort.population->options.quantile, 0.8);
  EXPECT_EQ(cohort.population->options.sizes, 3);
  EXPECT_FALSE(cohort.has_heights) << "sub-03's is n/a";
  WriteYaml("population: {pareto: 5}\n");
  ExpectRefused("cohort.yaml:5: unknown key 'pareto'");
  WriteYaml("population: {problem: nowhere.yaml}\n");
  ExpectRefused("nowhere.yaml");
}

}  // namespace
}  // namespace lake
