// The step runner: what is done again, what is not, and what is left when a step fails.
#include "lake/steps/study_steps.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <thread>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/threads.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Two sources a, b; their copies; the join of both copies; a report of everything.
class Steps : public testing::TestWithParam<int> {
 protected:
  Steps() {
    SetThreads(GetParam());
    WriteTextFile(folder_ / "a.txt", "alpha");
    WriteTextFile(folder_ / "b.txt", "beta");
  }
  ~Steps() override { SetThreads(before_); }

  steps::StudyStep Copy(const std::string& name) {
    steps::StudyStep step{
        name, "a copy of " + name + ".txt", "copy", Out(name), {folder_ / (name + ".txt")}, {}, {}, {}, {}};
    step.options = {{"suffix", suffix_}};
    step.work = [this, name](lake::Run& run) {
      NoteDone(name);
      WriteTextFile(run.Result("copy.txt"), ReadTextFile(folder_ / (name + ".txt")).substr(0, 4) + suffix_);
    };
    return step;
  }

  steps::StudyStep Join() {
    steps::StudyStep step{
        "join", "both copies", "join", Out("join"), {Out("a") / "copy.txt", Out("b") / "copy.txt"}, {}, {}, {}, {}};
    step.work = [this](lake::Run& run) {
      NoteDone("join");
      if (fail_) fail_();
      WriteTextFile(run.Result("join.txt"), ReadTextFile(Out("a") / "copy.txt") + ReadTextFile(Out("b") / "copy.txt"));
    };
    return step;
  }

  steps::StudyStep Report() {
    steps::StudyStep step{"report", "all of it", "report", folder_ / "out", {}, {"a", "b", "join"}, {}, {}, {}};
    step.work = [this](lake::Run& run) {
      NoteDone("report");
      WriteTextFile(run.Result("report.html"), "report");
    };
    return step;
  }

  fs::path Out(const std::string& name) const { return folder_ / "out" / name; }

  // The names of the steps that were done.
  std::vector<std::string> Go(const std::string& maker = "this build") {
    fs::remove(folder_ / "done.txt");
    outcomes_ = steps::RunSteps({Copy("a"), Copy("b"), Join(), Report()}, {maker, "test", true});
    return Done();
  }

  // Steps work in processes of their own: what they did stands in a file, and those of the same time in either order.
  void NoteDone(const std::string& name) const {
    std::ofstream(folder_ / "done.txt", std::ios::app) << name << std::endl;
  }
  std::vector<std::string> Done() const {
    std::vector<std::string> names;
    std::ifstream file(folder_ / "done.txt");
    for (std::string name; std::getline(file, name);) names.push_back(name);
    std::ranges::sort(names);
    return names;
  }

  TemporaryFolder folder_;
  std::string suffix_ = "!";
  std::function<void()> fail_;
  const int before_ = Threads();
  std::vector<steps::StepOutcome> outcomes_;
};

TEST_P(Steps, AreDoneOnceAndThenLeftAlone) {
  EXPECT_THAT(Go(), ElementsAre("a", "b", "join", "report"));
  EXPECT_THAT(Go(), IsEmpty());
  for (const steps::StepOutcome& outcome : outcomes_) EXPECT_FALSE(outcome.done) << outcome.why;
  EXPECT_EQ(ReadTextFile(Out("join") / "join.txt"), "alph!beta!");
}

TEST_P(Steps, AreDoneAgainWhereAnInputChangedAndWhatReadsThem) {
  Go();
  WriteTextFile(folder_ / "b.txt", "gamma");
  EXPECT_THAT(Go(), ElementsAre("b", "join", "report"));
  EXPECT_EQ(outcomes_[1].why, "b.txt changed");
  EXPECT_THAT(Go(), IsEmpty());
}

// Only the first four letters are copied.
TEST_P(Steps, AreNotDoneWhereAChangeComesToNothing) {
  Go();
  WriteTextFile(folder_ / "b.txt", "beta and more");
  EXPECT_THAT(Go(), ElementsAre("b"));
}

TEST_P(Steps, KnowAChangeByContentNotByTime) {
  Go();
  WriteTextFile(folder_ / "a.txt", "alpha");
  EXPECT_THAT(Go(), IsEmpty());
  // Written in place: the same inode, size, and time of the last write.
  struct stat status;
  ASSERT_EQ(stat((folder_ / "a.txt").c_str(), &status), 0);
  const int file = open((folder_ / "a.txt").c_str(), O_WRONLY);
  ASSERT_EQ(write(file, "omega", 5), 5);
  const timespec times[] = {status.st_atim, status.st_mtim};
  ASSERT_EQ(futimens(file, times), 0);
  close(file);
  EXPECT_THAT(Go(), ElementsAre("a", "join", "report"));
}

