#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <thread>

#include "home_folder.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/json.h"
#include "lake/core/paths.h"
#include "lake/core/provenance.h"
#include "lake/core/run.h"
#include "lake/core/statistics.h"
#include "lake/core/yaml.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(AtomicFile, AppearsOnlyWhenCommitted) {
  const TemporaryFolder folder;
  {
    const AtomicFile file(folder / "a.txt");
    std::ofstream(file.TemporaryPath()) << "half";
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));
  AtomicFile file(folder / "a.txt");
  std::ofstream(file.TemporaryPath()) << "whole";
  EXPECT_FALSE(std::filesystem::exists(folder / "a.txt"));
  file.Commit();
  EXPECT_EQ(ReadTextFile(folder / "a.txt"), "whole");
}

// Two writers of one name, even in one process, as two runs in one folder would be.
TEST(AtomicFile, HasATemporaryNameOfItsOwnAndTheUsualMode) {
  const TemporaryFolder folder;
  AtomicFile first(folder / "a.txt"), second(folder / "a.txt");
  EXPECT_NE(first.TemporaryPath(), second.TemporaryPath());
  EXPECT_EQ(first.TemporaryPath().extension(), ".txt");
  EXPECT_THAT([&] { first.Commit(); }, ThrowsMessage<Error>(HasSubstr("nothing was written")));
  WriteTextFile(folder / "written", "x");
  std::ofstream(folder / "usual") << "x";
  EXPECT_EQ(std::filesystem::status(folder / "written").permissions(),
            std::filesystem::status(folder / "usual").permissions());
}

TEST(AtomicFile, SaysWhenItCannotBeWritten) {
  const TemporaryFolder folder;
  EXPECT_THAT([&] { WriteTextFile(folder / "none" / "a.txt", "x"); },
              ThrowsMessage<Error>(HasSubstr("cannot be written")));
}

// It is waited for, as cat does, and the first signal ends the waiting.
TEST(TextFile, MayBeAPipe) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder / "pipe.csv";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&pipe] { std::ofstream(pipe) << "late"; });
  EXPECT_EQ(ReadTextFile(pipe), "late");
  writer.join();
  const auto interrupted = [&pipe] {
    CatchInterrupts();
    std::raise(SIGTERM);
    try {
      ReadTextFile(pipe);
    } catch (const Interrupted& end) {
      std::_Exit(end.Signal() == SIGTERM ? 0 : 1);
    }
    std::_Exit(2);
  };
  EXPECT_EXIT(interrupted(), testing::ExitedWithCode(0), "");
  EXPECT_THAT([&] { WriteTextFile(pipe, "x"); }, ThrowsMessage<Error>(HasSubstr("is a pipe or a device")));
}

TEST(Run, SummaryHoldsWhatMadeTheResult) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "in.txt", "abc");
  lake::Run run({"lake-x", "lake-x in.txt", {{"a", "1"}}, folder / "out", true});
  run.AddInput(folder / "in.txt", "text");
  run.Warn("dim");
  EXPECT_THROW(run.WriteSummary({{"answer", 42}, {"program", "of the stroke"}}), std::logic_error);
  run.WriteSummary({{"answer", 42}});
  const Json summary = ReadJsonFile(folder / "out" / "summary.json");
  EXPECT_EQ(summary["program"], "lake-x");
  EXPECT_EQ(summary["version"], Version());
  EXPECT_EQ(summary["commit"], Commit());
  EXPECT_EQ(summary["tree"], SourceTree());
  EXPECT_EQ(summary["warnings"][0], "dim");
  EXPECT_EQ(summary["given"], Json::array());
  EXPECT_EQ(summary["answer"], 42);
  // FIPS 180-2, appendix B.1.
  EXPECT_EQ(summary["inputs"][0]["role"], "text");
  EXPECT_EQ(summary["inputs"][0]["sha256"], "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

// A study's two trials are of the same program.
TEST(Run, AStepsWarningNamesTheStep) {
  const TemporaryFolder folder;
  lake::Run run({"lake-track", "lake-run study.yaml", Json::object(), folder / "out", true, {}, false, "human"});
  testing::internal::CaptureStderr();
  run.Warn("dim");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "lake-track: warning: human: dim\n");
  EXPECT_EQ(run.Warnings().front(), "dim") << "the step's own summary";
}

