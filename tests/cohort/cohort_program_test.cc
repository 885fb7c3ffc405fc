// lake-cohort as a user runs it: rendered people, from their folder to the group's page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "cli/program_run.h"
#include "cohort/bids_rules.h"
#include "lake/core/json.h"
#include "lake/core/provenance.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

bool HasSnakemake() {
  return std::system("command -v snakemake >/dev/null 2>&1") == 0;
}

// The content of all results; what steps took and said is in logs/ and in the hidden files beside results.
std::map<std::string, std::string> Contents(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (entry.is_regular_file() && !name.starts_with("logs/") && !entry.path().filename().string().starts_with("."))
      contents[name] = Sha256OfFile(entry.path());
  }
  return contents;
}

class CohortProgram : public testing::Test {
 protected:
  void ExpectRefused(const std::string& arguments, int exit_code, const std::string& text) {
    const Outcome outcome = Shell(folder_, "lake-cohort " + arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_THAT(outcome.err, testing::AllOf(StartsWith("lake-cohort: "), HasSubstr(text)));
    EXPECT_EQ(outcome.ErrorLines(), 1) << outcome.err;
  }

  // The joint is where the population's exoskeleton has it: 4 px per 15 mm, and no more than 12 s of one rise.
  void ExpectTruth() {
    const CsvTable truth = CsvTable::Read(folder_ / "people/truth.csv"),
                   trials = CsvTable::Read(folder_ / "out/group/trials.csv");
    constexpr double kToleranceMm = 3;  // timing and placement are told apart with one rise only
    int compared = 0;
    for (std::size_t i = 0; i < trials.Rows(); ++i)
      for (std::size_t j = 0; j < truth.Rows(); ++j) {
        if (trials.Text(i, 0) != truth.Text(j, 0) || trials.Text(i, trials.Column("trial")) != "comparison") continue;
        ++compared;
        for (const auto& [measured, true_one] :
             {std::pair{"joint_offset_x_mm", "exo_knee_x_mm"}, {"joint_offset_y_mm", "exo_knee_y_mm"}})
          EXPECT_NEAR(trials.RequiredNumber(i, trials.Column(measured)),
                      truth.RequiredNumber(j, truth.Column(true_one)), kToleranceMm)
              << trials.Text(i, 0);
      }
    EXPECT_EQ(compared, 2);
  }

  // One design for the two people whose comparison is there.
  void ExpectOneDesignForBoth(const std::string& page) {
    const CsvTable people = CsvTable::Read(folder_ / "out/group/population/people.csv");
    ASSERT_EQ(people.Rows(), 2u);
    EXPECT_EQ(people.Text(0, 0), "sub-01");
    EXPECT_EQ(people.Text(1, 0), "sub-02");
    // Small costs are counted once for each: nobody's own design is worse by more.
    for (std::size_t i = 0; i < 2; ++i) EXPECT_GE(people.RequiredNumber(i, people.Column("cost_deg")), -2e-3);
    EXPECT_THAT(page, HasSubstr("One design for all"));
  }

  TemporaryFolder folder_;
};

TEST_F(CohortProgram, MakesATemplateAndSaysWhatIsMissing) {
  fs::create_directories(folder_ / "bin");
  ASSERT_EQ(Shell(folder_, "lake cohort --template mine").exit_code, 0);
  for (const char* file : {"participants.tsv", "participants.json", "cohort.yaml", "README"})
    EXPECT_TRUE(fs::is_regular_file(folder_ / "mine" / file)) << file;
  ExpectRefused("--template mine", 1, "is there already");
  ExpectRefused("mine out participant", 1, "there are no recordings");
  ExpectRefused("mine out", 2, "participant or group");
  ExpectRefused("mine out everything", 2, "'everything': participant or group");
  ExpectRefused("mine out group --slurm --cores 2", 2, "--cores: not with --slurm");
  ExpectRefused("mine out group --participant-label 01 09", 2, "not in participants.tsv, which has sub-01, sub-02");
  ExpectRefused("nowhere out group", 1, "nowhere: no such folder");
  ExpectRefused("mine 'out{1}' group", 1, "cannot work with braces");
  ExpectRefused("mine mine group", 2, "a folder of their own");
  ExpectRefused("mine mine/sourcedata/results group", 2, "a folder of their own");
  ExpectRefused("mine . group", 2, "a folder of their own");
  ExpectRefused("mine out group --profile nowhere", 2, "no config.yaml");
  // A Slurm that does not answer is one line, whatever its programs say.
  WriteTextFile(folder_ / "bin/sinfo", "#!/bin/sh\necho 'sinfo: error: no controller' >&2\necho more >&2\nexit 1\n");
  WriteTextFile(folder_ / "bin/sbatch", "#!/bin/sh\nexit 1\n");
  for (const char* program : {"sinfo", "sbatch"}) fs::permissions(folder_ / "bin" / program, fs::perms::owner_all);
  WriteTextFile(folder_ / "mine/sourcedata/sub-01/ses-1/human.mp4", "");
  const Outcome slurm = Shell(folder_, "PATH=$PWD/bin:$PATH lake-cohort mine out group --slurm");
  EXPECT_EQ(slurm.exit_code, 1);
  EXPECT_EQ(slurm.err, "lake-cohort: --slurm: Slurm does not answer: sinfo: error: no controller\n");
  // Of one that does, every job is asked after before Slurm forgets it.
  WriteTextFile(folder_ / "bin/sinfo", "#!/bin/sh\necho short\n");
  WriteTextFile(folder_ / "bin/snakemake", "#!/bin/sh\necho \"$@\" > \"${0%/*}/asked\"\n");
  for (const char* program : {"sinfo", "snakemake"}) fs::permissions(folder_ / "bin" / program, fs::perms::owner_all);
  for (const char* file : {"sourcedata/sub-01/ses-1/exo.mp4", "camera.yaml"})
    WriteTextFile(folder_ / "mine" / file, "");
  const Outcome asked = Shell(folder_, "PATH=$PWD/bin:$PATH lake-cohort mine out participant --slurm --jobs 7");
  ASSERT_TRUE(fs::exists(folder_ / "bin/asked")) << asked.err;
  EXPECT_THAT(ReadTextFile(folder_ / "bin/asked"), HasSubstr("--slurm --jobs 7"));
  EXPECT_THAT(ReadTextFile(folder_ / "bin/asked"), HasSubstr("--max-status-checks-per-second 1"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "mine/sourcedata"), fs::directory_iterator()), 2);
}