TEST_P(Steps, AreDoneAgainForOtherOptionsAndByAnotherBuild) {
  Go();
  suffix_ = "?";
  EXPECT_THAT(Go(), ElementsAre("a", "b", "join", "report"));
  EXPECT_EQ(outcomes_[0].why, "its options changed");
  EXPECT_THAT(Go("an older build"), ElementsAre("a", "b", "join", "report"));
  EXPECT_THAT(outcomes_[0].why, HasSubstr("another build"));
}

TEST_P(Steps, AreDoneAgainWhereAnOutputIsMissingOrWasChanged) {
  Go();
  fs::remove(Out("b") / "copy.txt");
  EXPECT_THAT(Go(), ElementsAre("b")) << "the same comes out, so nothing that reads it need be done";
  EXPECT_EQ(outcomes_[1].why, "copy.txt is missing");
  WriteTextFile(Out("join") / "join.txt", "by hand");
  EXPECT_THAT(Go(), ElementsAre("join"));
  EXPECT_EQ(outcomes_[2].why, "join.txt was changed");
  fs::remove_all(folder_ / "out");
  EXPECT_THAT(Go(), ElementsAre("a", "b", "join", "report"));
}

TEST_P(Steps, WithAnUnreadableStampAreDoneAgain) {
  Go();
  WriteTextFile(Out("a") / ".a.lake-step.json", "{\"maker\": 3}");
  EXPECT_THAT(Go(), ElementsAre("a"));
}

TEST_P(Steps, NeverTouchFilesThatAreNotTheirs) {
  fs::create_directories(Out("a"));
  WriteTextFile(Out("a") / "notes.txt", "mine");
  Go();
  suffix_ = "?";
  Go();
  EXPECT_EQ(ReadTextFile(Out("a") / "notes.txt"), "mine");
  WriteTextFile(Out("a") / "notes.txt", "mine, changed");
  EXPECT_THAT(Go(), IsEmpty());
  // A stamp that was tampered with does not make it delete a file elsewhere.
  const fs::path stamp = Out("a") / ".a.lake-step.json";
  std::string text = ReadTextFile(stamp);
  const auto name = text.find("\"copy.txt\"");
  ASSERT_NE(name, std::string::npos);
  WriteTextFile(stamp, text.replace(name, 10, "\"../../a.txt\""));
  EXPECT_THAT(Go(), ElementsAre("a"));
  EXPECT_EQ(ReadTextFile(folder_ / "a.txt"), "alpha");
}

// What appears in a step's folder while it is at work is not its output for that.
TEST_P(Steps, KeepWhatAUserWritesWhileTheyAreDone) {
  fail_ = [&] { WriteTextFile(Out("join") / "notes.txt", "mine"); };
  Go();
  EXPECT_EQ(ReadTextFile(Out("join") / "notes.txt"), "mine");
  fail_ = nullptr;
  suffix_ = "?";
  Go();
  EXPECT_EQ(ReadTextFile(Out("join") / "notes.txt"), "mine");
  EXPECT_EQ(ReadTextFile(Out("join") / "join.txt"), "alph?beta?");
}

TEST_P(Steps, ThatAStudyDoesNotHaveAnyMoreAreRetired) {
  Go();
  WriteTextFile(Out("b") / "notes.txt", "mine");
  steps::RetireStudyStep(Out("a"), "a");
  steps::RetireStudyStep(Out("b"), "b");
  steps::RetireStudyStep(Out("join"), "other");
  EXPECT_FALSE(fs::exists(Out("a")));
  EXPECT_EQ(std::distance(fs::directory_iterator(Out("b")), {}), 1) << "the user's notes";
  EXPECT_TRUE(fs::exists(Out("join") / "join.txt")) << "not that step's";
}

// A program run by hand in the step's folder: its results are its own, whatever the stamp beside them says.
TEST_P(Steps, ThatAreRetiredLeaveWhatWasMadeByHand) {
  Go();
  {
    lake::Run by_hand({"copy", "by hand", Json::object(), Out("a"), true});
    WriteTextFile(by_hand.Result("copy.txt"), "by hand");
    by_hand.WriteSummary(Json::object());
  }
  steps::RetireStudyStep(Out("a"), "a");
  EXPECT_EQ(ReadTextFile(Out("a") / "copy.txt"), "by hand");
}