TEST(Paths, LieInAFolder) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  std::filesystem::create_directories(out / "human");
  std::filesystem::create_symlink(out, folder / "link");
  EXPECT_TRUE(LiesIn(out / "human/absent.csv", out));
  EXPECT_TRUE(LiesIn(out, out));
  EXPECT_TRUE(LiesIn(out, out / ""));
  EXPECT_TRUE(LiesIn(out / "human/../a.csv", out));
  EXPECT_TRUE(LiesIn(folder / "link/human", out));
  EXPECT_FALSE(LiesIn(folder / "outside", out)) << "begins with its name";
  EXPECT_FALSE(LiesIn(folder.Path(), out));
  EXPECT_FALSE(LiesIn(out / "../a.csv", out));
}

TEST(Provenance, DoesNotNameTheHomeFolder) {
  const TemporaryFolder folder;
  const std::filesystem::path home = folder / "anna";
  const HomeFolder there(home.string() + "/");
  std::filesystem::create_directory(home);
  WriteTextFile(home / "in.txt", "abc");
  const std::string input = (home / "in.txt").string(), other = (folder / "annabel/in.txt").string();
  EXPECT_EQ(WithoutHome(home.string()), "~");
  EXPECT_EQ(WithoutHome("lake-x " + input + " --camera='" + input + "' " + other),
            "lake-x ~/in.txt --camera='~/in.txt' " + other);
  EXPECT_EQ(FromHome("~/in.txt"), input);
  EXPECT_EQ(FromHome("~anna/in.txt"), "~anna/in.txt");

  lake::Run run({"lake-x", "lake-x " + input, {{"files", {input, input}}}, home / "out", true, {input}});
  run.AddInput(input, "text");
  run.WriteSummary(Json::object());
  for (const auto& file : std::filesystem::directory_iterator(home / "out"))
    EXPECT_THAT(ReadTextFile(file.path()), testing::Not(HasSubstr("anna"))) << file.path();
}

// A summary names an input so that FromHome() finds it again, whatever it is called.
TEST(Provenance, InputsWithOddNamesAreFoundAgain) {
  const TemporaryFolder folder;
  const std::filesystem::path home = folder.Path() / "anna", before = std::filesystem::current_path();
  const HomeFolder anna(home);
  const std::filesystem::path within = folder.Path().string() + "/odd:" + home.string() + "/in.txt";
  for (const std::filesystem::path& file : {folder.Path() / "~/in.txt", within}) {
    std::filesystem::create_directories(file.parent_path());
    WriteTextFile(file, "x");
  }
  std::filesystem::current_path(folder.Path());
  for (const std::filesystem::path& file : {std::filesystem::path("~/in.txt"), within}) {
    lake::Run run({"lake-x", "lake-x", Json::object(), folder.Path() / "out", true});
    run.AddInput(file, "text");
    const Json summary = run.WriteSummary(Json::object());
    EXPECT_TRUE(std::filesystem::equivalent(FromHome(summary["inputs"][0]["path"].get<std::string>()), file)) << file;
  }
  std::filesystem::current_path(before);
}

TEST(Provenance, OfAPipeCannotBeTold) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder / "pipe.csv";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  lake::Run run({"lake-x", "lake-x", Json::object(), folder / "out", true});
  EXPECT_THAT([&] { run.AddInput(pipe, "text"); }, ThrowsMessage<Error>(HasSubstr("save it as a file")));
}

