// Steps that are no one person's: done once for all studies where LAKE_CACHE names a folder.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/threads.h"
#include "lake/steps/study_steps.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class StepCache : public testing::Test {
 protected:
  StepCache() {
    SetThreads(1);
    setenv("LAKE_CACHE", (folder_ / "cache").c_str(), true);
    for (const char* person : {"first", "second"}) {
      fs::create_directory(folder_ / person);
      WriteTextFile(folder_ / person / "problem.txt", "a problem");
    }
  }
  ~StepCache() override {
    unsetenv("LAKE_CACHE");
    SetThreads(before_);
  }

  // Leaves a picture's bytes, a file in a folder below, and a summary with a number that has no short decimal form.
  steps::StudyStep Solve(const std::string& person) {
    const fs::path problem = folder_ / person / "problem.txt";
    steps::StudyStep step{"optimum", "the optimum", "lake-optimize", Out(person), {problem}, {}, {}, 1, {}};
    step.options = {{"starts", starts_}};
    step.is_nobodys = is_nobodys_;
    step.work = [this, problem](lake::Run& run) {
      std::ofstream(folder_ / "solved.txt", std::ios::app) << "x";
      std::this_thread::sleep_for(takes_);
      if (fail_) throw SolverError("no design");
      run.AddInput(problem);
      run.Warn("nearly singular");
      WriteTextFile(run.Result("range.png"), std::string("\0\xff\n\x80", 4));
      WriteTextFile(run.Result("sizes/1.csv"), "range\n170\n");
      run.WriteSummary({{"range_deg", 0.1 + 0.2}, {"bound_deg", nullptr}});
    };
    return step;
  }

  void Go(const std::string& person, const std::string& maker = "this build") {
    steps::RunSteps({Solve(person)}, {maker, "lake-run study.yaml", true});
  }
  fs::path Out(const std::string& person) const { return folder_ / "out" / person; }
  std::size_t Solved() const {
    return fs::exists(folder_ / "solved.txt") ? ReadTextFile(folder_ / "solved.txt").size() : 0;
  }
  fs::path Entry() const {
    for (const auto& entry : fs::directory_iterator(folder_ / "cache"))
      if (entry.path().extension() != ".lock") return entry.path();
    return {};
  }
  void ExpectSameBytes() const {
    for (const char* file : {"range.png", "sizes/1.csv"})
      EXPECT_EQ(ReadTextFile(Out("second") / file), ReadTextFile(Out("first") / file)) << file;
    std::string summary = ReadTextFile(Out("second") / "summary.json");
    for (std::size_t at = 0; (at = summary.find("second", at)) != std::string::npos;) summary.replace(at, 6, "first");
    EXPECT_EQ(summary, ReadTextFile(Out("first") / "summary.json")) << "but for whose problem file it was";
  }

  TemporaryFolder folder_;
  int starts_ = 20;
  std::chrono::milliseconds takes_{0};
  bool is_nobodys_ = true, fail_ = false;
  const int before_ = Threads();
};

TEST_F(StepCache, GivesTheSameBytesWithoutTheWork) {
  Go("first");
  Go("second");
  EXPECT_EQ(Solved(), 1u);
  ExpectSameBytes();
}

TEST_F(StepCache, KnowsOtherProblemsOptionsAndPrograms) {
  Go("first");
  WriteTextFile(folder_ / "second" / "problem.txt", "another problem");
  Go("second");
  EXPECT_EQ(Solved(), 2u);
  starts_ = 30;
  Go("first");
  EXPECT_EQ(Solved(), 3u);
  Go("first", "another build");
  EXPECT_EQ(Solved(), 4u);
}

TEST_F(StepCache, DoesAgainWhatWasDamaged) {
  Go("first");
  std::string content = ReadTextFile(Entry());
  const std::string whole = content;
  for (const std::string& damaged :
       {content.substr(0, content.size() / 2), std::string(), std::string("no entry"), content.replace(90, 1, "?")}) {
    WriteTextFile(Entry(), damaged.empty() ? "\n" : damaged);
    fs::remove_all(Out("second"));
    const std::size_t before = Solved();
    Go("second");
    EXPECT_EQ(Solved(), before + 1);
    ExpectSameBytes();
    EXPECT_EQ(ReadTextFile(Entry()), whole) << "mended";
  }
}

TEST_F(StepCache, KeepsNothingOfWhatFailedOrIsSomebodys) {
  fail_ = true;
  EXPECT_THROW(Go("first"), SolverError);
  fail_ = false, is_nobodys_ = false;
  Go("first");
  Go("second");
  EXPECT_EQ(Solved(), 3u);
  is_nobodys_ = true;
  unsetenv("LAKE_CACHE");
  fs::remove_all(folder_ / "out");
  Go("first");
  EXPECT_EQ(Solved(), 4u);
}

TEST_F(StepCache, SaysWhereItCannotWrite) {
  WriteTextFile(folder_ / "file", "");
  setenv("LAKE_CACHE", (folder_ / "file/cache").c_str(), true);
  try {
    Go("first");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("LAKE_CACHE: "));
  }
}

// Several at the same time: one does it, the others wait for it.
TEST_F(StepCache, IsFilledOnceByManyAtTheSameTime) {
  takes_ = std::chrono::milliseconds(200);  // long enough that the second comes while the first is at work
  std::vector<pid_t> children;
  for (const std::string person : {"first", "second"}) {
    const pid_t child = fork();
    if (child == 0) {
      Go(person);
      _exit(0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(Solved(), 1u);
  ExpectSameBytes();
}

}  // namespace
}  // namespace lake