TEST_P(Steps, OfACopiedFolderAreItsOwn) {
  Go();
  fs::copy(folder_ / "out", folder_ / "copy", fs::copy_options::recursive);
  fs::rename(folder_ / "out", folder_ / "first");
  fs::rename(folder_ / "copy", folder_ / "out");
  EXPECT_THAT(Go(), IsEmpty());
  suffix_ = "?";
  Go();
  EXPECT_EQ(ReadTextFile(folder_ / "first" / "a" / "copy.txt"), "alph!");
}

TEST_P(Steps, ThatFailSayWhichAndKeepWhatIsFinished) {
  fail_ = [] { throw SolverError("no solution"); };
  EXPECT_EQ(MessageOf<SolverError>([&] { Go(); }), "step join (both copies): no solution");
  EXPECT_THAT(Done(), ElementsAre("a", "b", "join")) << "the report is not begun";
  fail_ = [] { throw UsageError("not so"); };
  EXPECT_EQ(MessageOf<UsageError>([&] { Go(); }), "step join (both copies): not so");
  EXPECT_THAT(Done(), ElementsAre("join"));
  fail_ = [] { throw std::runtime_error("bad"); };
  EXPECT_THAT(MessageOf<Error>([&] { Go(); }),
              HasSubstr("step join (both copies): a library failed at this input (bad)"));
  fail_ = nullptr;
  EXPECT_THAT(Go(), ElementsAre("join", "report"));
}

TEST_P(Steps, InterruptedGoOnWhereTheyWere) {
  Go();
  suffix_ = "?";
  fail_ = [] { throw Interrupted(2); };
  EXPECT_THROW(Go(), Interrupted);
  EXPECT_THAT(Done(), ElementsAre("a", "b", "join"));
  EXPECT_EQ(ReadTextFile(Out("join") / "join.txt"), "alph!beta!") << "the last results stay";
  // Even if the copies come back to what they were; the report, of what comes out again, need not be made.
  suffix_ = "!";
  fail_ = nullptr;
  EXPECT_THAT(Go(), ElementsAre("a", "b", "join"));
}

// One at a time, as a scheduler does them: the same files as all at once, and what is missing before it is said.
TEST_P(Steps, AreDoneOneByOne) {
  const std::vector<steps::StudyStep> all = {Copy("a"), Copy("b"), Join(), Report()};
  const auto run_step = [&](const std::string& name) {
    return steps::RunSteps(all, {.made_by = "this build", .command = "test", .quiet = true, .only = {name}}).front();
  };
  EXPECT_THAT(steps::StepsBefore(all, all[2]), ElementsAre("a", "b"));
  EXPECT_THAT(steps::StepsBefore(all, all[3]), ElementsAre("a", "b", "join"));
  EXPECT_THAT([&] { run_step("report"); },
              testing::ThrowsMessage<Error>(HasSubstr("step a leaves, which has not been done")));
  EXPECT_THAT([&] { run_step("walk"); }, testing::ThrowsMessage<Error>(HasSubstr("it has a, b")));
  for (const char* name : {"b", "a", "join", "report"}) EXPECT_TRUE(run_step(name).done) << name;
  EXPECT_FALSE(run_step("join").done);
  EXPECT_THAT(Go(), IsEmpty()) << "done one by one is done";
}

TEST_P(Steps, ThatFailKeepNothingElseFromBeingDone) {
  steps::StudyStep failing = Copy("a");
  failing.work = [](lake::Run&) { throw UsageError("not so"); };
  const std::vector<steps::StudyStep> all = {failing, Copy("b"), Join(), Report()};
  const steps::StepRunOptions options{.made_by = "this build", .command = "test", .quiet = true, .keep_going = true};
  EXPECT_EQ(MessageOf<UsageError>([&] { steps::RunSteps(all, options); }), "step a (a copy of a.txt): not so");
  EXPECT_THAT(Done(), ElementsAre("b")) << "what reads the copy of a is not begun";
  EXPECT_EQ(steps::StepFailure(failing), "step a (a copy of a.txt): not so");
  EXPECT_EQ(steps::StepFailure(all[1]), std::nullopt);
  EXPECT_THAT(steps::WhyDoSteps(all, "this build").front(), "not made yet");
  EXPECT_THAT(Go(), ElementsAre("a", "join", "report"));
  EXPECT_EQ(steps::StepFailure(failing), std::nullopt);
}