TEST(Provenance, CommitIsKnownInACloneAndUnknownElsewhere) {
  const bool known = Commit() != "unknown";
  EXPECT_EQ(Commit().size(), known ? 40u : 7u);
  EXPECT_THAT(SourceTree(), known ? AnyOf("clean", "changed") : AnyOf("unknown", "unknown"));
  EXPECT_EQ(VersionAndCommit(), fmt::format("{} (commit {}, {})", Version(), Commit().substr(0, 12), SourceTree()));
}

// A program in bin/ and the library that it loads from lib/lake/.
std::string HashOf(const std::filesystem::path& folder, std::string_view library) {
  std::filesystem::create_directories(folder / "bin");
  std::filesystem::create_directories(folder / "lib/lake");
  WriteTextFile(folder / "bin/lake-x", "the program");
  WriteTextFile(folder / "lib/lake/liblake.so", std::string(library));
  return Sha256OfProgram(folder / "bin/lake-x");
}

TEST(Provenance, ProgramsThatDifferInTheirCommitAloneAreTheSame) {
  const TemporaryFolder folder;
  const std::filesystem::path bin = std::filesystem::canonical("/proc/self/exe").parent_path();
  const std::filesystem::path file = bin.parent_path() / "lib/lake/liblake.so";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "only the programs that read are built here: no " << file;
  std::string library = ReadTextFile(file);
  const std::string own = HashOf(folder / "own", library);
  std::string commit(Commit());
  commit.resize(48);  // as it stands in the file, padded
  ASSERT_NE(library.find(commit), std::string::npos);
  library.replace(library.find(commit), 7, "another");
  EXPECT_EQ(HashOf(folder / "other_commit", library), own);
  library[library.size() / 2] ^= 1;
  EXPECT_NE(HashOf(folder / "other_code", library), own);
}

TEST(Run, RefusesAFileAsItsFolder) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "out", "abc");
  lake::Run run({"lake-x", "", {}, folder / "out", true});
  EXPECT_THAT([&] { run.Result("a.csv"); }, ThrowsMessage<Error>(HasSubstr("output folder")));
}

TEST(Yaml, NamesFileLineAndKey) {
  const TemporaryFolder folder;
  const auto root = [&](const char* text) {
    WriteTextFile(folder / "p.yaml", text);
    return YamlNode::ReadFile(folder / "p.yaml");
  };
  YamlNode node = root("d_min_mm: 242\nmargins:\n  grashof_mm: 1\n  typo_mm: 2\nlist: [1, 2]\n");
  EXPECT_EQ(node.Number("d_min_mm"), 242);
  EXPECT_EQ(node.Number("absent"), std::nullopt);
  EXPECT_THAT([&] { node.Numbers("list", 3); },
              ThrowsMessage<Error>(HasSubstr("p.yaml:5: 'list' must have 3 numbers, not 2")));
  auto margins = node.Child("margins");
  margins->Number("grashof_mm");
  EXPECT_THAT([&] { margins->Finish(); },
              ThrowsMessage<Error>(HasSubstr("p.yaml:4: unknown key 'typo_mm'; known here: grashof_mm")));
  node.Finish();
  EXPECT_THAT([&] { root("a: .nan\n").Number("a"); },
              ThrowsMessage<Error>(HasSubstr("p.yaml:1: '.nan' is not a finite number")));
  EXPECT_EQ(root("a: 1e-320\n").Number("a"), 0.0) << "no solver can work with it";
  EXPECT_EQ(root("a: 1e-300\n").Number("a"), 1e-300);
  EXPECT_THAT([&] { root("a: [1\n"); }, ThrowsMessage<Error>(HasSubstr("not YAML")));
  EXPECT_THAT([&] { root("- 1\n").Number("a"); },
              ThrowsMessage<Error>(HasSubstr("'the file' must have keys, such as a")));
}

