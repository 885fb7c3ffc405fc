// The page of a recording's sit-to-stands, as lake-gait writes it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/program_run.h"
#include "lake/core/csv.h"
#include "page_text.h"
#include "places.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

TEST(SitToStandPage, ShowsWhatTheTableHolds) {
  const fs::path trial = SharedData() / "sts_force_plates/STS1.trc";
  if (!fs::exists(trial)) GTEST_SKIP() << trial.string() << " is not here";
  const TemporaryFolder folder;
  const Outcome outcome =
      Shell(folder, fmt::format("lake-gait {} --map ankle=r_ankle,knee=r_knee,hip=R_HJC,waist=r.ASIS+r.PSIS --forward "
                                "x --age 72 --quiet -o G",
                                Quoted(trial)));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string page = ReadPageText(folder / "G/sit_to_stand.html");
  const CsvTable table = CsvTable::Read(folder / "G/sit_to_stand.csv");
  const std::size_t test = table.Rows() - 1, five = table.Column("five_times_s");
  ASSERT_EQ(table.Text(test, 0), "five_times");
  EXPECT_THAT(page, HasSubstr(fmt::format("{:.2f}", table.RequiredNumber(test, five))));
  EXPECT_THAT(page, HasSubstr(fmt::format("{} than average at this age (12.6 s, Bohannon 2006)",
                                          table.RequiredNumber(test, five) > 12.6 ? "worse" : "no worse")));
  for (const char* text : {"rise 5", "five times", "time to sit down (s)", "mean power over body mass (W/kg)"})
    EXPECT_THAT(page, HasSubstr(text));
  EXPECT_THAT(page, Not(HasSubstr(">nan")));
}

}  // namespace
}  // namespace lake