TEST_P(Steps, SayWhyTheyWouldBeDone) {
  const std::vector<steps::StudyStep> all = {Copy("a"), Copy("b"), Join(), Report()};
  const auto why = [&] { return steps::WhyDoSteps(all, "this build"); };
  EXPECT_THAT(why(), testing::Each("not made yet"));
  EXPECT_FALSE(fs::exists(folder_ / "out")) << "nothing is written";
  Go();
  EXPECT_THAT(why(), testing::Each(""));
  WriteTextFile(folder_ / "b.txt", "gamma");
  EXPECT_THAT(why(), ElementsAre("", "b.txt changed", "step b is to be done before", "step b is to be done before"));
  EXPECT_THAT(steps::WhyDoSteps(all, "another"), testing::Contains("made by another build of lake"));
}

INSTANTIATE_TEST_SUITE_P(Threads, Steps, testing::Values(1, 2, 5));

// The patience is that of a test that would otherwise never end.
bool ComesTrue(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  while (!condition() && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return condition();
}

bool Appears(const fs::path& file) {
  return ComesTrue([&] { return fs::exists(file); });
}

class StepsAtOnce : public testing::Test {
 protected:
  StepsAtOnce() { SetThreads(2); }
  ~StepsAtOnce() override { SetThreads(before_); }

  steps::StudyStep Step(const std::string& name, const std::function<void(lake::Run&)>& work) {
    return {.name = name, .what = name, .program = "lake-track", .folder = folder_ / name, .work = work};
  }

  const int before_ = Threads();
  TemporaryFolder folder_;
};

// Each waits for the other: one after the other they would wait in vain.
TEST_F(StepsAtOnce, AreUnderWayWhereNeitherReadsTheOther) {
  const auto meet = [&](const std::string& own, const std::string& other) {
    return Step(own, [=, this](lake::Run& run) {
      WriteTextFile(run.Result("here.txt"), own);
      WriteTextFile(folder_ / (own + " begun"), own);
      if (!Appears(folder_ / (other + " begun"))) throw Fail("{} never came", other);
    });
  };
  EXPECT_EQ(steps::RunSteps({meet("a", "b"), meet("b", "a")}, {"this build", "test", true}).size(), 2u);
}

TEST_F(StepsAtOnce, ComeToTheirEndWhereAnotherFails) {
  const steps::StudyStep failing = Step("failing", [&](lake::Run&) {
    if (!Appears(folder_ / "patient begun")) throw Fail("the other never came");
    throw UsageError("not so");
  });
  const steps::StudyStep patient = Step("patient", [&](lake::Run& run) {
    WriteTextFile(folder_ / "patient begun", "");
    if (!ComesTrue([&] { return steps::StepFailure(failing).has_value(); })) throw Fail("no failure was noticed");
    WriteTextFile(run.Result("end.txt"), "");
  });
  steps::StudyStep later = Step("later", [&](lake::Run& run) { WriteTextFile(run.Result("later.txt"), ""); });
  later.inputs = {folder_ / "patient/end.txt"};
  EXPECT_THAT(
      [&] {
        steps::RunSteps({patient, failing, later}, {"this build", "test", true});
      },
      testing::ThrowsMessage<UsageError>("step failing (failing): not so"));
  EXPECT_TRUE(fs::exists(folder_ / "patient/end.txt"));
  EXPECT_EQ(steps::WhyDoSteps({patient}, "this build").front(), "") << "it is done";
  EXPECT_FALSE(fs::exists(folder_ / "later/later.txt")) << "no other is begun";
}

TEST_F(StepsAtOnce, TheLastCostIsKept) {
  const steps::StudyStep step = Step("a", [&](lake::Run& run) {
    const std::vector<char> memory(100 << 20, 'a');  // written to, so it is there
    WriteTextFile(run.Result("a.txt"), memory.data() == nullptr ? "" : "a");
  });
  EXPECT_FALSE(steps::LastCost(step));
  steps::RunSteps({step}, {"this build", "test", true});
  const auto cost = steps::LastCost(step);
  ASSERT_TRUE(cost);
  EXPECT_GT(cost->seconds, 0);
  EXPECT_GT(cost->memory_mb, 100);
}

}  // namespace
}  // namespace lake
