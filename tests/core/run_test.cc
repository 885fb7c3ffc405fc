// Whose results stand in a folder: a run takes away what its program left there, and nothing else.
#include "lake/core/run.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

class ResultFolder : public testing::Test {
 protected:
  lake::Run::Info Info(const std::string& program, const std::string& subject = "") {
    lake::Run::Info info{program, program + " " + subject, {}, Out(), true};
    if (!subject.empty()) info.subject = {subject};
    return info;
  }

  void Write(lake::Run& run, const std::string& name) { WriteTextFile(run.Result(name), "of " + name); }

  // A whole run that writes these.
  void Do(const std::string& program, const std::vector<std::string>& names, const std::string& subject = "") {
    lake::Run run(Info(program, subject));
    for (const std::string& name : names) Write(run, name);
    run.WriteSummary(Json::object());
  }

  bool Has(const std::string& name) const { return fs::exists(Out() / name); }
  fs::path Out() const { return folder_ / "out"; }

  TemporaryFolder folder_;
};

TEST_F(ResultFolder, HoldsNothingOfTheRunBefore) {
  Do("lake-track", {"tracks.csv", "trajectory.csv", "predicted/comparison.json"});
  WriteTextFile(Out() / "notes.txt", "mine");
  WriteTextFile(Out() / "trajectory-mine.csv", "mine");
  Do("lake-track", {"tracks.csv"});
  EXPECT_TRUE(Has("tracks.csv") && Has("summary.json"));
  EXPECT_FALSE(Has("trajectory.csv") || Has("predicted"));
  EXPECT_EQ(ReadTextFile(Out() / "notes.txt"), "mine");
  EXPECT_TRUE(Has("trajectory-mine.csv"));
}

TEST_F(ResultFolder, KeepsTheLastResultsUntilTheNewAreComplete) {
  Do("lake-track", {"tracks.csv", "kinematics.csv"});
  lake::Run run(Info("lake-track"));
  WriteTextFile(run.Result("tracks.csv"), "new");
  EXPECT_EQ(ReadTextFile(Out() / "tracks.csv"), "of tracks.csv");
  EXPECT_TRUE(FindResult(Out(), "kinematics.csv") && Has("summary.json"));
  run.WriteSummary(Json::object());
  EXPECT_EQ(ReadTextFile(Out() / "tracks.csv"), "new");
  EXPECT_FALSE(Has("kinematics.csv"));
  EXPECT_EQ(run.Results(), (std::vector<fs::path>{Out() / "summary.json", Out() / "tracks.csv"}));
}

TEST_F(ResultFolder, KeepsTheLastResultsBesideThoseOfAFailedRun) {
  Do("lake-track", {"tracks.csv", "kinematics.csv"});
  const std::string summary = ReadTextFile(Out() / "summary.json");
  {
    lake::Run run(Info("lake-track"));
    WriteTextFile(run.Result("candidates.csv"), "found");
    EXPECT_EQ(run.FolderIfFailed(), Out() / "failed");
    run.WriteFailedSummary(Json::object(), "no knee");
  }
  EXPECT_EQ(ReadTextFile(Out() / "summary.json"), summary);
  EXPECT_EQ(ReadTextFile(*FindResult(Out(), "tracks.csv")), "of tracks.csv");
  EXPECT_EQ(ReadTextFile(Out() / "failed/candidates.csv"), "found");
  EXPECT_EQ(ReadJsonFile(Out() / "failed/summary.json")["failed"], "no knee");
  {
    lake::Run run(Info("lake-track"));
    WriteTextFile(run.Result("tracks.csv"), "interrupted");
  }
  EXPECT_EQ(ReadTextFile(*FindResult(Out(), "tracks.csv")), "of tracks.csv");
  EXPECT_EQ(ReadTextFile(Out() / "failed/tracks.csv"), "interrupted");
  EXPECT_FALSE(Has("failed/candidates.csv")) << "of the last failed run alone";
  Do("lake-track", {"tracks.csv"});
  EXPECT_FALSE(Has("failed") || Has("kinematics.csv"));
}