TEST(Yaml, RefusesAKeyThatStandsTwice) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "p.yaml", "a: 1\nb:\n  - c: 1\n    d: 2\n    c: 3\n");
  EXPECT_THAT([&] { YamlNode::ReadFile(folder / "p.yaml"); },
              ThrowsMessage<Error>(HasSubstr("p.yaml:5: key 'c' stands twice, first in line 3")));
}

std::string Repeated(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

// Small files that would keep a reader busy for years, or end its stack.
TEST(Yaml, RefusesBombs) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    WriteTextFile(folder / "p.yaml", text);
    YamlNode::ReadFile(folder / "p.yaml");
  };
  std::string laughs = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i)
    laughs += fmt::format("a{}: &a{} [{}x]\n", i, i, Repeated(fmt::format("*a{}, ", i - 1), 9));
  EXPECT_THAT([&] { read(laughs); }, ThrowsMessage<Error>(HasSubstr("more than 100000 values")));
  EXPECT_THAT([&] { read("a: &a [*a]\n"); }, ThrowsMessage<Error>(HasSubstr("more than 100 deep")));
  EXPECT_THAT([&] { read("a: &a {b: *a}\n"); }, ThrowsMessage<Error>(HasSubstr("more than 100 deep")));
  EXPECT_THAT([&] { read("a: [" + Repeated("x,", 1 << 20) + "x]"); }, ThrowsMessage<Error>(HasSubstr("larger than")));
  for (const char* opening : {"[", "{b: ", "- ", "? "})
    EXPECT_THAT([&] { read("a:\n " + Repeated(opening, 100'000) + "x\n"); }, ThrowsMessage<Error>(HasSubstr("p.yaml")));
  EXPECT_NO_THROW(read("a: &a {b: 1}\nc: *a\nd: *a\n"));
}

TEST(Statistics, KnownValues) {
  const std::vector<double> values = {1, 2, 3, 4, 100};
  EXPECT_EQ(Median(values), 3);
  EXPECT_EQ(Quantile(values, 0.25), 2);
  EXPECT_DOUBLE_EQ(Quantile(values, 0.9), 4 + 0.6 * 96);
  EXPECT_DOUBLE_EQ(RobustDeviation(values), 1.4826);
  EXPECT_DOUBLE_EQ(RootMeanSquare(std::vector<double>{3, -4}), std::sqrt(12.5));
  EXPECT_DOUBLE_EQ(StandardDeviation(std::vector<double>{1, 3}), std::sqrt(2.0));
  EXPECT_TRUE(std::isnan(Median({})));
}

TEST(Interrupt, ThrowsOnceASignalHasArrived) {
  CatchInterrupts();
  EXPECT_NO_THROW(ThrowIfInterrupted());
  EXPECT_EXIT(
      {
        std::raise(SIGTERM);
        try {
          ThrowIfInterrupted();
        } catch (const Interrupted& interrupted) {
          std::_Exit(interrupted.Signal());
        }
      },
      testing::ExitedWithCode(SIGTERM), "");
}

TEST(Json, RefusesNumbersBeyondAllNumbers) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "huge.json", "{\"a\": 1e999}");
  EXPECT_THAT([&] { ReadJsonFile(folder / "huge.json"); }, ThrowsMessage<Error>(HasSubstr("huge.json: not JSON: ")));
}

TEST(Json, ThatIsNestedWithoutEndIsRefused) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "deep.json", "{\"a\": " + std::string(200'000, '[') + std::string(200'000, ']') + "}");
  EXPECT_THAT([&] { ReadJsonFile(folder / "deep.json"); },
              ThrowsMessage<Error>(HasSubstr("deep.json: lists and maps")));
  WriteTextFile(folder / "text.json", "{\"a\": \"\\\"" + std::string(300, '[') + "\"}");
  EXPECT_EQ(ReadJsonFile(folder / "text.json")["a"].get<std::string>().size(), 301u) << "brackets of a text";
}

}  // namespace
}  // namespace lake