// Two people as they must be; of a third one trial cannot be read, of a fourth there is none.
TEST_F(CohortProgram, GoesFromFolderToPageAndOnWhereItWasKilled) {
  if (!HasSnakemake()) GTEST_SKIP() << "snakemake is not installed";
  ASSERT_EQ(Shell(folder_,
                  "lake-synth --population 3 --seed-number 11 --repetitions 1 --rest 0.7 --rate 20 "
                  "--width 640 --height 360 --radius-px 2 --quiet -o people")
                .exit_code,
            0);
  fs::remove(folder_ / "people/sourcedata/sub-03/exo/video.mp4");
  WriteTextFile(folder_ / "people/sourcedata/sub-03/exo/video.mp4", "no video");
  WriteTextFile(folder_ / "people/participants.tsv",
                ReadTextFile(folder_ / "people/participants.tsv") + "sub-04\tn/a\tn/a\n");

  Json cohort = ReadJsonFile(folder_ / "people/cohort.yaml");
  cohort["population"] = {{"human_only", true}, {"penalty", 0.3}, {"fit_placement", true}, {"starts", 1}};
  WriteJsonFile(folder_ / "people/cohort.yaml", cohort);

  const auto plan = [&] {
    const Outcome planned = Shell(folder_, "lake-cohort people out participant --plan");
    EXPECT_EQ(planned.exit_code, 0) << planned.err;
    return Json::parse(planned.out);
  };
  const Json before = plan();
  ASSERT_EQ(before["recordings"].size(), 3u);
  EXPECT_EQ(before["failed"], Json::array({"sub-04: there are no recordings"}));
  EXPECT_EQ(before["recordings"][0]["due"].front(), "human");
  EXPECT_FALSE(fs::exists(folder_ / "out/sub-01/human")) << "nothing is done";

  // Killed when one trial of two people is done; what it had started outlives it, and is waited for.
  const std::string run = "lake-cohort people out group --cores 2 --quiet";
  const Outcome killed = Shell(folder_, run +
                                            " & while kill -0 $! && [ ! -e out/sub-01/human/.human.lake-step.json ]; "
                                            "do sleep 0.05; done; kill -KILL $!; wait $!");
  EXPECT_EQ(killed.exit_code, 137) << killed.err;
  EXPECT_FALSE(fs::exists(folder_ / "out/group/group.html"));

  const Outcome again = Shell(folder_, run);
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const Json after = plan();
  EXPECT_EQ(after["recordings"][0]["due"], Json::array()) << "sub-01 is done";
  EXPECT_EQ(after["recordings"][2]["due"].front(), "exo") << "that of sub-03 cannot be read";
  EXPECT_EQ(ExpectDerivativeHolds(folder_ / "out"), 4) << "two people, two trials";
  EXPECT_EQ(ReadJsonFile(folder_ / "out/dataset_description.json")["SourceDatasets"][0]["URL"], "file:../people");
  const std::string page = ReadTextFile(folder_ / "out/group/group.html");
  EXPECT_THAT(page, HasSubstr("../sub-02/comparison/report.html"));
  EXPECT_THAT(page, HasSubstr("flexion momentum: onset to seat-off (s)")) << "names in words, with units";
  EXPECT_THAT(page, HasSubstr("<a href=\"./../sub-01/comparison/report.html\">sub-01</a>"));
  EXPECT_THAT(page, HasSubstr("data-filters=\"0 1 2 3\""));
  for (const char* figure : {"knee_angle", "trunk_lean", "misalignment"}) {
    EXPECT_THAT(page, HasSubstr(fmt::format("{}.svg", figure)));
    EXPECT_GT(fs::file_size(folder_ / fmt::format("out/group/{}.png", figure)), 10000u);
    EXPECT_GT(fs::file_size(folder_ / fmt::format("out/group/{}.svg", figure)), 5000u);
  }
  const CsvTable failures = CsvTable::Read(folder_ / "out/group/failures.csv");
  ASSERT_EQ(failures.Rows(), 2u);
  EXPECT_EQ(failures.Text(0, failures.Column("participant_id")), "sub-04");
  EXPECT_EQ(failures.Text(0, failures.Column("step")), "recordings");
  EXPECT_THAT(failures.Text(0, failures.Column("error")), HasSubstr("no recordings"));
  EXPECT_EQ(failures.Text(1, failures.Column("step")), "exo");
  EXPECT_THAT(failures.Text(1, failures.Column("error")), HasSubstr("sub-03/exo/video.mp4"));
  EXPECT_THAT(page, HasSubstr("sub-03/exo/video.mp4"));
  ExpectTruth();
  ExpectOneDesignForBoth(page);

  EXPECT_TRUE(fs::exists(folder_ / "out/participants.json"));

  // By hand, without asking lake-cohort: the tables are made again whenever they are asked for.
  const auto with_kill = Contents(folder_ / "out");
  WriteTextFile(folder_ / "out/group/trials.csv", "not what the studies say\n");
  const Outcome by_hand =
      Shell(folder_,
            "snakemake --snakefile \"$(dirname \"$(command -v lake-cohort)\")/../share/lake/cohort/Snakefile\" "
            "--configfile out/logs/cohort.json --directory out/logs --keep-going --rerun-incomplete "
            "--rerun-triggers mtime --cores 2 group");
  EXPECT_EQ(by_hand.exit_code, 0) << by_hand.err;
  EXPECT_EQ(Contents(folder_ / "out"), with_kill);

  // Without a kill the same comes out, byte by byte.
  fs::rename(folder_ / "out", folder_ / "killed");
  ASSERT_EQ(Shell(folder_, run).exit_code, 0);
  EXPECT_EQ(Contents(folder_ / "out"), with_kill);

  // A study that fails at two steps is one study.
  fs::remove(folder_ / "people/sourcedata/sub-03/human/video.mp4");
  WriteTextFile(folder_ / "people/sourcedata/sub-03/human/video.mp4", "no video");
  const Outcome failed = Shell(folder_, "lake-cohort people third participant --participant-label 03 --quiet");
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(failed.err, HasSubstr("1 of 1 studies failed: "));
}

}  // namespace
}  // namespace lake