TEST_F(ResultFolder, OfARunThatWasKilledHoldsTheLastResults) {
  Do("lake-track", {"tracks.csv"});
  const pid_t child = fork();
  if (child == 0) {
    lake::Run run(Info("lake-track"));
    WriteTextFile(run.Result("tracks.csv"), "killed");
    _exit(0);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  EXPECT_EQ(ReadTextFile(*FindResult(Out(), "tracks.csv")), "of tracks.csv");
  Do("lake-track", {"tracks.csv"});
  const auto left = std::distance(fs::directory_iterator(Out()), fs::directory_iterator());
  EXPECT_EQ(left, 3) << "tracks.csv, summary.json and the list";
}

// Where there is nothing to keep, what was finished stands in its place, and the next run replaces it.
TEST_F(ResultFolder, OfARunThatWasInterruptedHoldsWhatWasFinished) {
  {
    lake::Run run(Info("lake-track"));
    Write(run, "tracks.csv");
    EXPECT_EQ(run.FolderIfFailed(), Out());
  }
  EXPECT_THAT([&] { FindResult(Out(), "tracks.csv"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("lake-track"), HasSubstr("did not finish"))));
  {
    lake::Run run(Info("lake-track"));
    Write(run, "candidates.csv");
    run.WriteFailedSummary(Json::object(), "no knee");
  }
  EXPECT_TRUE(Has("candidates.csv") && Has("summary.json"));
  EXPECT_FALSE(Has("tracks.csv") || Has("failed"));
  Do("lake-track", {"events.csv"});
  EXPECT_FALSE(Has("candidates.csv")) << "what the failed run left goes too";
}

TEST_F(ResultFolder, KeepsAFileOfTheUsersAmongThoseOfAFailedRun) {
  Do("lake-track", {"tracks.csv"});
  fs::create_directory(Out() / "failed");
  WriteTextFile(Out() / "failed/notes.txt", "mine");
  { Write(*std::make_unique<lake::Run>(Info("lake-track")), "notes.txt"); }
  Do("lake-track", {"tracks.csv"});
  EXPECT_EQ(ReadTextFile(Out() / "failed/notes.txt"), "mine");
}

TEST_F(ResultFolder, OfARunThatWasKilledHoldsNoTemporaryFiles) {
  Do("lake-x", {"a.csv", "sub/b.png"});
  const std::vector<std::string> temporary = {".a.lake-Xy3z01.csv", "sub/.b.png.lake-000aaa.log", ".c.lake-abcdef"};
  const std::vector<std::string> users = {".a.csv", ".lake-notes", ".a.lake-notes of mine.csv", "a.lake-abcdef.csv"};
  for (const std::string& name : temporary) WriteTextFile(Out() / name, "half");
  fs::create_directory(Out() / ".d.lake-012345");
  WriteTextFile(Out() / ".d.lake-012345/0.png", "half");
  for (const std::string& name : users) WriteTextFile(Out() / name, "whole");
  Do("lake-x", {"a.csv"});
  for (const std::string& name : temporary) EXPECT_FALSE(Has(name)) << name;
  EXPECT_FALSE(Has(".d.lake-012345"));
  for (const std::string& name : users) EXPECT_TRUE(Has(name)) << name;
}

TEST_F(ResultFolder, OfARunWhoseInputChangedHasNoSummary) {
  WriteTextFile(folder_ / "in.csv", "1");
  WriteTextFile(folder_ / "gone.csv", "1");
  for (const char* name : {"in.csv", "gone.csv"}) {
    lake::Run run(Info("lake-x"));
    run.AddInput(folder_ / name, "text");
    Write(run, "a.csv");
    if (name == std::string("in.csv"))
      WriteTextFile(folder_ / name, "2");
    else
      fs::remove(folder_ / name);
    EXPECT_THAT([&] { run.WriteSummary(Json::object()); },
                ThrowsMessage<Error>(HasSubstr("changed while it was read")));
  }
  EXPECT_FALSE(Has("summary.json"));
}

TEST_F(ResultFolder, OfAnotherProgramIsNotTouched) {
  Do("lake-track", {"kinematics.csv"}, "/data/human.mp4");
  EXPECT_THAT([&] { lake::Run(Info("lake-gait")).Result("gait.png"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("summary.json: is a result of lake-track (/data/human.mp4)"),
                                         HasSubstr("choose another folder with -o"))));
  EXPECT_TRUE(Has("summary.json") && Has("kinematics.csv"));
}

TEST_F(ResultFolder, KeepsAFileOfTheUsersThatIsInTheWay) {
  fs::create_directory(Out());
  WriteTextFile(Out() / "events.csv", "mine");
  lake::Run run(Info("lake-track"));
  EXPECT_THAT(
      [&] {
        run.Begin({"tracks.csv", "events.csv"});
      },
      ThrowsMessage<Error>(HasSubstr("events.csv: is not a result of lake's")));
  EXPECT_THAT([&] { run.Result("events.csv"); }, ThrowsMessage<Error>(HasSubstr("would be overwritten")));
  EXPECT_EQ(ReadTextFile(Out() / "events.csv"), "mine");
}

TEST_F(ResultFolder, WithAListThatCannotBeReadKeepsWhatIsThere) {
  fs::create_directory(Out());
  WriteTextFile(Out() / ".lake-track.lake-files.json", "{");
  WriteTextFile(Out() / "tracks.csv", "mine");
  EXPECT_THAT([&] { lake::Run(Info("lake-track")).Begin({"tracks.csv"}); },
              ThrowsMessage<Error>(HasSubstr("tracks.csv: is not a result of lake's")));
  EXPECT_EQ(ReadTextFile(Out() / "tracks.csv"), "mine");
}

// Of several places the first that is there; what is absent is no input.
TEST_F(ResultFolder, RecordsTheInputsThatAreThere) {
  for (const char* name : {"b.csv", "c.csv", "d.csv"}) WriteTextFile(folder_ / name, name);
  lake::Run run(Info("lake-test"));
  run.AddInputs({{folder_ / "a.csv", "markers"},
                 {folder_ / "b.csv", "markers", true},
                 {folder_ / "c.csv", "markers", true},
                 {folder_ / "d.csv", "motion"},
                 {folder_ / "e.csv", "camera"}});
  const Json inputs = run.Head()["inputs"];
  ASSERT_EQ(inputs.size(), 2u);
  EXPECT_EQ(inputs[0]["path"], (folder_ / "b.csv").string());
  EXPECT_EQ(inputs[1]["role"], "motion");
}

TEST_F(ResultFolder, KeepsWhatTheRunReadsUntilItIsReplaced) {
  Do("lake-calibrate", {"camera.yaml", "residuals.csv"});
  lake::Run run(Info("lake-calibrate"));
  run.AddInput(Out() / "camera.yaml", "camera");
  run.WriteSummary(Json::object());
  EXPECT_EQ(ReadTextFile(*FindResult(Out(), "camera.yaml")), "of camera.yaml");
  EXPECT_FALSE(Has("residuals.csv"));
}

TEST_F(ResultFolder, ThatNobodyChoseIsNotTakenOverByAnotherSubject) {
  Do("lake-track", {"tracks.csv"}, "/s01/human.mp4");
  lake::Run::Info other = Info("lake-track", "/s02/human.mp4");
  other.default_folder = true;
  EXPECT_THAT([&] { lake::Run(other).Begin(); },
              ThrowsMessage<Error>(
                  AllOf(HasSubstr("results of lake-track (/s01/human.mp4)"), HasSubstr("/s02/human.mp4) with -o"))));
  EXPECT_TRUE(Has("tracks.csv") && Has("summary.json"));
  lake::Run::Info same = Info("lake-track", "/s01/human.mp4");
  same.default_folder = true;
  EXPECT_NO_THROW(lake::Run(same).Begin());
  other.default_folder = false;
  EXPECT_NO_THROW(lake::Run(other).Begin()) << "whoever chooses the folder may replace what is in it";
}

TEST_F(ResultFolder, TakesOneRunAtATime) {
  fs::create_directory(Out());
  // Another process's lock: locks of one process on two descriptors are two as well.
  const int other = open(Out().c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(flock(other, LOCK_EX | LOCK_NB), 0);
  EXPECT_THAT([&] { lake::Run(Info("lake-track")).Begin(); },
              ThrowsMessage<Error>(HasSubstr("another run is at work there")));
  close(other);
  EXPECT_NO_THROW(lake::Run(Info("lake-track")).Begin());
}

TEST_F(ResultFolder, OfARunThatLeftNothingIsGone) {
  { lake::Run(Info("lake-track")).Begin({"tracks.csv"}); }
  EXPECT_FALSE(fs::exists(Out()));
  fs::create_directory(Out());
  { lake::Run(Info("lake-track")).Begin({"tracks.csv"}); }
  EXPECT_TRUE(fs::is_empty(Out()));
}

TEST_F(ResultFolder, IsReadAsWhatBelongsTogether) {
  Do("lake-track", {"tracks.csv"});
  WriteTextFile(Out() / "trajectory.csv", "from elsewhere");
  EXPECT_EQ(FindResult(Out(), "tracks.csv"), Out() / "tracks.csv");
  EXPECT_EQ(FindResult(Out(), "events.csv"), std::nullopt);
  EXPECT_THAT([&] { FindResult(Out(), "trajectory.csv"); },
              ThrowsMessage<Error>(HasSubstr("trajectory.csv: does not belong to the results of lake-track")));
  WriteTextFile(folder_ / "by-hand.csv", "in a folder without any list");
  EXPECT_TRUE(FindResult(folder_.Path(), "by-hand.csv"));
}

TEST_F(ResultFolder, ListThatWasTamperedWithNamesNothingOutside) {
  Do("lake-track", {"tracks.csv"});
  WriteTextFile(folder_ / "precious.txt", "mine");
  const fs::path list = Out() / ".lake-track.lake-files.json";
  std::string text = ReadTextFile(list);
  const auto at = text.find("tracks.csv");
  ASSERT_NE(at, std::string::npos);
  WriteTextFile(list, text.replace(at, 10, "../precious.txt"));
  fs::remove(Out() / "tracks.csv");
  Do("lake-track", {"tracks.csv"});
  EXPECT_EQ(ReadTextFile(folder_ / "precious.txt"), "mine");
}

}  // namespace
}  // namespace lake
