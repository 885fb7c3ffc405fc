// lake-optimize with several comparisons, as a user calls it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "compare/closed_form.h"
#include "lake/compare/comparison_file.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/linkage/design_file.h"
#include "synthesis/program_run.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// Comparisons of people of different heights, each in a folder of its own.
class LakeOptimizeGroup : public testing::Test {
 protected:
  void AddPerson(const std::string& name, double shank_mm, double seated_knee_deg) {
    ClosedFormLeg leg;
    leg.shank_mm = shank_mm;
    leg.thigh_mm = shank_mm;
    leg.seated_knee_deg = seated_knee_deg;
    compare::MisalignmentOptions options;
    options.intervals = false;
    const compare::Misalignment misalignment = compare::CompareTrials(
        {{MakeCurve(leg)}, {}}, {{MakeCurve(leg, [](double u) { return u; }, {8, 0})}, {}}, options);
    fs::create_directories(folder_ / name / "comparison");
    WriteJsonFile(folder_ / name / "comparison" / "comparison.json", compare::ComparisonJson(misalignment));
  }

  std::string Comparison(const std::string& name) const {
    return fmt::format("--comparison {} ", (folder_ / name / "comparison").string());
  }

  TemporaryFolder folder_;
};

TEST_F(LakeOptimizeGroup, NamesPeopleAfterTheirFoldersAndWritesWhatEachWears) {
  AddPerson("sub-01", 400, 88);
  AddPerson("sub-02", 430, 95);
  const Ended ended =
      RunProgram(fmt::format("{}{}--human-only --max-misalignment 3 --program free --duration 22 --fit-placement "
                             "--grashof-margin 2 --singularity-margin 2 --starts 1 --quiet -o {}",
                             Comparison("sub-01"), Comparison("sub-02"), (folder_ / "out").string()));
  ASSERT_EQ(ended.exit_code, 0) << ended.text;
  const CsvTable people = CsvTable::Read(folder_ / "out/people.csv");
  ASSERT_EQ(people.Rows(), 2u);
  const linkage::Design common = linkage::ReadDesign(folder_ / "out/design.yaml");
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string name = people.Text(i, people.Column("person"));
    EXPECT_EQ(name, fmt::format("sub-0{}", i + 1));
    EXPECT_LE(people.RequiredNumber(i, people.Column("misalignment_percent")), 3 * (1 + 1e-4));
    const linkage::Design own = linkage::ReadDesign(folder_ / "out/people" / name / "design.yaml");
    EXPECT_EQ(own.links.Values(), common.links.Values());
    ASSERT_TRUE(own.program);
    EXPECT_EQ(own.placement_mm[0], people.RequiredNumber(i, people.Column("placement_x_mm")));
    EXPECT_EQ(CsvTable::Read(folder_ / "out/people" / name / "program.csv").Rows(), 101u);
  }
  EXPECT_NEAR(people.RequiredNumber(0, people.Column("shank_mm")), 400, 1e-9);
  const Json summary = ReadJsonFile(folder_ / "out/summary.json");
  EXPECT_EQ(summary["range_deg"].get<double>(), *common.range_deg);
  EXPECT_EQ(summary["inputs"].size(), 2u);
}

TEST_F(LakeOptimizeGroup, SaysWhatDoesNotGoTogether) {
  AddPerson("sub-01", 400, 88);
  AddPerson("sub-02", 430, 95);
  const std::string both = Comparison("sub-01") + Comparison("sub-02");
  ExpectRefused(
      {
          {both, 2, "--worn"},
          {Comparison("sub-01") + Comparison("sub-01") + "--human-only", 2, "is named twice"},
          {both + "--human-only --pareto 5", 2, "--pareto is for one person"},
          {both + "--human-only --quantile 0 --across quantile", 2, "--quantile 0"},
          {both + "--human-only --sizes 2", 2, "at least two people for each; there are 2"},
          {both + "--human-only --sizes 2 --across mean", 2, "omit --across"},
          {Comparison("sub-01") + "--human-only --sizes 2", 2, "at least two people for each; there are 1"},
          {both + "--human-only --participants people.tsv", 2, "--participants is for the rule of --sizes"},
          {both + "--human-only --quantile 0.5", 2, "--quantile is for --across quantile"},
          {Comparison("a_b/c") + Comparison("a/b_c") + "--human-only", 2, "both would be called a_b_c"},
          {both + "--worn a.yaml --worn b.yaml --worn c.yaml", 2, "names 3 designs for 2 comparisons"},
      },
      folder_ / "refused");
}

TEST_F(LakeOptimizeGroup, RefusesHeightsThatNobodyHas) {
  std::string all, table = "participant_id\theight_mm\n";
  for (const char* name : {"sub-01", "sub-02", "sub-03", "sub-04"}) {
    AddPerson(name, 400, 88);
    all += Comparison(name);
    table += fmt::format("{}\t1.71\n", name);
  }
  WriteTextFile(folder_ / "people.tsv", table);
  const Ended ended = RunProgram(fmt::format("{}--human-only --sizes 2 --participants {} --quiet -o {}", all,
                                             (folder_ / "people.tsv").string(), (folder_ / "out").string()));
  EXPECT_EQ(ended.exit_code, 1);
  EXPECT_THAT(ended.text, HasSubstr("people.tsv:2: height_mm 1.71: a person is 500 to 2750 mm tall"));
}

}  // namespace
}  // namespace lake
